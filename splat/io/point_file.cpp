#include "splat/io/point_file.h"

#include <algorithm>
#include <filesystem>

#include "splat/io/file_bytes.h"
#include "splat/io/read_formats.h"

namespace swept {

Result<PointSet> read_points(const std::string& path, const ReadOptions& options) {
  std::string extension = std::filesystem::path(path).extension().string();
  // Letters of ASCII only, whatever the locale.
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  const auto read = extension == ".ply"                          ? read_ply
                    : extension == ".pcd"                        ? read_pcd
                    : extension == ".xyz" || extension == ".txt" ? read_xyz
                    : extension == ".obj"                        ? read_obj
                    : extension == ".off"                        ? read_off
                                                                 : nullptr;
  if (!read) {
    return Error{path, "", "its extension is none of .ply .pcd .xyz .txt .obj .off"};
  }
  const Result<std::string> bytes = read_bytes(path);
  if (!bytes) return bytes.error();
  return read(path, *bytes, options);
}

}  // namespace swept
