// 3D and 2D Gaussian splats as they are trained, in PLY. Sources: Kerbl et al. 2023, scene/gaussian_model.py
// of its code (names; scales are natural logarithms, opacities logits, quaternions w x y z of any length,
// f_rest channel by channel); Huang et al. 2024 (2D: no scale_2).
#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include "splat/io/attribute_names.h"
#include "splat/io/ply_rows.h"
#include "splat/io/read_splats.h"
#include "splat/io/splat_builder.h"

namespace swept::io {
namespace {

/// Where the numbers of a splat stand in a row of them.
enum Slot : std::size_t { position = 0, scale = 3, rotation = 6, opacity = 10, dc = 11, rest = 14 };
constexpr std::size_t most_rest = 45, velocity = rest + most_rest, color = velocity + 3, center = color + 3,
                      log_duration = center + 1, motion = center + 2, omega = motion + 9, slots = omega + 4,
                      unused = slots;

std::string numbered(const char* stem, std::size_t number) { return stem + std::to_string(number); }

/// Which property of the vertices becomes which number.
class Layout {
 public:
  explicit Layout(const PlyElement& vertex) {
    for (std::size_t p = 0; p < vertex.properties.size(); ++p)
      if (!vertex.properties[p].is_list) index_.emplace(vertex.properties[p].name, p);
    slot_of.assign(vertex.properties.size(), unused);
  }

  Status plan(const std::string& path, const PlyElement& vertex, const SplatReadOptions& options) {
    if (Status s = plan_motion(path, options); !s) return s;
    for (const auto& [name, slot] : {std::pair{"x", 0u}, {"y", 1u}, {"z", 2u}})
      if (!take(name, position + slot)) return Error{path, name, "no such property"};
    flat = !take("scale_2", scale + 2);
    for (std::size_t k = 0; k < 2; ++k) take(numbered("scale_", k), scale + k);
    for (std::size_t k = 0; k < 4; ++k) take(numbered("rot_", k), rotation + k);
    has_opacity = take("opacity", opacity);
    if (Status s = plan_colors(path, vertex); !s) return s;
    for (const AttributeNames& attribute : attribute_names())
      if (!has_motion && attribute.attribute == std::string_view("velocity"))
        plan_velocity(vertex, attribute);
    return Done{};
  }

  [[nodiscard]] std::string name_of(const PlyElement& vertex, std::size_t slot) const {
    const auto found = std::find(slot_of.begin(), slot_of.end(), slot);
    return found == slot_of.end() ? std::string()
                                  : vertex.properties[static_cast<std::size_t>(found - slot_of.begin())].name;
  }

  std::vector<std::size_t> slot_of;  ///< of each property; unused: nothing is made of it
  bool flat = false, has_opacity = false, has_harmonics = false, has_velocity = false, has_motion = false;
  double full_color = 0.0;  ///< what colours in place of harmonics are stored as; 0: there are none
  int degree = 0;

 private:
  bool take(const std::string& name, std::size_t slot) {
    const auto found = index_.find(name);
    if (found == index_.end()) return false;
    slot_of[found->second] = slot;
    return true;
  }

  /// Source: SpacetimeGaussians, thirdparty/gaussian_splatting/scene/ourslite.py.
  Status plan_motion(const std::string& path, const SplatReadOptions& options) {
    const auto first = {"trbf_center", "trbf_scale", "motion_0", "omega_0"};
    const auto* const found =
        std::find_if(first.begin(), first.end(), [&](const char* n) { return index_.contains(n); });
    if (found == first.end()) return Done{};
    if (!options.motion)
      return Error{path, *found, "splats of SpacetimeGaussians, which move by themselves, are not read here",
                   ErrorKind::unsupported};
    // Its full model has a network that makes the colours, in another file.
    for (const char* name : {"f_dc_3", "f_t_0", "f_rest_0"})
      if (index_.contains(name))
        return Error{path, name,
                     "of SpacetimeGaussians only the lite model is known, which has f_dc_0 to f_dc_2"};
    std::map<std::string, std::size_t> needed{{"trbf_center", center}, {"trbf_scale", log_duration}};
    for (std::size_t k = 0; k < 9; ++k) needed[numbered("motion_", k)] = motion + k;
    for (std::size_t k = 0; k < 4; ++k) needed[numbered("omega_", k)] = omega + k;
    for (const auto& [name, slot] : needed)
      if (!take(name, slot)) return Error{path, name, "no such property"};
    has_motion = true;
    return Done{};
  }

  Status plan_colors(const std::string& path, const PlyElement& vertex) {
    std::size_t has = 0;
    for (std::size_t k = 0; k < 3; ++k) has += index_.contains(numbered("f_dc_", k)) ? 1 : 0;
    if (has != 0 && has != 3) return Error{path, "f_dc_0", "has no f_dc_1 and f_dc_2 beside it"};
    has_harmonics = has == 3;
    std::size_t count = 0;
    for (const PlyProperty& p : vertex.properties) count += p.name.starts_with("f_rest_") ? 1 : 0;
    while (degree < 3 && static_cast<std::size_t>(3 * SplatCloud::coefficients(degree) - 3) < count) ++degree;
    const auto expected = static_cast<std::size_t>(3 * SplatCloud::coefficients(degree) - 3);
    if (expected != count)
      return Error{
          path, "f_rest_0",
          std::to_string(count) + " such properties are no spherical harmonics; 0, 9, 24 and 45 are"};
    if (count > 0 && !has_harmonics) return Error{path, "f_dc_0", "no such property"};
    for (std::size_t k = 0; k < count; ++k)
      if (!take(numbered("f_rest_", k), rest + k))
        return Error{path, numbered("f_rest_", k), "no such property"};
    if (has_motion && has_harmonics) {
      // Of the lite model these are colours.
      has_harmonics = false;
      full_color = 1.0;
      for (std::size_t k = 0; k < 3; ++k) take(numbered("f_dc_", k), color + k);
      return Done{};
    }
    for (std::size_t k = 0; has_harmonics && k < 3; ++k) take(numbered("f_dc_", k), dc + k);
    const char* const names[] = {"red", "green", "blue"};
    if (has_harmonics || !std::all_of(names, names + 3, [&](const char* n) { return index_.contains(n); }))
      return Done{};
    for (std::size_t k = 0; k < 3; ++k) take(names[k], color + k);
    const PlyType type = vertex.properties[index_.at("red")].type;
    full_color = type.kind == PlyType::Kind::real ? 1.0 : type.bytes == 2 ? 65535.0 : 255.0;
    return Done{};
  }

  void plan_velocity(const PlyElement& vertex, const AttributeNames& attribute) {
    std::map<std::string, std::size_t> by_plain;
    for (std::size_t p = 0; p < vertex.properties.size(); ++p)
      if (!vertex.properties[p].is_list && slot_of[p] == unused)
        by_plain.emplace(folded(vertex.properties[p].name), p);
    for (const std::vector<std::string>& names : attribute.usual) {
      if (!std::all_of(names.begin(), names.end(), [&](const auto& n) { return by_plain.contains(n); }))
        continue;
      for (std::size_t k = 0; k < 3; ++k) slot_of[by_plain[names[k]]] = velocity + k;
      has_velocity = true;
      return;
    }
  }

  std::map<std::string, std::size_t> index_;
};

/// What comments such as "SplatRenderMode: mip" and "antialiased 1" say; the last one counts.
bool is_antialiased(const std::string& comments) {
  bool antialiased = false;
  std::istringstream lines(comments);
  for (std::string line; std::getline(lines, line);) {
    for (char& c : line)
      c = c == ':' || c == '=' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    std::istringstream words(line);
    std::string name, value;
    words >> name >> value;
    if (name == "splatrendermode") antialiased = value == "mip" || value == "antialiased";
    if (name == "antialiased" || name == "antialias")
      antialiased = value.empty() || value == "1" || value == "true" || value == "yes";
  }
  return antialiased;
}

class SplatPlyReader {
 public:
  SplatPlyReader(const std::string& path, std::string_view bytes, const PlyHeader& header,
                 const SplatReadOptions& options)
      : path_(path),
        header_(header),
        vertex_(*header.find("vertex")),
        options_(options),
        layout_(vertex_),
        numbers_(bytes.substr(header.body), header.format) {}

  Result<LoadedSplats> read() {
    if (Status s = layout_.plan(path_, vertex_, options_); !s) return s.error();
    std::optional<SplatBuilder> builder;
    for (const PlyElement& element : header_.elements) {
      if (Status s = check_ply_size(path_, element, numbers_); !s) return s.error();
      const bool is_vertex = &element == &vertex_;
      if (is_vertex)
        builder.emplace(path_, static_cast<std::size_t>(element.count), layout_.degree, layout_.has_velocity,
                        options_, [this](SplatPart part, std::size_t k) { return name_of(part, k); });
      const Status read = read_ply_rows(path_, element, numbers_, [&](std::span<const double> numbers) {
        return is_vertex ? add(numbers, *builder) : Status(Done{});
      });
      if (!read) return read.error();
    }
    report(builder->loaded);
    for (const std::string& rest : numbers_.unread()) builder->loaded.report.unread.push_back(rest);
    return builder->finish();
  }

 private:
  Status add(std::span<const double> numbers, SplatBuilder& builder) {
    const SplatRow row = splat(numbers);
    if (!layout_.has_motion) return builder.add(row);
    const auto fits = [](double x) { return std::abs(x) <= std::numeric_limits<float>::max(); };
    for (std::size_t slot = center; slot < slots; ++slot)
      if (!fits(row_[slot]))
        return builder.drop(layout_.name_of(vertex_, slot),
                            "has a number that is not finite in the range of float");
    const auto duration = static_cast<float>(std::min(std::exp(row_[log_duration]), 1e300));
    if (!(duration > 0.0f) || !std::isfinite(duration))
      return builder.drop("trbf_scale", "gives a duration beyond the range of float");
    // The cloud's quaternion is divided by its length, and so is what is added to it. Zero is for add() to
    // find.
    const double length = row.rotation.stableNorm();
    const Eigen::Vector4d turn =
        Eigen::Map<const Eigen::Vector4d>(row_.data() + omega) / (length > 0.0 ? length : 1.0);
    if (!fits(turn.cwiseAbs().maxCoeff())) return builder.drop("omega_0", "turns faster than float can say");
    const std::size_t before = builder.loaded.splats.size();
    if (Status s = builder.add(row); !s) return s;
    if (builder.loaded.splats.size() == before) return Done{};
    if (!builder.loaded.motion) builder.loaded.motion.emplace();
    SplatMotion& moves = *builder.loaded.motion;
    moves.center.push_back(static_cast<float>(row_[center]));
    moves.duration.push_back(duration);
    moves.path.push_back({vector_at(motion).cast<float>(), vector_at(motion + 3).cast<float>(),
                          vector_at(motion + 6).cast<float>()});
    moves.turn.push_back(turn.cast<float>());
    return Done{};
  }

  [[nodiscard]] SplatRow splat(std::span<const double> numbers) {
    for (std::size_t p = 0; p < numbers.size(); ++p)
      if (layout_.slot_of[p] != unused) row_[layout_.slot_of[p]] = numbers[p];
    SplatRow row;
    row.position = vector_at(position);
    for (Eigen::Index k = 0; k < (layout_.flat ? 2 : 3); ++k)
      row.scale[k] = std::exp(row_[scale + static_cast<std::size_t>(k)]);
    row.rotation = Eigen::Map<const Eigen::Vector4d>(row_.data() + rotation);
    if (layout_.has_opacity) row.opacity = opacity_of_logit(row_[opacity]);
    if (layout_.has_harmonics) row.harmonics[0] = vector_at(dc);
    if (layout_.full_color > 0.0)
      row.harmonics[0] = (vector_at(color).array() / layout_.full_color - 0.5).matrix() / first_harmonic;
    const auto per_channel = static_cast<std::size_t>(SplatCloud::coefficients(layout_.degree) - 1);
    for (std::size_t k = 0; k < per_channel; ++k)
      for (std::size_t channel = 0; channel < 3; ++channel)
        row.harmonics[k + 1][static_cast<Eigen::Index>(channel)] = row_[rest + channel * per_channel + k];
    row.velocity = vector_at(velocity);
    return row;
  }

  [[nodiscard]] Eigen::Vector3d vector_at(std::size_t slot) const {
    return Eigen::Map<const Eigen::Vector3d>(row_.data() + slot);
  }

  [[nodiscard]] std::string name_of(SplatPart part, std::size_t k) const {
    const auto per_channel = static_cast<std::size_t>(SplatCloud::coefficients(layout_.degree) - 1);
    std::size_t slot = 0;
    switch (part) {
      case SplatPart::position:
        slot = position + k;
        break;
      case SplatPart::scale:
        slot = scale + k;
        break;
      case SplatPart::rotation:
        slot = rotation + k;
        break;
      case SplatPart::opacity:
        slot = opacity;
        break;
      case SplatPart::velocity:
        slot = velocity + k;
        break;
      case SplatPart::harmonics:
        slot = k >= 3 ? rest + (k % 3) * per_channel + k / 3 - 1 : layout_.has_harmonics ? dc + k : color + k;
        break;
    }
    return layout_.name_of(vertex_, slot);
  }

  void report(LoadedSplats& loaded) const {
    SplatCloud& cloud = loaded.splats;
    cloud.flat = layout_.flat;
    if (is_antialiased(header_.comments)) cloud.filter = SplatFilter::antialiased;
    ReadReport& report = loaded.report;
    const auto use = [&](const char* attribute, std::size_t begin, std::size_t end) {
      ReadReport::Use entry{attribute, {}};
      for (std::size_t slot = begin; slot < end; ++slot)
        if (std::string name = layout_.name_of(vertex_, slot); !name.empty())
          entry.properties.push_back(std::move(name));
      if (!entry.properties.empty()) report.used.push_back(std::move(entry));
    };
    use("position", position, scale);
    use("scale", scale, rotation);
    use("rotation", rotation, opacity);
    use("opacity", opacity, dc);
    use("color", dc, rest);
    use("harmonics", rest, velocity);
    use("velocity", velocity, color);
    use("color", color, center);
    use("motion", center, slots);
    for (std::size_t p = 0; p < layout_.slot_of.size(); ++p)
      if (layout_.slot_of[p] == unused) report.unread.push_back(vertex_.properties[p].name);
    for (const PlyElement& element : header_.elements) {
      if (&element == &vertex_ || element.count == 0) continue;
      for (const PlyProperty& property : element.properties)
        report.unread.push_back(element.name + "." + property.name);
    }
    report.assumed.push_back(std::string(layout_.flat ? "2D" : "3D") +
                             " Gaussian splats: scales are logarithms, opacities logits, colours sRGB");
    if (!layout_.has_opacity) report.assumed.push_back("all splats are opaque, for there is no opacity");
    if (!layout_.has_harmonics && !(layout_.full_color > 0.0))
      report.assumed.push_back("all splats are grey, for there are neither f_dc_0 to f_dc_2 nor colours");
  }

  const std::string& path_;
  const PlyHeader& header_;
  const PlyElement& vertex_;
  const SplatReadOptions& options_;
  Layout layout_;
  PlyNumbers numbers_;
  std::array<double, slots> row_{};
};

}  // namespace

bool declares_splats(const PlyHeader& header) {
  const PlyElement* const vertex = header.find("vertex");
  const auto needed = {"scale_0", "scale_1", "rot_0", "rot_1", "rot_2", "rot_3"};
  return vertex && (vertex->find("packed_position") ||
                    std::all_of(needed.begin(), needed.end(),
                                [&](const char* name) { return vertex->find(name).has_value(); }));
}

Result<LoadedSplats> read_splat_ply(const std::string& path, std::string_view bytes,
                                    const SplatReadOptions& options) {
  const Result<PlyHeader> header = parse_ply_header(path, bytes);
  if (!header) return header.error();
  if (!header->find("vertex")) return Error{path, "vertex", "the file has no such element"};
  if (header->find("vertex")->find("packed_position")) return read_packed_ply(path, bytes, *header, options);
  if (!declares_splats(*header))
    return Error{path, "scale_0", "the file has no splats, with scale_0, scale_1 and rot_0 to rot_3"};
  return SplatPlyReader(path, bytes, *header, options).read();
}

}  // namespace swept::io
