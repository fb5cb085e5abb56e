// Spherical harmonics of splats that are turned. Private to splat/io.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "splat/io/splat_builder.h"

namespace swept::io {

/// The basis of SplatCloud::harmonics in direction `d`, of unit length: 1, 4, 9 or 16 functions are the
/// degrees 0 to 3.
[[nodiscard]] std::array<double, most_harmonics> harmonic_basis(const Eigen::Vector3d& d);

/// Turns the coefficients of a splat that is turned itself.
class HarmonicRotation {
 public:
  /// `turn` is orthogonal; a reflection is one too.
  explicit HarmonicRotation(const Eigen::Matrix3d& turn);

  void apply(std::array<Eigen::Vector3d, most_harmonics>& harmonics, int degree) const;

 private:
  std::vector<Eigen::MatrixXd> bands_;  ///< of degrees 1 to 3
};

}  // namespace swept::io
