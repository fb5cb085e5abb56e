// PLY with positions in double, both byte orders, lists anywhere, and triangle strips. Written here rather
// than taken from PCL or OpenMesh: those read positions as float and believe the header's counts.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "splat/io/attribute_names.h"
#include "splat/io/attributes.h"
#include "splat/io/file_bytes.h"
#include "splat/io/ply_header.h"
#include "splat/io/ply_numbers.h"
#include "splat/io/read_formats.h"

namespace swept {
namespace {

double full_scale_of(PlyType type) {
  if (type.kind == PlyType::Kind::real) return 0.0;
  if (type.bytes == 4) return 255.0;  // nobody stores 32-bit colours; those who write ints mean bytes
  const int bits = static_cast<int>(8 * type.bytes) - (type.kind == PlyType::Kind::signed_integer ? 1 : 0);
  return std::ldexp(1.0, bits) - 1.0;
}

class PlyReader {
 public:
  PlyReader(const std::string& path, std::string_view bytes, PlyHeader header, const ReadOptions& options)
      : path_(path),
        header_(std::move(header)),
        options_(options),
        stream_(bytes.substr(header_.body), header_.format) {}

  Result<PointSet> read() {
    const auto vertex = std::find_if(header_.elements.begin(), header_.elements.end(),
                                     [](const PlyElement& e) { return e.name == "vertex"; });
    if (vertex == header_.elements.end()) {
      std::vector<std::string> names;
      for (const PlyElement& element : header_.elements) names.push_back(element.name);
      return Error{path_, "vertex",
                   "the file has no such element" + (names.empty() ? "" : "; it has " + listed(names))};
    }
    vertex_count_ = vertex->count;
    for (const PlyProperty& p : vertex->properties) {
      column_of_.push_back(columns_.size());
      if (p.is_list && is_vector_name(p.name))
        add_vector_columns(p.name, full_scale_of(p.type), columns_);
      else
        columns_.push_back({p.name, full_scale_of(p.type), "", p.is_list});
    }
    Result<AttributePlan> plan = plan_attributes(path_, columns_, options_);
    if (!plan) return plan.error();
    needed_ = plan->needed(columns_.size());
    values_.resize(columns_.size());
    if (options_.texture) find_texture_columns();

    for (const PlyElement& element : header_.elements) {
      if (Status s = read_element(element); !s) return s.error();
    }
    const bool of_faces = !face_uv_.empty();
    if (of_faces && face_uv_.size() != triangles_.size())
      return Error{path_, texcoord, "strips of triangles have none, and faces have"};
    if (!of_faces && texture_columns_) {
      if (Status s = spread_texture(); !s) return s.error();
    }
    Result<PointSet> set = assemble_points(path_, columns_, *plan, values_, std::move(triangles_), options_,
                                           std::move(face_uv_));
    if (!set) return set;
    report_elements(set->report);
    for (const std::string& rest : stream_.unread()) set->report.unread.push_back(rest);
    report_texture(of_faces, set->report);
    return set;
  }

 private:
  static constexpr const char* texcoord = "texcoord";

  /// Of vertices, as the tools that write them call them.
  void find_texture_columns() {
    for (const auto& [u, v] : {std::pair{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}}) {
      const auto at = [&](const char* name) {
        return static_cast<std::size_t>(
            std::find_if(columns_.begin(), columns_.end(),
                         [&](const Column& c) { return c.name == name && !c.is_list; }) -
            columns_.begin());
      };
      if (const std::size_t cu = at(u), cv = at(v); cu < columns_.size() && cv < columns_.size()) {
        needed_[cu] = needed_[cv] = true;
        texture_columns_ = {cu, cv};
        return;
      }
    }
  }

  /// From vertices to the corners of triangles.
  Status spread_texture() {
    const auto [u, v] = *texture_columns_;
    for (std::size_t i = 0; i < values_[u].size(); ++i)
      for (const std::size_t c : {u, v})
        if (!(std::abs(values_[c][i]) <= double{most_texture_coordinate}))
          return Error{path_, columns_[c].name,
                       "point " + std::to_string(i) + ": must be between -1e6 and 1e6"};
    face_uv_.reserve(triangles_.size());
    for (const Triangle& triangle : triangles_) {
      TextureCorners corners;
      for (std::size_t k = 0; k < 3; ++k)
        corners[k] = Eigen::Vector2d(values_[u][triangle[k]], values_[v][triangle[k]]).cast<float>();
      face_uv_.push_back(corners);
    }
    return Done{};
  }

  void report_texture(bool of_faces, ReadReport& report) const {
    ReadReport::Use use{"texture coordinates", {}};
    if (of_faces) {
      use.properties = {std::string("face.") + texcoord};
    } else if (texture_columns_) {
      use.properties = {columns_[texture_columns_->first].name, columns_[texture_columns_->second].name};
    } else {
      return;
    }
    for (const std::string& name : use.properties) std::erase(report.unread, name);
    report.used.push_back(std::move(use));
  }

  /// Of one face, after all of its properties were read.
  Status end_face(const PlyElement& element, const PlyProperty& property, std::uint64_t row) {
    if (uv_.size() != 2 * corners_.size())
      return fail(element, property, row,
                  "must have two numbers for each of the face's " + std::to_string(corners_.size()) +
                      " corners, and has " + std::to_string(uv_.size()));
    std::vector<Eigen::Vector2f> places;
    for (std::size_t k = 0; k < uv_.size(); k += 2) {
      if (!(std::max(std::abs(uv_[k]), std::abs(uv_[k + 1])) <= double{most_texture_coordinate}))
        return fail(element, property, row, "must be between -1e6 and 1e6");
      places.push_back(Eigen::Vector2d(uv_[k], uv_[k + 1]).cast<float>());
    }
    add_fan(places, face_uv_);
    return Done{};
  }

  [[nodiscard]] bool is_texcoord(const PlyElement& element, const PlyProperty& property) const {
    return options_.texture && element.name == "face" && property.is_list && property.name == texcoord;
  }

  Status read_element(const PlyElement& element) {
    if (element.properties.empty()) return Done{};
    std::uint64_t least = 0;
    for (const PlyProperty& p : element.properties) {
      least += stream_.least_bytes(p.is_list ? p.count_type : p.type);
    }
    if (!stream_.can_hold(element.count, least)) {
      return Error{path_, element.name,
                   "the header promises " + std::to_string(element.count) + " of at least " +
                       std::to_string(least) + " bytes each, the file has " +
                       std::to_string(stream_.bytes_left()) + " bytes left"};
    }
    const bool is_vertex = element.name == "vertex", one_line = !element.has_lists();
    if (is_vertex) {
      for (std::size_t c = 0; c < values_.size(); ++c) {
        if (needed_[c]) values_[c].reserve(static_cast<std::size_t>(element.count));
      }
    }
    const auto with_texcoord = std::find_if(element.properties.begin(), element.properties.end(),
                                            [&](const auto& p) { return is_texcoord(element, p); });
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (one_line) stream_.begin_row();
      for (std::size_t c = 0; c < element.properties.size(); ++c) {
        const PlyProperty& property = element.properties[c];
        const std::size_t column = is_vertex ? column_of_[c] : 0;
        if (property.is_list) {
          const bool vector = is_vertex && !columns_[column].is_list;
          if (Status s =
                  vector ? read_vector(element, property, row, column) : read_list(element, property, row);
              !s)
            return s;
          continue;
        }
        const std::optional<double> value = stream_.next(property.type);
        if (!value) return fail(element, property, row, stream_.fault());
        if (is_vertex && needed_[column]) values_[column].push_back(*value);
      }
      if (with_texcoord != element.properties.end()) {
        if (Status s = end_face(element, *with_texcoord, row); !s) return s;
      }
      if (one_line && !stream_.end_row()) {
        return fail(element, element.properties.back(), row, "the line goes on after it");
      }
    }
    return Done{};
  }

  /// A list that is one vector; of another length it is skipped where nothing needs it.
  Status read_vector(const PlyElement& element, const PlyProperty& property, std::uint64_t row,
                     std::size_t column) {
    const bool needed = needed_[column] || needed_[column + 1] || needed_[column + 2];
    if (!needed) return read_list(element, property, row);
    const std::optional<double> length = stream_.next(property.count_type);
    if (!length) return fail(element, property, row, stream_.fault());
    if (*length != 3.0) {
      return fail(element, property, row,
                  "its list must have 3 numbers; an empty name in \"attributes\" leaves it unread");
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<double> value = stream_.next(property.type);
      if (!value) return fail(element, property, row, stream_.fault());
      if (needed_[column + k]) values_[column + k].push_back(*value);
    }
    return Done{};
  }

  /// What else the file holds. Faces are read, but for what they say beside their corners.
  void report_elements(ReadReport& report) const {
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex" || element.count == 0) continue;
      for (const PlyProperty& property : element.properties) {
        if (!is_corners(element, property)) report.unread.push_back(element.name + "." + property.name);
      }
    }
  }

  static bool is_corners(const PlyElement& element, const PlyProperty& property) {
    return (element.name == "face" || element.name == "tristrips") && property.is_list &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
  }

  Status read_list(const PlyElement& element, const PlyProperty& property, std::uint64_t row) {
    const std::optional<double> length = stream_.next(property.count_type);
    if (!length) return fail(element, property, row, stream_.fault());
    if (!(*length >= 0.0 && *length == std::floor(*length) && *length < 0x1p53)) {
      return fail(element, property, row, "the length of its list is not a whole number ≥ 0");
    }
    const auto count = static_cast<std::uint64_t>(*length);
    if (!stream_.can_hold(count, stream_.least_bytes(property.type))) {
      return fail(element, property, row,
                  "its list of " + std::to_string(count) + " entries runs past the end of the file");
    }
    const bool wanted = is_corners(element, property), is_strip = wanted && element.name == "tristrips",
               is_uv = is_texcoord(element, property);
    if (wanted) corners_.clear();
    if (is_uv) uv_.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::optional<double> value = stream_.next(property.type);
      if (!value) return fail(element, property, row, stream_.fault());
      if (is_uv) uv_.push_back(*value);
      if (!wanted) continue;
      const bool valid =
          *value >= 0.0 && *value < static_cast<double>(vertex_count_) && *value == std::floor(*value);
      if (!valid && !(is_strip && *value == -1.0)) {
        return fail(element, property, row,
                    "an index does not name one of the " + std::to_string(vertex_count_) + " vertices");
      }
      corners_.push_back(static_cast<std::int64_t>(*value));
    }
    if (is_strip) {
      add_strips(corners_, triangles_);
    } else if (wanted) {
      add_fan(std::vector<std::uint32_t>(corners_.begin(), corners_.end()), triangles_);
    }
    return Done{};
  }

  [[nodiscard]] Error fail(const PlyElement& element, const PlyProperty& property, std::uint64_t row,
                           const std::string& reason) const {
    return {path_, property.name, element.name + " " + std::to_string(row) + ": " + reason};
  }

  const std::string& path_;
  PlyHeader header_;
  const ReadOptions& options_;
  PlyNumbers stream_;
  std::uint64_t vertex_count_ = 0;
  std::vector<Column> columns_;
  std::vector<std::size_t> column_of_;  ///< of each property of the vertices, the first
  std::vector<bool> needed_;
  std::vector<std::vector<double>> values_;
  std::vector<std::int64_t> corners_;
  std::vector<Triangle> triangles_;
  std::vector<double> uv_;  ///< of a face
  std::vector<TextureCorners> face_uv_;
  std::optional<std::pair<std::size_t, std::size_t>> texture_columns_;
};

}  // namespace

Result<PointSet> read_ply(const std::string& path, std::string_view bytes, const ReadOptions& options) {
  Result<PlyHeader> header = parse_ply_header(path, bytes);
  if (!header) return header.error();
  return PlyReader(path, bytes, *std::move(header), options).read();
}

}  // namespace swept
