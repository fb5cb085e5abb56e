// The form of the head: a unit sphere pushed and pulled into a face.
#pragma once

#include <Eigen/Core>

namespace swept::datasets {

/// Where a direction of the unit sphere (x to the head's left, y up, z out of the face) ends up.
[[nodiscard]] Eigen::Vector3d head_form(const Eigen::Vector3d& direction);

/// How much hair grows there: 0 bare skin, 1 hair.
[[nodiscard]] double hair_at(const Eigen::Vector3d& direction);

/// Colour of the skin with lips, brows, cheeks and hair painted on.
[[nodiscard]] Eigen::Vector3d head_color(const Eigen::Vector3d& direction, const Eigen::Vector3d& skin,
                                         const Eigen::Vector3d& hair);

}  // namespace swept::datasets
