// At which frames a path has to be looked at to be followed.
#pragma once

#include <vector>

#include "splat/exposure.h"
#include "splat/scene.h"

namespace swept {

/// Frames from the exposure's open to its close, so near each other that a path hardly bends between them:
/// all keys are among them, and `of_points`. Nothing where that would be too many to follow.
[[nodiscard]] std::vector<double> path_frames(const Scene& scene, const Object& object,
                                              const std::vector<double>& of_points, const Exposure& exposure);

}  // namespace swept
