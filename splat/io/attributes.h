// From the named columns of a file to a PointSet: what all point formats have in common.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "splat/io/point_file.h"
#include "splat/result.h"

namespace swept {

/// A column of numbers that a file declares.
struct Column {
  std::string name;
  double full_scale = 0.0;  ///< greatest value of an integer type, what a colour of 1 is stored as; 0: real
  std::string number = {};  ///< another name, of columns of text
  bool is_list = false;     ///< only reported: no attribute is made of lists
};

/// Which columns of a file make up which attribute; indices into its list of columns.
struct AttributePlan {
  using Triple = std::array<std::size_t, 3>;
  Triple position{};
  std::optional<Triple> normal, velocity, acceleration, angular_velocity, color;
  std::optional<std::size_t> radius, opacity, alpha;  ///< one of opacity and alpha at most
  std::optional<std::size_t> intensity;               ///< not beside colours
  std::optional<std::size_t> id, time;
  bool radius_is_diameter = false;
  /// Gaussian splats: two or three log scales, quaternion w x y z, first spherical harmonic.
  std::vector<std::size_t> log_scale;
  std::array<std::size_t, 4> quaternion{};
  std::optional<Triple> harmonic;

  /// What is used and what is not, by name; the rest of the report is for the readers to fill in.
  [[nodiscard]] ReadReport report(const std::vector<Column>& columns) const;

  /// Whether column i is needed, for each of `count` columns.
  [[nodiscard]] std::vector<bool> needed(std::size_t count) const;
};

/// Errors: no position, names in options.attributes that are no attribute or no column.
[[nodiscard]] Result<AttributePlan> plan_attributes(const std::string& path,
                                                    const std::vector<Column>& columns,
                                                    const ReadOptions& options);

/// The columns of a property that holds three numbers: "v[0]", "v[1]", "v[2]".
void add_vector_columns(const std::string& name, double full_scale, std::vector<Column>& columns);

/// Puts the set together. `values[c]` has one number per point for every needed column c. Triangles refer to
/// the file's points; those that lose a corner to options.skip_invalid are dropped, and what `corners` says
/// of them (one a triangle, or none) with them. Errors: no points, numbers that are not finite (or beyond
/// single precision), negative radii, opacities outside [0, 1], options out of range. Intensities and ids
/// that are no good are left unused, and the report says so.
[[nodiscard]] Result<PointSet> assemble_points(const std::string& path, const std::vector<Column>& columns,
                                               const AttributePlan& plan,
                                               const std::vector<std::vector<double>>& values,
                                               std::vector<std::array<std::uint32_t, 3>> triangles,
                                               const ReadOptions& options,
                                               std::vector<TextureCorners> corners = {});

}  // namespace swept
