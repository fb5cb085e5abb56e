#include "splat/io/point_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <new>
#include <string_view>

#include "splat/io/file_bytes.h"
#include "splat/io/guarded.h"
#include "splat/io/read_formats.h"

namespace swept {

namespace {

using Reader = Result<PointSet> (*)(const std::string&, std::string_view, const ReadOptions&);

/// That of the name's extension; null: there is none.
Reader reader_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  // Letters of ASCII only, whatever the locale.
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  constexpr std::array<std::string_view, 7> text{".xyz", ".txt", ".asc", ".csv", ".pts", ".xyzn", ".xyzrgb"};
  const bool is_text = std::find(text.begin(), text.end(), extension) != text.end();
  return extension == ".ply"   ? read_ply
         : extension == ".pcd" ? read_pcd
         : is_text             ? read_xyz
         : extension == ".obj" ? read_obj
         : extension == ".off" ? read_off
                               : nullptr;
}

}  // namespace

bool is_point_file_name(const std::string& path) { return reader_of(path) != nullptr; }

Result<PointSet> read_points(const std::string& path, const ReadOptions& options) {
  return io::guarded(path, [&]() -> Result<PointSet> {
    const Reader read = reader_of(path);
    if (!read) {
      return Error{
          path, "",
          "its extension is none of .ply .pcd .obj .off, or of text .xyz .txt .asc .csv .pts .xyzn .xyzrgb",
          ErrorKind::unsupported};
    }
    const Result<std::string> bytes = read_bytes(path);
    if (!bytes) return bytes.error();
    // Some write a byte order mark before UTF-8.
    constexpr std::string_view mark = "\xef\xbb\xbf";
    std::string_view content = *bytes;
    if (read != read_pcd && read != read_ply && content.substr(0, mark.size()) == mark)
      content.remove_prefix(mark.size());
    try {
      return read(path, content, options);
    } catch (const std::bad_alloc&) {
      return Error{path, "", "its points do not fit into memory", ErrorKind::out_of_memory};
    }
  });
}

}  // namespace swept
