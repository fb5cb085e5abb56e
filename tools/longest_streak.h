// How far points travel across the film while the shutter is open.
#pragma once

#include "splat/scene.h"

namespace swept {

/// The longest path of a point's centre on the film during the exposure, px, points, object and camera
/// moving: the sum of the chords between 9 instants, of those chords of which an end lies in the film's
/// window. 0 if none does, or nothing moves.
[[nodiscard]] double longest_streak_px(const Scene& scene, const Object& object);

}  // namespace swept
