// What a renderer returns: the image, and what it took to make it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "splat/deep_image.h"
#include "splat/export.h"
#include "splat/image.h"

namespace SWEPT_API swept {

/// Counts and stage times of one render, in the order in which the renderer added them. The command line only
/// formats them.
struct Statistics {
  std::vector<std::pair<std::string, double>> counters;  ///< name and value, e.g. "fragments"
  std::vector<std::pair<std::string, double>> seconds;   ///< stage and its wall time, s
  std::vector<std::string> effects;  ///< which effects ran, and which were skipped and why

  void count(std::string name, double value) { counters.emplace_back(std::move(name), value); }
  void time(std::string stage, double wall_seconds) { seconds.emplace_back(std::move(stage), wall_seconds); }
  void effect(std::string what) { effects.push_back(std::move(what)); }

  /// The value of a counter; nothing if the render does not have it.
  [[nodiscard]] std::optional<double> counter(std::string_view name) const {
    for (const auto& [key, value] : counters)
      if (key == name) return value;
    return std::nullopt;
  }
};

/// A rectangle of the film, px, and the number of instants that were rendered there.
struct FilmPart {
  int x = 0, y = 0, width = 0, height = 0;
  int instants = 0;
};

struct Rendered {
  Image image;
  Statistics statistics;
  std::vector<FilmPart> parts = {};  ///< cover the window; empty: the renderer does not have them
  /// The image by depth, if the renderer was asked for it (AbufferOptions::deep).
  std::optional<DeepImage> deep = {};
};

}  // namespace swept
