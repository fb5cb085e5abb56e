// The points of a thin lens that a scene is seen through (model section 16). Functions that return vectors
// throw std::bad_alloc.
#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "splat/camera.h"
#include "splat/export.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// The most points of a lens.
inline constexpr int most_lens_points = 4096;

/// `count` points that are spread evenly over the aperture (a disc, or a regular polygon of `blades` corners
/// within it), in world units from its middle along the camera's x and y axes. One point: the middle.
[[nodiscard]] std::vector<Eigen::Vector2d> lens_points(const Aperture& aperture, int count);

/// Maps the unit square to the aperture, evenly by area: the point at √area_share of the way from the middle
/// to the edge, after `turns` of a full turn around the aperture. Both in [0, 1). World units, as
/// lens_points().
[[nodiscard]] Eigen::Vector2d point_on_lens(const Aperture& aperture, double area_share, double turns);

/// Diameter, px, to which the lens spreads a point at the depth z: aperture · focal_px · |1/z − 1/focus|.
/// `aperture` is the lens's diameter; `aperture`, `focus` and `z` are in world units.
[[nodiscard]] double circle_of_confusion_px(double aperture, double focal_px, double focus, double z);

/// The number of points of the scene's lens: 1 without a lens; Aperture::samples if that is given; else eight
/// for each pixel of the largest circle of confusion on the film at the middle of the exposure, at least 64
/// and at most 1024.
[[nodiscard]] int lens_point_count(const Scene& scene);

/// For a renderer without a lens: an error if the scene has one, "…, which `renderer` does not do".
[[nodiscard]] Status refuse_lens(const Scene& scene, std::string_view renderer);

}  // namespace swept
