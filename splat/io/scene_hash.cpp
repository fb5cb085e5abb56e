// What tells the pictures of scenes apart.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <vector>

#include "splat/io/content_hash.h"
#include "splat/io/guarded.h"
#include "splat/io/scene_clouds.h"
#include "splat/io/scene_inputs.h"
#include "splat/io/source_files.h"

namespace swept {
namespace io {

std::string ContentHash::text() const {
  std::array<char, 17> digits;
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(state_));
  return digits.data();
}

Result<std::string> hash_file(const std::string& path) {
  std::error_code code;
  // A pipe would be empty for who reads it next, and a device could go on for ever.
  if (!std::filesystem::is_regular_file(path, code)) return Error{path, "", "is not a regular file"};
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{path, "", "cannot be opened for reading", ErrorKind::not_found};
  ContentHash hash;
  hash.add_part(std::to_string(std::filesystem::file_size(path, code)));
  std::vector<char> block(std::size_t{1} << 16);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())), file.gcount() > 0)
    hash.add({block.data(), static_cast<std::size_t>(file.gcount())});
  if (file.bad()) return Error{path, "", "cannot be read to its end", ErrorKind::device};
  return hash.text();
}

}  // namespace io

Result<std::string> SceneFile::hash(double frame) const {
  if (!(std::abs(frame) <= most_frame))
    return Error{path_, "/frame", "the frame must be between -1e9 and 1e9"};
  return io::guarded(path_, [&] { return hash_of(frame, canonical_); });
}

Result<std::string> SceneFile::whole_hash(double frame) const {
  if (!(std::abs(frame) <= most_frame))
    return Error{path_, "/frame", "the frame must be between -1e9 and 1e9"};
  return io::guarded(path_, [&] { return hash_of(frame, canonical_whole_); });
}

Result<std::string> SceneFile::hash_of(double frame, const std::string& canonical) const {
  io::ContentHash hash;
  hash.add_part(canonical);
  hash.add_part(shortest_text(frame));
  Scene at_frame;
  at_frame.frame = frame;
  at_frame.film = scene_.film;
  at_frame.shutter = scene_.shutter;
  at_frame.motion = scene_.motion;
  for (const ObjectSource& source : sources_) {
    if (source.draw == DrawAs::triangles && !source.texture.empty()) {
      const Result<std::string> digits = io::hash_file(source.texture);
      if (!digits) return digits.error();
      hash.add_part(*digits);
    }
    const Result<io::SourceFiles> files = io::source_files(source, at_frame);
    if (!files) return source_error(source, files.error());
    for (const KeyFile& key : files->files) {
      // A file that is shown at many frames is read once.
      std::error_code code;
      const bool materials = io::draws_materials(source);
      Clouds::Content& content = clouds_->contents[key.path + (materials ? "\n" : "")];
      const auto changed = std::filesystem::last_write_time(key.path, code);
      if (content.hash.empty() || content.changed != changed) {
        Result<std::string> digits = io::hash_file(key.path);
        if (!digits) return digits.error();
        for (const std::string& beside : io::files_beside(source, key.path)) {
          const Result<std::string> more = io::hash_file(beside);
          if (!more) return more.error();
          *digits += *more;
        }
        content = {changed, std::move(*digits)};
      }
      hash.add_part(shortest_text(key.frame));
      hash.add_part(content.hash);
    }
  }
  return hash.text();
}

}  // namespace swept
