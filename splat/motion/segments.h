// The number of linear segments that a path is cut into.
#pragma once

#include "splat/export.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// The most segments that are chosen where nobody gives a number.
inline constexpr int max_chosen_segments = 64;

/// Whether the exposure is an instant, or every object, its points and the camera keep their bits over it.
[[nodiscard]] bool nothing_moves(const Scene& scene, const Exposure& exposure);

/// Shutter time at which segment `s` of `segments` begins; all are equally long in frames.
[[nodiscard]] double segment_time(const Exposure& exposure, int s, int segments);
/// Shutter time in the middle of the light of that segment.
[[nodiscard]] double segment_middle(const Exposure& exposure, int s, int segments);

/// How many linear segments build_kernels() cuts the paths of `object` into over the exposure, if it cuts
/// those of all its points alike. That is Object::segments, else ImageModel::segments, else as many as keep
/// the chords of every point's path within 0.1 px of it on the film (and so segments within 0.07 px) and the
/// discs' rims within 0.25 px on average, up to max_chosen_segments. The latter is judged by a sample of
/// about a thousand points, which depends on the points and not on their order. 1 if nothing moves.
/// Precondition: scene.validate().
[[nodiscard]] int linear_segments(const Scene& scene, const Object& object, const Exposure& exposure);

/// linear_segments() if the object's points are cut alike. If they are cut one by one (cuts_by_point()), the
/// most segments that any point of the sample takes.
[[nodiscard]] int most_segments(const Scene& scene, const Object& object, const Exposure& exposure);

}  // namespace swept
