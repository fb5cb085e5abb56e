// Files of trained splats as objects of a scene. Private to splat/io.
#pragma once

#include "splat/io/scene_file.h"
#include "splat/io/splat_file.h"
#include "splat/result.h"

namespace swept::io {

/// Whether the object's file is to be read as splats.
[[nodiscard]] bool draws_splats(const ObjectSource& source);

/// Precondition: draws_splats(source). Velocities come out per frame, at the source's frame. Errors: as
/// read_splats(); what belongs to discs, with a field of the object and without a file.
[[nodiscard]] Result<LoadedSplats> load_splats(const ObjectSource& source, const Object& object,
                                               const FrameRate& fps);

}  // namespace swept::io
