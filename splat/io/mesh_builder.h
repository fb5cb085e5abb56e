// What the readers of OBJ and OFF files share. Written here rather than taken from OpenMesh: its readers
// round positions to float, leave out vertices they cannot read (which renumbers the rest), drop faces that
// are not manifold, believe the header's counts, and print.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "splat/io/attributes.h"
#include "splat/io/file_bytes.h"
#include "splat/io/read_formats.h"
#include "splat/result.h"

namespace swept {

[[nodiscard]] std::optional<std::int64_t> parse_integer(std::string_view token);

/// A mesh in the making, and where in its file we are. Every vertex has x y z, and may have further numbers:
/// what they mean is decided when all have been seen.
class MeshBuilder {
 public:
  MeshBuilder(const std::string& path, LineScanner scanner) : lines(scanner), path_(path) {}

  LineScanner lines;
  std::vector<Triangle> triangles;
  std::vector<TextureCorners> texture_corners;  ///< one a triangle, or none

  /// The tokens from `x` to the end of the line as a vertex.
  [[nodiscard]] Status add_vertex(std::string_view x);

  [[nodiscard]] std::size_t vertex_count() const { return values_[0].size(); }
  /// A number of every vertex that does not stand beside its x y z.
  void add_column(const std::string& name, std::vector<double> values);
  /// How many numbers every vertex has beside x y z; none if they differ.
  [[nodiscard]] std::optional<std::size_t> further_numbers() const;

  [[nodiscard]] Error fail(const std::string& what, const std::string& reason) const;

  /// The points. `further` names the numbers after x y z, as many as there are; "" leaves one unread.
  [[nodiscard]] Result<PointSet> finish(const std::vector<std::string>& further, const ReadOptions& options);

 private:
  const std::string& path_;
  std::vector<std::vector<double>> values_ = std::vector<std::vector<double>>(3);
  std::vector<Column> columns_{{"x"}, {"y"}, {"z"}};
  std::vector<double> further_;              ///< of all vertices, one after the other
  std::size_t least_ = SIZE_MAX, most_ = 0;  ///< of them, a vertex
};

}  // namespace swept
