// PLY with positions in double, both byte orders, lists anywhere, and triangle strips. Written here rather
// than taken from PCL or OpenMesh: those read positions as float and believe the header's counts.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

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

    for (const PlyElement& element : header_.elements) {
      if (Status s = read_element(element); !s) return s.error();
    }
    Result<PointSet> set = assemble_points(path_, columns_, *plan, values_, std::move(triangles_), options_);
    if (set) report_elements(set->report);
    return set;
  }

 private:
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
    const bool wanted = is_corners(element, property), is_strip = wanted && element.name == "tristrips";
    corners_.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::optional<double> value = stream_.next(property.type);
      if (!value) return fail(element, property, row, stream_.fault());
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
      add_fan({corners_.begin(), corners_.end()}, triangles_);
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
};

}  // namespace

Result<PointSet> read_ply(const std::string& path, std::string_view bytes, const ReadOptions& options) {
  Result<PlyHeader> header = parse_ply_header(path, bytes);
  if (!header) return header.error();
  return PlyReader(path, bytes, *std::move(header), options).read();
}

}  // namespace swept
