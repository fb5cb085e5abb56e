// Colours and opacities that change from file to file of a sequence (model section 1.8).
#pragma once

#include <vector>

#include "splat/io/cloud_source.h"

namespace swept::io {

/// What the points of `cloud` look like in a file of its sequence, `color` and `opacity` being that file's in
/// the cloud's order. Arrays are left empty where the file has the cloud's own: because they are equal, the
/// file has none, or the source says itself what colours are.
[[nodiscard]] LookKey look_of(const CloudSource& source, const SurfelCloud& cloud, double frame,
                              std::vector<Eigen::Vector3f> color, std::vector<float> opacity);

/// Gives the cloud looks that look_of() made, unless all are its own.
void take_looks(std::vector<LookKey> looks, SurfelCloud& cloud);

/// What a person should know of looks that change; empty where none do.
[[nodiscard]] std::string what_changes(const SurfelCloud& cloud);

}  // namespace swept::io
