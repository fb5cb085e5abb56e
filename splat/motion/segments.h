// Into how many linear segments a path has to be cut.
#pragma once

#include "splat/export.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// The most segments that are chosen unasked.
inline constexpr int max_chosen_segments = 64;

/// Whether every object, its points and the camera keep their bits over the whole exposure, or it is an
/// instant.
[[nodiscard]] bool nothing_moves(const Scene& scene, const Exposure& exposure);

/// Shutter time at which segment `s` of so many begins: they are equally long in time.
[[nodiscard]] double segment_time(const Exposure& exposure, int s, int segments);
/// And in the middle of its light.
[[nodiscard]] double segment_middle(const Exposure& exposure, int s, int segments);

/// How many linear segments build_kernels() cuts the paths of `object` into over the exposure, where it cuts
/// all its points alike:
/// Object::segments, else ImageModel::segments, else as many as keep the chords of every point's true path
/// within 0.1 px of it on the film (and so segments within 0.07 px) and the discs' rims within 0.25 px on
/// average, up to max_chosen_segments. That is judged by a sample of about a thousand points, which depends
/// on the points and not on their order. 1 where nothing moves. `scene` must satisfy validate().
[[nodiscard]] int linear_segments(const Scene& scene, const Object& object, const Exposure& exposure);

/// The same where that is how it is done, and else, where points are cut one by one (cuts_by_point()), the
/// most that any of the sample takes.
[[nodiscard]] int most_segments(const Scene& scene, const Object& object, const Exposure& exposure);

}  // namespace swept
