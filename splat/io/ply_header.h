// The header of a PLY file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "splat/result.h"

namespace swept {

enum class PlyFormat { ascii, little_endian, big_endian };

struct PlyType {
  enum class Kind { signed_integer, unsigned_integer, real } kind = Kind::real;
  std::size_t bytes = 4;
};

struct PlyProperty {
  std::string name;
  PlyType type;  ///< of the entries, if a list
  bool is_list = false;
  PlyType count_type;
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  [[nodiscard]] bool has_lists() const;
  /// Where the property of this name is, if it is no list.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view name_of_property) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::string comments;  ///< their lines, without the word itself
  std::size_t body = 0;  ///< offset of the first byte after the header

  /// Null if there is none.
  [[nodiscard]] const PlyElement* find(std::string_view name_of_element) const;
};

/// Errors: not a PLY header, unknown formats and types, names declared twice. Counts are not compared with
/// the size of the file here.
[[nodiscard]] Result<PlyHeader> parse_ply_header(const std::string& path, std::string_view bytes);

}  // namespace swept
