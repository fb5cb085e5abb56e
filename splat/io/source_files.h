// Which files an object's points are in while the shutter is open. For splat/io's own sources.
#pragma once

#include <string>
#include <vector>

#include "splat/io/cloud_source.h"
#include "splat/io/scene_file.h"

namespace swept::io {

struct SourceFiles {
  std::vector<KeyFile> files;
  std::string note;  ///< which files there are, where that was looked up; empty: it was said
};

/// The files that hold the points while `scene` is exposed: both of a pair, and of a sequence those at or
/// before, at or after, and between, with one more on either side for a spline; none of a generator. They all
/// exist. The error's field is the member of the source that is at fault, or empty.
[[nodiscard]] Result<SourceFiles> source_files(const ObjectSource& source, const Scene& scene);

}  // namespace swept::io
