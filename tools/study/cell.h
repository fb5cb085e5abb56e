// One cell of the study: a setting on a scene, with all that was measured. Kept on disk, so that a study that
// was stopped goes on where it was.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "splat/image.h"
#include "splat/result.h"
#include "tools/study/methods.h"

namespace swept {

/// How far an image is from the reference; see ImageMetrics and mean_flip.
struct Accuracy {
  double rmse = 0.0, psnr_db = 0.0;  ///< +∞ for images that are equal
  double ssim = 0.0, flip = 0.0;
  double max_abs = 0.0;
  int max_abs_x = 0, max_abs_y = 0;
  double share_over_1_255 = 0.0;
};

/// Errors: windows that differ, and pixels that are not finite.
[[nodiscard]] Result<Accuracy> accuracy_of(const Image& image, const Image& reference);

struct Cell {
  Setting setting;
  std::string key;    ///< of all that the figures depend on; figures with another key are out of date
  std::string error;  ///< why there are none; empty: there are
  std::optional<Accuracy> accuracy;
  std::vector<double> seconds;  ///< one per repeat, in the order in which they ran
  std::optional<double> fragments, events, rays;
  double peak_memory_bytes = 0.0;
  std::string device;
  std::optional<double> reference_rmse, reference_psnr_db;  ///< of the reference: its own error

  [[nodiscard]] bool done(std::size_t repeats) const { return error.empty() && seconds.size() >= repeats; }
};

struct Spread {
  double median = 0.0, least = 0.0, most = 0.0;
};
/// Of at least one value.
[[nodiscard]] Spread spread_of(std::vector<double> values);

/// The cell as the study's document shows it, without images.
[[nodiscard]] nlohmann::ordered_json to_json(const Cell& cell);

/// Nothing if there is no such file, or one of another key.
[[nodiscard]] std::optional<Cell> load_cell(const std::string& path, const std::string& key);
[[nodiscard]] Status save_cell(const std::string& path, const Cell& cell);

}  // namespace swept
