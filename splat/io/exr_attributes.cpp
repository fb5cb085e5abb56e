#include "splat/io/exr_attributes.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace swept {
namespace {

constexpr std::size_t longest_name = 255;

// OpenEXR keeps the attributes of a header, and its channels, in order by moving all that come after a new
// one: the square of their number. At this many that is still a tenth of a second; films have hundreds.
constexpr std::size_t most_attributes = 8192, most_channels = 8192, most_parts = 4096;

/// Sizes of types whose values all have the same.
constexpr std::pair<std::string_view, std::uint32_t> fixed_sizes[] = {
    {"box2f", 16},      {"box2i", 16},   {"chromaticities", 32},
    {"compression", 1}, {"double", 8},   {"envmap", 1},
    {"float", 4},       {"int", 4},      {"keycode", 28},
    {"lineOrder", 1},   {"m33d", 72},    {"m33f", 36},
    {"m44d", 128},      {"m44f", 64},    {"rational", 8},
    {"tiledesc", 9},    {"timecode", 8}, {"v2d", 16},
    {"v2f", 8},         {"v2i", 8},      {"v3d", 24},
    {"v3f", 12},        {"v3i", 12},     {"deepImageState", 1}};

class HeaderReader {
 public:
  HeaderReader(const std::string& path, std::uint64_t file_bytes)
      : file_(path, std::ios::binary), bytes_(file_bytes) {}

  /// Whether all headers are as the format has them.
  bool valid() {
    std::uint32_t magic = 0, version = 0;
    if (!integer(magic) || !integer(version)) return false;
    const bool has_parts = (version & 0x1000) != 0;
    std::size_t parts = 0;
    // An empty name ends a header; of several parts, an empty header the last one.
    do {
      if (++parts > most_parts) return too_many("parts");
      if (!header()) return false;
    } while (has_parts && file_.peek() != 0);
    return true;
  }

  /// The attribute that stands in a header twice, if that is why they are not valid.
  [[nodiscard]] const std::string& repeated() const { return repeated_; }
  /// Of what there is too much, if that is why the headers are not valid.
  [[nodiscard]] const std::string& excess() const { return excess_; }

 private:
  bool too_many(const char* what) {
    excess_ = what;
    return false;
  }

  bool header() {
    std::string name;
    std::set<std::string> names;
    width_ = pixel_bytes_ = 0;
    rows_ = 1;
    while (text(name)) {
      if (name.empty())
        return width_ * pixel_bytes_ * rows_ <= most_chunk_bytes(bytes_) || too_many("pixels");
      // One of OpenEXR's readers takes the first, the other the last: what one checks the other must not
      // trust.
      if (!names.insert(name).second) {
        repeated_ = name;
        return false;
      }
      if (names.size() > most_attributes) return too_many("attributes");
      if (!attribute(name)) return false;
    }
    return false;
  }

  bool attribute(const std::string& name) {
    std::string type;
    std::uint32_t size = 0;
    if (!text(type) || !integer(size) || size > bytes_ - position()) return false;
    const auto* const fixed = std::find_if(std::begin(fixed_sizes), std::end(fixed_sizes),
                                           [&](const auto& entry) { return entry.first == type; });
    if (fixed != std::end(fixed_sizes) && size != fixed->second) return false;
    const std::uint64_t end = position() + size;
    if (type == "chlist" && !channels(end)) return false;
    if (name == "dataWindow" && type == "box2i" && !window()) return false;
    if (name == "compression" && type == "compression") {
      // By the coder's number: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB.
      constexpr std::uint64_t rows_of[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
      const int coder = file_.get();
      if (coder < 0 || coder > 9) return false;
      rows_ = rows_of[coder];
    }
    file_.seekg(static_cast<std::streamoff>(end));
    return true;
  }

  /// A list of channels, up to the empty name at its end.
  bool channels(std::uint64_t end) {
    constexpr std::streamoff channel_bytes = 16;  // type, linearity, sampling rates
    std::string name;
    std::size_t channels = 0;
    while (text(name)) {
      if (name.empty()) return position() == end;
      if (++channels > most_channels) return too_many("channels");
      std::uint32_t kind = 0;
      if (!integer(kind)) return false;
      pixel_bytes_ += kind == 1 ? 2 : 4;
      file_.seekg(channel_bytes - 4, std::ios::cur);
    }
    return false;
  }

  bool window() {
    std::uint32_t corner[4];
    for (std::uint32_t& value : corner)
      if (!integer(value)) return false;
    const auto signed_of = [](std::uint32_t value) { return std::int64_t{static_cast<std::int32_t>(value)}; };
    width_ = static_cast<std::uint64_t>(
        std::max<std::int64_t>(0, signed_of(corner[2]) - signed_of(corner[0]) + 1));
    return true;
  }

  bool text(std::string& value) {
    return std::getline(file_, value, '\0') && !file_.eof() && value.size() <= longest_name;
  }

  /// Little-endian, as all of the format.
  bool integer(std::uint32_t& value) {
    std::array<char, 4> raw{};
    if (!file_.read(raw.data(), raw.size())) return false;
    value = 0;
    for (std::size_t i = raw.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(raw[i]);
    return true;
  }

  std::uint64_t position() { return std::min(static_cast<std::uint64_t>(file_.tellg()), bytes_); }

  std::ifstream file_;
  std::uint64_t bytes_;
  std::uint64_t width_ = 0, pixel_bytes_ = 0, rows_ = 1;  ///< of the header that is read, rows of a chunk
  std::string excess_, repeated_;
};

}  // namespace

Status check_exr_attributes(const std::string& path, std::uint64_t file_bytes) {
  HeaderReader reader(path, file_bytes);
  if (reader.valid()) return Done{};
  if (!reader.repeated().empty())
    return Error{path, printable(reader.repeated()), "stands in the header more than once"};
  if (!reader.excess().empty()) return Error{path, "", "has more " + reader.excess() + " than are read"};
  return Error{path, "", "not a readable OpenEXR file: its header is damaged"};
}

}  // namespace swept
