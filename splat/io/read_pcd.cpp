// PCD, all three encodings. PCL's own reader is not used because it allocates what the header promises, turns
// words that are no numbers into zeros, and prints.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>

#include <liblzf/lzf.h>

#include "splat/io/attribute_names.h"
#include "splat/io/attributes.h"
#include "splat/io/file_bytes.h"
#include "splat/io/read_formats.h"

namespace swept {
namespace {

struct Field {
  std::string name;
  std::size_t bytes = 4;
  char type = 'F';  ///< F real, I signed, U unsigned
  std::size_t count = 1;
  std::size_t offset = 0;  ///< bytes of a point before it
};

struct Header {
  std::vector<Field> fields;
  std::uint64_t points = 0;
  std::size_t point_bytes = 0;
  std::string encoding;
  bool posed = false;  ///< VIEWPOINT says anything but the identity
  std::size_t body = 0;
};

using Words = std::vector<std::string>;

/// Headers are a dozen short lines. What they say is kept in pieces that take many times their length.
constexpr std::size_t kMostHeaderBytes = std::size_t{4} << 20;
constexpr const char* kKeywords[] = {"FIELDS", "SIZE",   "TYPE",      "COUNT", "WIDTH",
                                     "HEIGHT", "POINTS", "VIEWPOINT", "DATA"};

/// A back reference of LZF has three bytes at most, and stands for 264 bytes at most.
constexpr std::uint32_t kMostPerByte = 88;
/// Measured clouds come to 1 to 4, those with nothing in most pixels to 20. What unpacks to little may do so.
constexpr std::uint64_t kLikelyPerByte = 16, kAlwaysUnpacked = std::uint64_t{64} << 20;

/// A whole number ≥ 1 and small enough that products of three do not overflow.
std::optional<std::uint64_t> whole(const std::string& word, std::uint64_t most) {
  std::uint64_t value = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (code != std::errc{} || end != word.data() + word.size() || value < 1 || value > most)
    return std::nullopt;
  return value;
}

Status describe_fields(const std::string& path, std::map<std::string, Words>& entries, Header& header) {
  const Words &names = entries["FIELDS"], &sizes = entries["SIZE"], &types = entries["TYPE"];
  Words& counts = entries["COUNT"];
  if (names.empty()) return Error{path, "FIELDS", "the header does not give them"};
  if (counts.empty()) counts.assign(names.size(), "1");
  for (const auto& [key, words] : {std::pair{"SIZE", &sizes}, {"TYPE", &types}, {"COUNT", &counts}}) {
    if (words->size() != names.size()) return Error{path, key, "does not have one entry for each of FIELDS"};
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    Field field{names[i], 0, types[i].front(), 0, header.point_bytes};
    const auto size = whole(sizes[i], 8), count = whole(counts[i], 1u << 20);
    if (!count) return Error{path, names[i], "its COUNT is not a whole number ≥ 1"};
    const bool integer = field.type == 'I' || field.type == 'U';
    const bool size_known = size && (*size == 4 || *size == 8 || (integer && (*size == 1 || *size == 2)));
    if (types[i].size() != 1 || !(integer || field.type == 'F') || !size_known) {
      return Error{path, names[i], "has an unknown SIZE and TYPE"};
    }
    field.bytes = static_cast<std::size_t>(*size);
    field.count = static_cast<std::size_t>(*count);
    header.point_bytes += field.bytes * field.count;
    header.fields.push_back(field);
  }
  return Done{};
}

Result<Header> parse_header(const std::string& path, std::string_view bytes) {
  std::map<std::string, Words> entries;
  Header header;
  std::size_t at = 0;
  while (!entries.count("DATA")) {
    const std::size_t end = bytes.substr(0, kMostHeaderBytes).find('\n', at);
    if (end == bytes.npos) {
      return Error{path, "DATA",
                   std::string("the header does not end with it") +
                       (bytes.size() > kMostHeaderBytes ? " within 4 MiB" : "")};
    }
    LineScanner line(bytes.substr(at, end - at));
    at = end + 1;
    if (!line.next_line()) continue;
    const std::string_view key = line.next_token();
    if (std::find(std::begin(kKeywords), std::end(kKeywords), key) == std::end(kKeywords)) continue;
    Words& words = entries[std::string(key)];
    words.clear();
    for (auto token = line.next_token(); !token.empty(); token = line.next_token()) words.emplace_back(token);
  }
  header.body = at;
  if (Status s = describe_fields(path, entries, header); !s) return s.error();

  constexpr std::uint64_t kMost = 0xffffffff;
  const auto number = [&](const char* key) {
    const auto entry = entries.find(key);  // not [], which would make one
    return entry != entries.end() && entry->second.size() == 1 ? whole(entry->second[0], kMost)
                                                               : std::nullopt;
  };
  const auto width = number("WIDTH"), height = number("HEIGHT"), points = number("POINTS");
  for (const char* key : {"WIDTH", "HEIGHT", "POINTS"}) {
    if (!entries.count(key) || number(key)) continue;
    const Words zero{"0"};
    const bool none = entries[key] == zero && (!entries.count("POINTS") || entries["POINTS"] == zero);
    if (none)
      return Error{path, key, "is 0, and not a whole number ≥ 1: the file has no points", ErrorKind::empty};
    return Error{path, key, "is not a whole number ≥ 1"};
  }
  if (!points && !(width && height)) return Error{path, "POINTS", "the header does not give them"};
  header.points = points ? *points : *width * *height;
  if (points && width && height && *width * *height != *points) {
    return Error{path, "POINTS", "is not WIDTH times HEIGHT"};
  }
  header.encoding = entries["DATA"].size() == 1 ? entries["DATA"][0] : "";
  const Words& pose = entries["VIEWPOINT"];
  header.posed = !pose.empty() && pose != Words{"0", "0", "0", "1", "0", "0", "0"};
  return header;
}

template <class T>
double load(const char* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return static_cast<double>(value);
}

double load_number(const char* from, const Field& field) {
  if (field.type == 'F') return field.bytes == 4 ? load<float>(from) : load<double>(from);
  const bool is_signed = field.type == 'I';
  switch (field.bytes) {
    case 1:
      return is_signed ? load<std::int8_t>(from) : load<std::uint8_t>(from);
    case 2:
      return is_signed ? load<std::int16_t>(from) : load<std::uint16_t>(from);
    case 4:
      return is_signed ? load<std::int32_t>(from) : load<std::uint32_t>(from);
    default:
      return is_signed ? load<std::int64_t>(from) : load<std::uint64_t>(from);
  }
}

/// PCL packs colours into 32 bits 0xAARRGGBB, which older files call a float.
bool is_packed(const Field& field) {
  return (field.name == "rgb" || field.name == "rgba") && field.bytes == 4 && field.count == 1;
}

/// What the attributes are looked up in: the first entry of each field, three of vectors, and packed colours
/// in three.
struct Layout {
  std::vector<Column> columns;
  std::vector<std::size_t> field;  ///< of each column
  std::vector<std::size_t> entry;  ///< of that field
  std::vector<int> shift;          ///< right shift of a packed channel; -1: a plain number
};

Layout layout_of(const Header& header) {
  Layout layout;
  const auto add = [&](const std::string& name, double full_scale, std::size_t f, int shift) {
    layout.columns.push_back({name, full_scale});
    layout.field.push_back(f);
    layout.entry.push_back(0);
    layout.shift.push_back(shift);
  };
  for (std::size_t f = 0; f < header.fields.size(); ++f) {
    const Field& field = header.fields[f];
    if (is_packed(field)) {
      add("red", 255.0, f, 16);
      add("green", 255.0, f, 8);
      add("blue", 255.0, f, 0);
    } else {
      const double full_scale = field.type == 'F' ? 0.0 : field.bytes == 2 ? 65535.0 : 255.0;
      if (field.count != 3 || !is_vector_name(field.name)) {
        add(field.name, full_scale, f, -1);
        continue;
      }
      add_vector_columns(field.name, full_scale, layout.columns);
      for (std::size_t entry = 0; entry < 3; ++entry) {
        layout.field.push_back(f);
        layout.entry.push_back(entry);
        layout.shift.push_back(-1);
      }
    }
  }
  return layout;
}

using Values = std::vector<std::vector<double>>;

/// `row_wise`: whole points one after the other; else whole fields, as the compressed encoding has them.
Values take_binary(const Header& header, const Layout& layout, const std::vector<bool>& needed,
                   std::string_view body, bool row_wise) {
  const auto points = static_cast<std::size_t>(header.points);
  Values values(layout.columns.size());
  for (std::size_t c = 0; c < values.size(); ++c) {
    if (!needed[c]) continue;
    const Field& field = header.fields[layout.field[c]];
    const std::size_t stride = row_wise ? header.point_bytes : field.bytes * field.count;
    const char* at =
        body.data() + (row_wise ? field.offset : field.offset * points) + field.bytes * layout.entry[c];
    values[c].resize(points);
    for (std::size_t i = 0; i < points; ++i, at += stride) {
      if (layout.shift[c] < 0) {
        values[c][i] = load_number(at, field);
      } else {
        std::uint32_t packed;
        std::memcpy(&packed, at, sizeof packed);
        values[c][i] = (packed >> layout.shift[c]) & 0xff;
      }
    }
  }
  return values;
}

Result<Values> read_binary(const std::string& path, const Header& header, const Layout& layout,
                           const std::vector<bool>& needed, std::string_view body) {
  if (header.points > body.size() / header.point_bytes) {
    return Error{path, "POINTS",
                 "the header promises " + std::to_string(header.points) + " points of " +
                     std::to_string(header.point_bytes) + " bytes, the file has " +
                     std::to_string(body.size()) + " bytes left"};
  }
  return take_binary(header, layout, needed, body, true);
}

Result<Values> read_compressed(const std::string& path, const Header& header, const Layout& layout,
                               const std::vector<bool>& needed, std::string_view body) {
  std::array<std::uint32_t, 2> sizes{};  // packed, unpacked
  if (body.size() < sizeof sizes) return Error{path, "DATA", "the file ends before the compressed points"};
  std::memcpy(sizes.data(), body.data(), sizeof sizes);
  body.remove_prefix(sizeof sizes);
  if (sizes[0] > body.size()) {
    return Error{path, "DATA",
                 "promises " + std::to_string(sizes[0]) + " compressed bytes, the file has " +
                     std::to_string(body.size()) + " left"};
  }
  if (header.points > sizes[1] / header.point_bytes || header.points * header.point_bytes != sizes[1]) {
    return Error{path, "POINTS",
                 "the header promises " + std::to_string(header.points) + " points of " +
                     std::to_string(header.point_bytes) + " bytes, the data " + std::to_string(sizes[1]) +
                     " bytes"};
  }
  const Error damaged{path, "DATA", "the compressed points are damaged"};
  if (sizes[1] / kMostPerByte > sizes[0]) return damaged;
  if (sizes[1] > kAlwaysUnpacked && sizes[1] / kLikelyPerByte > sizes[0]) {
    return Error{path, "DATA",
                 "would unpack " + std::to_string(sizes[0]) + " bytes to " + std::to_string(sizes[1]) +
                     ", more than " + std::to_string(kLikelyPerByte) +
                     " times as many; if these are points, write them with DATA binary"};
  }
  std::string unpacked(sizes[1], '\0');
  if (lzf_decompress(body.data(), sizes[0], unpacked.data(), sizes[1]) != sizes[1]) return damaged;
  return take_binary(header, layout, needed, unpacked, false);
}

Result<Values> read_ascii(const std::string& path, const Header& header, const Layout& layout,
                          const std::vector<bool>& needed, std::string_view body) {
  std::size_t numbers_per_point = 0;
  std::vector<std::size_t> first_number;
  for (const Field& field : header.fields) {
    first_number.push_back(numbers_per_point);
    numbers_per_point += field.count;
  }
  if (header.points > (body.size() + 1) / (2 * numbers_per_point)) {
    return Error{path, "POINTS",
                 "the header promises " + std::to_string(header.points) + " points of " +
                     std::to_string(numbers_per_point) + " numbers, the file has " +
                     std::to_string(body.size()) + " bytes left"};
  }
  Values values(layout.columns.size());
  LineScanner lines(body);
  std::vector<std::string_view> tokens;
  for (std::uint64_t i = 0; i < header.points; ++i) {
    const std::string point = "point " + std::to_string(i) + ": ";
    tokens.clear();
    if (lines.next_line()) {
      for (auto t = lines.next_token(); !t.empty(); t = lines.next_token()) tokens.push_back(t);
    }
    if (tokens.size() != numbers_per_point) {
      return Error{path, "DATA",
                   point + "has " + std::to_string(tokens.size()) + " numbers, must have " +
                       std::to_string(numbers_per_point)};
    }
    for (std::size_t c = 0; c < values.size(); ++c) {
      if (!needed[c]) continue;
      const Field& field = header.fields[layout.field[c]];
      const std::string_view token = tokens[first_number[layout.field[c]] + layout.entry[c]];
      const std::optional<double> value = parse_number(token);
      if (!value) return Error{path, field.name, point + not_a_number(token)};
      double number = *value;
      if (layout.shift[c] >= 0) {
        std::uint32_t packed = 0;
        if (field.type == 'F') {
          const auto real = static_cast<float>(number);
          std::memcpy(&packed, &real, sizeof packed);
        } else if (std::abs(number) < 0x1p32) {
          packed = static_cast<std::uint32_t>(static_cast<std::int64_t>(number));
        }
        number = (packed >> layout.shift[c]) & 0xff;
      }
      values[c].push_back(number);
    }
  }
  return values;
}

}  // namespace

Result<PointSet> read_pcd(const std::string& path, std::string_view bytes, const ReadOptions& options) {
  const Result<Header> header = parse_header(path, bytes);
  if (!header) return header.error();
  const Layout layout = layout_of(*header);
  const Result<AttributePlan> plan = plan_attributes(path, layout.columns, options);
  if (!plan) return plan.error();
  const std::vector<bool> needed = plan->needed(layout.columns.size());

  const std::string_view body = bytes.substr(header->body);
  const auto read = header->encoding == "ascii"               ? read_ascii
                    : header->encoding == "binary"            ? read_binary
                    : header->encoding == "binary_compressed" ? read_compressed
                                                              : nullptr;
  if (!read) return Error{path, "DATA", "must be ascii, binary or binary_compressed"};
  const Result<Values> values = read(path, *header, layout, needed, body);
  if (!values) return values.error();
  Result<PointSet> set = assemble_points(path, layout.columns, *plan, *values, {}, options);
  for (const Field& field : header->fields) {
    if (set && field.name == "rgba" && is_packed(field)) set->report.unread.push_back("alpha of rgba");
  }
  if (set && header->encoding == "ascii") {
    std::uint64_t count = 0;
    for (LineScanner lines(body); lines.next_line();) ++count;
    if (count > header->points)
      set->report.unread.push_back(std::to_string(count - header->points) + " lines after the last point");
  }
  if (set && header->posed) set->notes.push_back("the file's VIEWPOINT is not applied");
  return set;
}

}  // namespace swept
