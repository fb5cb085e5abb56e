// A thin lens as points that it is looked through (model section 16). Functions that return vectors throw
// std::bad_alloc.
#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "splat/camera.h"
#include "splat/export.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// Most points that a lens is looked through.
inline constexpr int most_lens_points = 4096;

/// `count` points spread evenly over the aperture, in world units from its middle along the camera's x and y
/// axes: a disc, or a regular polygon of `blades` corners within it. One point: the middle.
[[nodiscard]] std::vector<Eigen::Vector2d> lens_points(const Aperture& aperture, int count);

/// The point of the aperture within which lies that share of its area, of points nearer to its middle on the
/// same way out, and so many turns around it; both in [0, 1). What fills the square evenly fills the
/// aperture.
[[nodiscard]] Eigen::Vector2d point_on_lens(const Aperture& aperture, double area_share, double turns);

/// Diameter, px, to which the lens spreads a point at that depth: aperture · focal length · |1/z − 1/focus|.
[[nodiscard]] double circle_of_confusion_px(double aperture, double focal_px, double focus, double z);

/// How many points the scene's lens is looked through: 1 without one; as many as its aperture says; else
/// eight for each pixel of the largest circle of confusion on the film at the middle of the exposure, at
/// least 64 and at most 1024.
[[nodiscard]] int lens_point_count(const Scene& scene);

/// An error that names the lens, of a renderer that has none: "…, which `renderer` does not do".
[[nodiscard]] Status refuse_lens(const Scene& scene, std::string_view renderer);

}  // namespace swept
