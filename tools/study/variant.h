// One scene as the study renders it: a scene file, and what of it is scaled.
#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "splat/io/scene_file.h"
#include "splat/result.h"

namespace swept {

struct Variant {
  std::string id;                    ///< names its folder
  std::string title;                 ///< of the scene, for people
  std::string file;                  ///< a scene file
  std::array<int, 2> size = {0, 0};  ///< of the film, px; 0: as the file says
  double points_scale = 1.0;         ///< of generated objects
  double exposure_scale = 1.0;       ///< of the shutter's open time, about its middle
};

/// Reads the scene file with what the variant changes in it.
[[nodiscard]] Result<SceneFile> open_variant(const Variant& variant);

/// What is known of a scene before anything is rendered.
struct VariantFacts {
  std::size_t points = 0;
  int width = 0, height = 0;  ///< of the film's window, px
  std::string hash;           ///< of file and overrides
  bool scalable = false;      ///< all of its objects are generated, so that points_scale acts on all
  /// How far points on the film move while the shutter is open, from where they are when it opens to where
  /// they are when it closes, px; of points in front of the near plane at both.
  double motion_median_px = 0.0, motion_largest_px = 0.0;
};

[[nodiscard]] Result<VariantFacts> facts_of(const Variant& variant);

}  // namespace swept
