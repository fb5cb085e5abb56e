#include "splat/io/rotate_harmonics.h"

#include <cmath>
#include <numbers>

#include <Eigen/QR>

namespace swept::io {

// Real spherical harmonics with the Condon-Shortley phase, as Kerbl et al. 2023 train them: appendix of
// KHR_gaussian_splatting.
std::array<double, most_harmonics> harmonic_basis(const Eigen::Vector3d& d) {
  const double x = d.x(), y = d.y(), z = d.z(), xx = x * x, yy = y * y, zz = z * z;
  const double pi = std::numbers::pi;
  const double a = std::sqrt(3.0 / (4.0 * pi)), b = std::sqrt(15.0 / (4.0 * pi)),
               c = std::sqrt(5.0 / (16.0 * pi));
  const double e = std::sqrt(35.0 / (32.0 * pi)), f = std::sqrt(105.0 / (4.0 * pi)),
               g = std::sqrt(21.0 / (32.0 * pi)), h = std::sqrt(7.0 / (16.0 * pi));
  return {first_harmonic,
          -a * y,
          a * z,
          -a * x,
          b * x * y,
          -b * y * z,
          c * (2.0 * zz - xx - yy),
          -b * x * z,
          0.5 * b * (xx - yy),
          -e * y * (3.0 * xx - yy),
          f * x * y * z,
          -g * y * (4.0 * zz - xx - yy),
          h * z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
          -g * x * (4.0 * zz - xx - yy),
          0.5 * f * z * (xx - yy),
          -e * x * (xx - 3.0 * yy)};
}

// A turned splat looks in direction d as it looked in turnᵀ d before. Within a degree that is a linear map of
// the coefficients; it is found from more directions than it has rows, spread evenly over the sphere.
HarmonicRotation::HarmonicRotation(const Eigen::Matrix3d& turn) {
  constexpr int directions = 32;
  Eigen::MatrixXd after(directions, 16), before(directions, 16);
  for (int i = 0; i < directions; ++i) {
    const double z = (2.0 * i + 1.0) / directions - 1.0, r = std::sqrt(1.0 - z * z),
                 angle = 2.399963229728653 * i;
    const Eigen::Vector3d d(r * std::cos(angle), r * std::sin(angle), z);
    const auto there = harmonic_basis(d), here = harmonic_basis(turn.transpose() * d);
    after.row(i) = Eigen::Map<const Eigen::RowVectorXd>(there.data(), 16);
    before.row(i) = Eigen::Map<const Eigen::RowVectorXd>(here.data(), 16);
  }
  for (int degree = 1; degree <= 3; ++degree) {
    const int first = degree * degree, count = 2 * degree + 1;
    const Eigen::MatrixXd left = after.middleCols(first, count), right = before.middleCols(first, count);
    bands_.push_back(left.colPivHouseholderQr().solve(right));
  }
}

void HarmonicRotation::apply(std::array<Eigen::Vector3d, most_harmonics>& harmonics, int degree) const {
  for (int l = 1; l <= degree; ++l) {
    // Coefficients are the columns.
    Eigen::Map<Eigen::Matrix<double, 3, Eigen::Dynamic>> band(
        harmonics[static_cast<std::size_t>(l * l)].data(), 3, 2 * l + 1);
    band = (band * bands_[static_cast<std::size_t>(l - 1)].transpose()).eval();
  }
}

}  // namespace swept::io
