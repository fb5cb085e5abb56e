// Scenes of Gaussian splats that nobody chose, to judge what was fitted to others.
#pragma once

#include "splat/scene.h"

namespace swept {

/// The seed decides how many splats there are, how large they are, and what moves how far: the camera
/// sideways, around or into them, their object, or each by itself. 192 × 128 px, one frame of exposure.
[[nodiscard]] Scene random_splat_scene(unsigned seed);

}  // namespace swept
