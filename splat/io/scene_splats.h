// Files of trained splats as objects of a scene. Private to splat/io.
#pragma once

#include "splat/io/scene_file.h"
#include "splat/io/splat_file.h"
#include "splat/result.h"

namespace swept::io {

/// Whether the object's file, or the first of its sequence, is to be read as splats.
[[nodiscard]] bool draws_splats(const ObjectSource& source);

/// Precondition: draws_splats(source). Velocities come out per frame, at the file's frame; of a sequence the
/// file is that of `scene.frame`, and no other: splats of two files are not the same ones. Errors: as
/// read_splats(); what belongs to discs, with a field of the object and without a file.
[[nodiscard]] Result<LoadedSplats> load_splats(const ObjectSource& source, const Object& object,
                                               const Scene& scene);

}  // namespace swept::io
