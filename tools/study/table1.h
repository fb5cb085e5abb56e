// Table 1 of Heinzle et al. 2010, redone: sub-frames of motion against still frames, at equal quality.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "splat/result.h"
#include "tools/study/runner.h"

namespace swept {

/// A row of the paper's table.
struct PaperRow {
  std::string figure;
  std::string scene;  ///< ours that stands in for it
  std::size_t points = 0;
  int subframes = 0;
  double subframe_mpoints_per_s = 0.0;
  int stills = 0;  ///< the paper's choice for "similar visual quality"
  double still_mpoints_per_s = 0.0;
};

[[nodiscard]] const std::vector<PaperRow>& paper_table1();

/// Still frames, the fewest that are as good as the sub-frames by one measure.
struct EqualQuality {
  int stills = 0;
  double seconds = 0.0, ratio = 0.0;  ///< of their time to that of the sub-frames
};

struct Table1Row {
  PaperRow paper;
  Task task;
  std::string error;  ///< why there are no figures; empty: there are
  std::size_t points = 0;
  double seconds = 0.0, psnr_db = 0.0, ssim = 0.0;     ///< of the sub-frames
  std::optional<EqualQuality> equal_psnr, equal_ssim;  ///< nothing: not even `most_stills` are as good
};

/// Stills beyond which is not searched.
inline constexpr int most_stills = 256;

/// Runs one row. `task` is the row's scene; its settings are not used. The error is of the runner.
[[nodiscard]] Result<Table1Row> run_table1_row(Runner& runner, const PaperRow& paper, const Task& task);

[[nodiscard]] nlohmann::ordered_json to_json(const Table1Row& row);

}  // namespace swept
