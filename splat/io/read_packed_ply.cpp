// Splats packed into PLY by PlayCanvas, "compressed PLY": chunks of 256 with the ranges that their numbers
// are interpolated in. Source: PlayCanvas engine, gsplat-compressed-data.js.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "splat/io/packed_quaternion.h"
#include "splat/io/ply_rows.h"
#include "splat/io/read_splats.h"
#include "splat/io/splat_builder.h"

namespace swept::io {
namespace {

constexpr std::size_t splats_per_chunk = 256;
constexpr std::array<const char*, 18> chunk_names{
    "min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
    "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
    "min_r",       "min_g",       "min_b",       "max_r",       "max_g",       "max_b"};
constexpr std::array<const char*, 4> vertex_names{"packed_position", "packed_rotation", "packed_scale",
                                                  "packed_color"};
constexpr std::size_t position_word = 0, rotation_word = 1, scale_word = 2, color_word = 3;

using Chunk = std::array<double, 18>;
using Packed = std::array<std::uint32_t, 4>;

/// The `bits` bits of the word from `shift` on, as a number in [0, 1].
double unit(std::uint32_t word, int shift, int bits) {
  const std::uint32_t full = (1u << bits) - 1;
  return static_cast<double>((word >> shift) & full) / static_cast<double>(full);
}

Eigen::Vector3d unit_11_10_11(std::uint32_t word) {
  return {unit(word, 21, 11), unit(word, 11, 10), unit(word, 0, 11)};
}

class PackedPlyReader {
 public:
  PackedPlyReader(const std::string& path, const PlyHeader& header, std::string_view body)
      : path_(path), header_(header), numbers_(body, header.format) {}

  Result<LoadedSplats> read(const SplatReadOptions& options) {
    if (Status s = plan(); !s) return s.error();
    for (const PlyElement& element : header_.elements) {
      if (Status s = check_ply_size(path_, element, numbers_); !s) return s.error();
      if (Status s = read_ply_rows(path_, element, numbers_, row_of(element)); !s) return s.error();
    }
    SplatBuilder builder(path_, packed_.size(), degree_, false, options, name_of);
    for (std::size_t i = 0; i < packed_.size(); ++i)
      if (Status s = builder.add(splat(i)); !s) return s.error();
    report(builder.loaded.report);
    for (const std::string& rest : numbers_.unread()) builder.loaded.report.unread.push_back(rest);
    return builder.finish();
  }

 private:
  Status find_all(const PlyElement& element, std::span<const char* const> names,
                  std::span<std::size_t> found) {
    for (std::size_t k = 0; k < names.size(); ++k) {
      const auto property = element.find(names[k]);
      if (!property)
        return Error{path_, names[k], "no such property, which splats that PlayCanvas packed have"};
      found[k] = *property;
    }
    return Done{};
  }

  Status plan() {
    const PlyElement &vertex = *header_.find("vertex"), *const chunk = header_.find("chunk");
    if (!chunk) return Error{path_, "chunk", "the file has no such element"};
    const std::uint64_t chunks = vertex.count / splats_per_chunk + (vertex.count % splats_per_chunk != 0);
    if (chunk->count != chunks)
      return Error{path_, "chunk",
                   "there are " + std::to_string(chunk->count) + " of them for " +
                       std::to_string(vertex.count) + " splats, not " + std::to_string(chunks)};
    has_colors_ = chunk->find(chunk_names[12]).has_value();
    if (Status s = find_all(*chunk, std::span(chunk_names).first(has_colors_ ? 18 : 12), chunk_at_); !s)
      return s;
    if (Status s = find_all(vertex, vertex_names, vertex_at_); !s) return s;
    for (const std::size_t p : vertex_at_)
      if (const PlyProperty& word = vertex.properties[p];
          word.type.kind != PlyType::Kind::unsigned_integer || word.type.bytes != 4)
        return Error{path_, word.name, "must be of type uint"};
    const PlyElement* const sh = header_.find("sh");
    return sh ? plan_harmonics(*sh, vertex.count) : Status(Done{});
  }

  Status plan_harmonics(const PlyElement& sh, std::uint64_t splats) {
    if (sh.count != splats)
      return Error{
          path_, "sh",
          "there are " + std::to_string(sh.count) + " of them for " + std::to_string(splats) + " splats"};
    while (sh.find("f_rest_" + std::to_string(sh_at_.size())))
      sh_at_.push_back(*sh.find("f_rest_" + std::to_string(sh_at_.size())));
    while (degree_ < 3 && rest_of(degree_) < sh_at_.size()) ++degree_;
    if (rest_of(degree_) != sh_at_.size())
      return Error{
          path_, "f_rest_0",
          std::to_string(sh_at_.size()) + " such properties are no spherical harmonics; 0, 9, 24 and 45 are"};
    for (const std::size_t p : sh_at_)
      if (const PlyProperty& byte = sh.properties[p];
          byte.type.kind != PlyType::Kind::unsigned_integer || byte.type.bytes != 1)
        return Error{path_, byte.name, "must be of type uchar"};
    return Done{};
  }

  static std::size_t rest_of(int degree) {
    return 3 * static_cast<std::size_t>(SplatCloud::coefficients(degree) - 1);
  }

  PlyRow row_of(const PlyElement& element) {
    const auto count = static_cast<std::size_t>(element.count);
    if (element.name == "chunk") {
      chunks_.reserve(count);
      return [this](std::span<const double> numbers) -> Status {
        Chunk chunk{};
        for (std::size_t k = 0; k < (has_colors_ ? 18u : 12u); ++k) chunk[k] = numbers[chunk_at_[k]];
        chunks_.push_back(chunk);
        return Done{};
      };
    }
    if (element.name == "vertex") {
      packed_.reserve(count);
      return [this](std::span<const double> numbers) -> Status {
        Packed packed{};
        for (std::size_t k = 0; k < 4; ++k) {
          const double word = numbers[vertex_at_[k]];
          // In a text they may be any number.
          if (!(word >= 0.0 && word <= 4294967295.0 && word == std::floor(word)))
            return Error{path_, vertex_names[k],
                         "splat " + std::to_string(packed_.size()) + " has no 32-bit word"};
          packed[k] = static_cast<std::uint32_t>(word);
        }
        packed_.push_back(packed);
        return Done{};
      };
    }
    if (element.name == "sh") {
      sh_.reserve(count * sh_at_.size());
      return [this](std::span<const double> numbers) -> Status {
        for (const std::size_t p : sh_at_) {
          const double byte = numbers[p];
          if (!(byte >= 0.0 && byte <= 255.0 && byte == std::floor(byte)))
            return Error{path_, "sh",
                         "splat " + std::to_string(sh_.size() / sh_at_.size()) + " has no bytes"};
          sh_.push_back(static_cast<std::uint8_t>(byte));
        }
        return Done{};
      };
    }
    return [](std::span<const double>) -> Status { return Done{}; };
  }

  [[nodiscard]] SplatRow splat(std::size_t i) const {
    const Chunk& chunk = chunks_[i / splats_per_chunk];
    const Packed& packed = packed_[i];
    const auto between = [&](std::size_t low, const Eigen::Vector3d& at) {
      const Eigen::Map<const Eigen::Array3d> a(chunk.data() + low), b(chunk.data() + low + 3);
      return Eigen::Vector3d(a * (1.0 - at.array()) + b * at.array());
    };
    SplatRow row;
    row.position = between(0, unit_11_10_11(packed[position_word]));
    row.scale = between(6, unit_11_10_11(packed[scale_word])).array().exp();

    const std::uint32_t turn = packed[rotation_word];
    const Eigen::Vector3d three(unit(turn, 20, 10), unit(turn, 10, 10), unit(turn, 0, 10));
    row.rotation = with_largest((three.array() - 0.5) * std::numbers::sqrt2, turn >> 30);

    const std::uint32_t color = packed[color_word];
    const Eigen::Vector3d rgb(unit(color, 24, 8), unit(color, 16, 8), unit(color, 8, 8));
    row.harmonics[0] = ((has_colors_ ? between(12, rgb) : rgb).array() - 0.5) / first_harmonic;
    row.opacity = unit(color, 0, 8);

    const std::size_t per_channel = sh_at_.size() / 3;
    for (std::size_t k = 0; k < per_channel; ++k)
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const std::uint8_t byte = sh_[i * sh_at_.size() + channel * per_channel + k];
        const double n = byte == 0 ? 0.0 : byte == 255 ? 1.0 : (byte + 0.5) / 256.0;
        row.harmonics[k + 1][static_cast<Eigen::Index>(channel)] = (n - 0.5) * 8.0;
      }
    return row;
  }

  /// Numbers that are not finite can only come from a chunk.
  static std::string name_of(SplatPart part, std::size_t component) {
    switch (part) {
      case SplatPart::position:
        return std::string(chunk_names[component]) + ", " + chunk_names[3 + component];
      case SplatPart::scale:
        return std::string(chunk_names[6 + component]) + ", " + chunk_names[9 + component];
      default:
        return std::string(chunk_names[12 + component % 3]) + ", " + chunk_names[15 + component % 3];
    }
  }

  void report(ReadReport& report) const {
    report.used = {{"position", {"packed_position"}},
                   {"scale", {"packed_scale"}},
                   {"rotation", {"packed_rotation"}},
                   {"opacity", {"packed_color"}},
                   {"color", {"packed_color"}}};
    if (!sh_at_.empty()) {
      report.used.push_back({"harmonics", {}});
      for (std::size_t k = 0; k < sh_at_.size(); ++k)
        report.used.back().properties.push_back("f_rest_" + std::to_string(k));
    }
    for (const PlyElement& element : header_.elements) {
      if (element.count == 0) continue;
      const bool is_vertex = element.name == "vertex";
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const auto used = [p](const auto& some) {
          return std::find(some.begin(), some.end(), p) != some.end();
        };
        if (element.name == "chunk" || (is_vertex && used(vertex_at_)) ||
            (element.name == "sh" && used(sh_at_)))
          continue;
        report.unread.push_back((is_vertex ? "" : element.name + ".") + element.properties[p].name);
      }
    }
    report.assumed.push_back("3D Gaussian splats, packed in chunks; colours sRGB");
  }

  const std::string& path_;
  const PlyHeader& header_;
  PlyNumbers numbers_;
  bool has_colors_ = false;
  int degree_ = 0;
  std::array<std::size_t, 18> chunk_at_{};
  std::array<std::size_t, 4> vertex_at_{};
  std::vector<std::size_t> sh_at_;
  std::vector<Chunk> chunks_;
  std::vector<Packed> packed_;
  std::vector<std::uint8_t> sh_;
};

}  // namespace

Result<LoadedSplats> read_packed_ply(const std::string& path, std::string_view bytes, const PlyHeader& header,
                                     const SplatReadOptions& options) {
  return PackedPlyReader(path, header, bytes.substr(header.body)).read(options);
}

}  // namespace swept::io
