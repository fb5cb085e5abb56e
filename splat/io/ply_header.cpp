#include "splat/io/ply_header.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <unordered_set>

#include "splat/io/read_report.h"

namespace swept {
namespace {

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
    if (line.empty()) return words;
    words.push_back(line.substr(0, line.find_first_of(" \t\r")));
    line.remove_prefix(words.back().size());
  }
}

constexpr const char* kKnownTypes =
    "known are char, uchar, short, ushort, int, uint, float, double and int8 to float64";

/// Case does not matter: some write Float or UCHAR.
std::optional<PlyType> type_of(std::string_view word) {
  using Kind = PlyType::Kind;
  std::string name(word);
  for (char& c : name) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  if (name == "char" || name == "int8") return PlyType{Kind::signed_integer, 1};
  if (name == "uchar" || name == "uint8") return PlyType{Kind::unsigned_integer, 1};
  if (name == "short" || name == "int16") return PlyType{Kind::signed_integer, 2};
  if (name == "ushort" || name == "uint16") return PlyType{Kind::unsigned_integer, 2};
  if (name == "int" || name == "int32") return PlyType{Kind::signed_integer, 4};
  if (name == "uint" || name == "uint32") return PlyType{Kind::unsigned_integer, 4};
  if (name == "float" || name == "float32") return PlyType{Kind::real, 4};
  if (name == "double" || name == "float64") return PlyType{Kind::real, 8};
  return std::nullopt;
}

std::optional<PlyFormat> format_of(std::string_view name) {
  if (name == "ascii") return PlyFormat::ascii;
  if (name == "binary_little_endian") return PlyFormat::little_endian;
  if (name == "binary_big_endian") return PlyFormat::big_endian;
  return std::nullopt;
}

class HeaderParser {
 public:
  explicit HeaderParser(const std::string& path) : path_(path) {}

  Status take(const std::vector<std::string_view>& words) {
    if (words[0] == "comment" || words[0] == "obj_info") return take_comment(words);
    if (words[0] == "format") return take_format(words);
    if (words[0] == "element") return take_element(words);
    if (words[0] == "property") return take_property(words);
    return fail("header", "unknown keyword '" + std::string(words[0].substr(0, 24)) + "'");
  }

  PlyHeader header;
  bool has_format = false;

 private:
  [[nodiscard]] Error fail(const std::string& field, const std::string& reason) const {
    return Error{path_, field, reason};
  }

  Status take_comment(const std::vector<std::string_view>& words) {
    for (std::size_t i = 1; i < words.size(); ++i) (header.comments += i > 1 ? " " : "") += words[i];
    header.comments += '\n';
    return Done{};
  }

  Status take_format(const std::vector<std::string_view>& words) {
    const auto format = words.size() > 1 ? format_of(words[1]) : std::nullopt;
    if (!format) return fail("format", "must be ascii, binary_little_endian or binary_big_endian");
    header.format = *format;
    has_format = true;
    return Done{};
  }

  Status take_element(const std::vector<std::string_view>& words) {
    if (words.size() != 3) return fail("element", "needs a name and a count");
    PlyElement element;
    element.name = words[1];
    const char* const end = words[2].data() + words[2].size();
    const auto [stop, code] = std::from_chars(words[2].data(), end, element.count);
    if (code != std::errc{} || stop != end) return fail(element.name, "its count is not a whole number");
    if (!element_names_.insert(element.name).second)
      return fail(element.name, "this element is declared twice");
    property_names_.clear();
    header.elements.push_back(element);
    return Done{};
  }

  Status take_property(const std::vector<std::string_view>& words) {
    const bool is_list = words.size() > 1 && words[1] == "list";
    if (words.size() != (is_list ? 5u : 3u)) return fail("property", "needs a type and a name");
    if (header.elements.empty()) return fail("property", "comes before any element");
    PlyProperty property;
    property.name = words.back();
    property.is_list = is_list;
    const auto type = type_of(words[words.size() - 2]);
    const auto count_type = is_list ? type_of(words[2]) : PlyType{};
    if (!type || !count_type) {
      const std::string unknown(type ? words[2] : words[words.size() - 2]);
      return fail(property.name, "has an unknown type, " + listed({unknown}) + "; " + kKnownTypes);
    }
    if (is_list && count_type->kind == PlyType::Kind::real)
      return fail(property.name, "counts its list in reals");
    property.type = *type;
    property.count_type = *count_type;
    if (!property_names_.insert(property.name).second)
      return fail(property.name, "this property is declared twice");
    header.elements.back().properties.push_back(property);
    return Done{};
  }

  const std::string& path_;
  std::unordered_set<std::string> element_names_, property_names_;  ///< properties of the last element
};

}  // namespace

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(), [](const PlyProperty& p) { return p.is_list; });
}

std::optional<std::size_t> PlyElement::find(std::string_view name_of_property) const {
  for (std::size_t p = 0; p < properties.size(); ++p)
    if (!properties[p].is_list && properties[p].name == name_of_property) return p;
  return std::nullopt;
}

const PlyElement* PlyHeader::find(std::string_view name_of_element) const {
  for (const PlyElement& element : elements)
    if (element.name == name_of_element) return &element;
  return nullptr;
}

Result<PlyHeader> parse_ply_header(const std::string& path, std::string_view bytes) {
  HeaderParser parser(path);
  std::size_t at = 0;
  bool first = true;
  while (at < bytes.size()) {
    const std::size_t end = bytes.find('\n', at);
    if (end == bytes.npos) break;
    const std::vector<std::string_view> words = words_of(bytes.substr(at, end - at));
    at = end + 1;
    if (first && (words.size() != 1 || words[0] != "ply")) break;
    if (!first && !words.empty() && words[0] == "end_header") {
      if (!parser.has_format) return Error{path, "format", "the header does not give it"};
      parser.header.body = at;
      return std::move(parser.header);
    }
    if (!first && !words.empty()) {
      if (Status taken = parser.take(words); !taken) return taken.error();
    }
    first = false;
  }
  return Error{path, "header", first ? "does not start with the line 'ply'" : "has no end_header"};
}

}  // namespace swept
