#include "splat/io/splat_file.h"

#include <filesystem>
#include <fstream>
#include <string_view>
#include <utility>

#include "splat/io/file_bytes.h"
#include "splat/io/guarded.h"
#include "splat/io/read_splats.h"

namespace swept {
namespace {

using Reader = Result<LoadedSplats> (*)(const std::string&, std::string_view, const SplatReadOptions&);

constexpr std::pair<std::string_view, Reader> readers[] = {
    {".ply", io::read_splat_ply}, {".splat", io::read_splat},    {".spz", io::read_spz},
    {".sog", io::read_sog},       {".glb", io::read_splat_gltf}, {".gltf", io::read_splat_gltf}};

std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  // Letters of ASCII only, whatever the locale.
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

/// That of the name's extension; null: there is none.
Reader reader_of(const std::string& path) {
  const std::string extension = extension_of(path);
  for (const auto& [name, reader] : readers)
    if (name == extension) return reader;
  if (io::is_sog_meta(path)) return io::read_sog_folder;
  return nullptr;
}

/// The header of a PLY file, if it ends within the first 64 KiB.
std::string head_of(const std::string& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return {};
  std::string head(std::size_t{1} << 16, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head;
}

}  // namespace

bool is_splat_file_name(const std::string& path) {
  return extension_of(path) != ".ply" && reader_of(path) != nullptr;
}

bool holds_splats(const std::string& path) {
  if (is_splat_file_name(path)) return true;
  if (!reader_of(path)) return false;
  const Result<bool> splats = io::guarded(path, [&]() -> Result<bool> {
    const Result<PlyHeader> header = parse_ply_header(path, head_of(path));
    return header && io::declares_splats(*header);
  });
  return splats && *splats;
}

Result<LoadedSplats> read_splats(const std::string& path, const SplatReadOptions& options) {
  return io::guarded(path, [&]() -> Result<LoadedSplats> {
    const Reader read = reader_of(path);
    if (!read) {
      std::string known;
      for (const auto& [name, reader] : readers) (known += ' ') += name;
      known += ", nor is it the meta.json of a .sog";
      return Error{path, "", "its extension is none of" + known, ErrorKind::unsupported};
    }
    return io::guarded(path, [&]() -> Result<LoadedSplats> {
      const Result<std::string> bytes = read_bytes(path);
      if (!bytes) return bytes.error();
      return read(path, *bytes, options);
    });
  });
}

}  // namespace swept
