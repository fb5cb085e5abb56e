// Which files a scene is read from. For splat/io's own sources and the command.
#pragma once

#include <string>
#include <vector>

#include "splat/export.h"
#include "splat/io/scene_file.h"

namespace SWEPT_API swept {
namespace io {

/// Files without which that of `source` at `path` is not read whole: images of an unpacked .sog, materials
/// and their textures.
[[nodiscard]] std::vector<std::string> files_beside(const ObjectSource& source, const std::string& path);

/// Paths of the files that SceneFile::scene_at(frame) reads: points, what lies beside them, and textures.
/// Errors: as source_files().
[[nodiscard]] Result<std::vector<std::string>> files_read(const SceneFile& file, double frame);

}  // namespace io
}  // namespace swept
