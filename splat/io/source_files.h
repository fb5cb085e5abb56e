// Which files an object's points are in while the shutter is open. For splat/io's own sources.
#pragma once

#include <vector>

#include "splat/io/cloud_source.h"
#include "splat/io/scene_file.h"

namespace swept::io {

/// The files that hold the points over [first, last]: both of a pair, and of a sequence those at or before,
/// at or after, and between; none of a generator. They all exist. The error's field is the member of the
/// source that is at fault, or empty.
[[nodiscard]] Result<std::vector<KeyFile>> source_files(const ObjectSource& source, double first,
                                                        double last);

}  // namespace swept::io
