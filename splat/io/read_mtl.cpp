// MTL files: what of a material is drawn, which is its colour, its opacity and a picture of it.
#include <cmath>
#include <optional>

#include "splat/io/mesh_builder.h"
#include "splat/io/obj_materials.h"

namespace swept {
namespace {

/// The rest of a line, its tokens parted by one blank: names may have some.
std::string rest_of(LineScanner& lines, std::string_view first) {
  std::string rest(first);
  for (std::string_view token = lines.next_token(); !token.empty(); token = lines.next_token())
    rest += (rest.empty() ? "" : " ") + std::string(token);
  return rest;
}

bool ends_in_mtl(std::string_view name) {
  if (name.size() < 4) return false;
  name.remove_prefix(name.size() - 4);
  return name[0] == '.' && (name[1] | 32) == 'm' && (name[2] | 32) == 't' && (name[3] | 32) == 'l';
}

class MtlReader {
 public:
  MtlReader(const std::string& path, std::string_view bytes) : path_(path), lines_(bytes) {}

  Result<MtlFile> read() {
    while (lines_.next_line()) {
      const std::string_view keyword = lines_.next_token();
      if (keyword == "newmtl") {
        file_.materials.push_back({rest_of(lines_, "")});
        has_d_ = false;
        continue;
      }
      const bool known = keyword == "Kd" || keyword == "d" || keyword == "Tr" || keyword == "map_Kd";
      if (known && file_.materials.empty()) return fail(std::string(keyword), "comes before any newmtl");
      Status status = keyword == "Kd"       ? color()
                      : keyword == "d"      ? opacity(true)
                      : keyword == "Tr"     ? opacity(false)
                      : keyword == "map_Kd" ? map()
                                            : Status(Done{});
      if (!status) return status.error();
      if (!known) ++others_[std::string(keyword.substr(0, 40))];
      if (others_.size() > 100) others_.erase(std::prev(others_.end()));
    }
    for (const auto& [keyword, count] : others_)
      file_.unread.push_back(std::to_string(count) + (count == 1 ? " line " : " lines ") + keyword);
    return std::move(file_);
  }

 private:
  [[nodiscard]] Error fail(const std::string& what, const std::string& reason) const {
    return {path_, "line " + std::to_string(lines_.line_number()) + ", " + what, reason,
            ErrorKind::malformed};
  }
  MtlMaterial& material() { return file_.materials.back(); }

  /// One number is a grey.
  Status color() {
    const std::string_view first = lines_.next_token();
    if (first == "spectral" || first == "xyz") {
      ++others_["Kd " + std::string(first)];
      return Done{};
    }
    for (int c = 0; c < 3; ++c) {
      const std::string_view token = c == 0 ? first : lines_.next_token();
      if (c == 1 && token.empty()) {
        material().color = Eigen::Vector3d::Constant(material().color[0]);
        return Done{};
      }
      const std::optional<double> value = parse_number(token);
      if (!value) return fail("Kd", not_a_number(token));
      if (!(std::abs(*value) <= double{most_color})) return fail("Kd", "must be between -1e30 and 1e30");
      material().color[c] = *value;
    }
    return Done{};
  }

  /// Of d and Tr, which tools also write as if it were d, the first counts.
  Status opacity(bool d) {
    const char* const what = d ? "d" : "Tr";
    const std::string_view token = lines_.next_token();
    if (d && token == "-halo") {
      ++others_["d -halo"];
      return Done{};
    }
    const std::optional<double> value = parse_number(token);
    if (!value) return fail(what, not_a_number(token));
    if (!(*value >= 0.0 && *value <= 1.0)) return fail(what, "must lie in [0, 1]");
    if (d || !has_d_) material().opacity = d ? *value : 1.0 - *value;
    has_d_ = has_d_ || d;
    return Done{};
  }

  /// Options before the name.
  Status map() {
    std::string_view token = lines_.next_token();
    while (token.size() > 1 && token.front() == '-' && !parse_number(token)) {
      const std::string option(token.substr(0, 40));
      ++others_["map_Kd " + option];
      token = lines_.next_token();
      if (option == "-o" || option == "-s" || option == "-t") {
        for (int c = 0; c < 3 && parse_number(token); ++c) token = lines_.next_token();
        continue;
      }
      for (int c = 0; c < (option == "-mm" ? 2 : 1); ++c) token = lines_.next_token();
    }
    if (token.empty()) return fail("map_Kd", "names no file");
    material().color_map = rest_of(lines_, token);
    return Done{};
  }

  const std::string& path_;
  LineScanner lines_;
  MtlFile file_;
  bool has_d_ = false;
  std::map<std::string, std::size_t> others_;
};

}  // namespace

void ObjMaterialNames::add_files(LineScanner& lines) {
  std::string name;
  for (std::string_view token = lines.next_token(); !token.empty(); token = lines.next_token()) {
    name += (name.empty() ? "" : " ") + std::string(token);
    if (!ends_in_mtl(token)) continue;
    names_.files.push_back(std::move(name));
    name.clear();
  }
  if (!name.empty()) names_.files.push_back(std::move(name));
}

void ObjMaterialNames::use(LineScanner& lines) {
  std::string name = rest_of(lines, "");
  const auto [found, added] = index_.emplace(std::move(name), static_cast<std::uint32_t>(index_.size()));
  if (added) names_.names.push_back(found->first);
  current_ = found->second;
}

MaterialNames ObjMaterialNames::finish() {
  return names_.names.size() > 1 ? std::move(names_) : MaterialNames{};
}

Result<MtlFile> read_mtl(const std::string& path, std::string_view bytes) {
  return MtlReader(path, bytes).read();
}

}  // namespace swept
