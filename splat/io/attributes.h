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
};

/// Which columns of a file make up which attribute; indices into its list of columns.
struct AttributePlan {
  using Triple = std::array<std::size_t, 3>;
  Triple position{};
  std::optional<Triple> normal, velocity, color;
  std::optional<std::size_t> radius, opacity, alpha;
  bool radius_is_diameter = false;
  /// Gaussian splats: two or three log scales, quaternion w x y z, first spherical harmonic.
  std::vector<std::size_t> log_scale;
  std::array<std::size_t, 4> quaternion{};
  std::optional<Triple> harmonic;

  /// Whether column i is needed, for each of `count` columns.
  [[nodiscard]] std::vector<bool> needed(std::size_t count) const;
};

/// Errors: no position, names in options.attributes that are no attribute or no column.
[[nodiscard]] Result<AttributePlan> plan_attributes(const std::string& path,
                                                    const std::vector<Column>& columns,
                                                    const ReadOptions& options);

/// Puts the set together. `values[c]` has one number per point for every needed column c. Triangles refer to
/// the file's points; those that lose a corner to options.skip_invalid are dropped. Errors: no
/// points, numbers that are not finite (or beyond single precision), negative radii, opacities outside [0,
/// 1].
[[nodiscard]] Result<PointSet> assemble_points(const std::string& path, const std::vector<Column>& columns,
                                               const AttributePlan& plan,
                                               const std::vector<std::vector<double>>& values,
                                               std::vector<std::array<std::uint32_t, 3>> triangles,
                                               const ReadOptions& options);

}  // namespace swept
