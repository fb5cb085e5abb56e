#include "abuffer/reference/splat_formulas.h"

#include <cmath>

namespace swept::reference {

double decoded(double s) {
  const double v = std::abs(s);
  return std::copysign(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4), s);
}
double encoded(double linear) {
  const double v = std::abs(linear);
  return std::copysign(v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055, linear);
}

std::array<double, 16> harmonics_towards(const Eigen::Vector3d& direction) {
  const double x = direction.x(), y = direction.y(), z = direction.z();
  const double pi = M_PI, xx = x * x, yy = y * y, zz = z * z;
  const double c1 = std::sqrt(3.0 / (4.0 * pi)), c2 = 0.5 * std::sqrt(15.0 / pi);
  const double c3 = 0.25 * std::sqrt(35.0 / (2.0 * pi)), c4 = 0.25 * std::sqrt(21.0 / (2.0 * pi));
  return {0.5 * std::sqrt(1.0 / pi),
          -c1 * y,
          c1 * z,
          -c1 * x,
          c2 * x * y,
          -c2 * y * z,
          0.25 * std::sqrt(5.0 / pi) * (2.0 * zz - xx - yy),
          -c2 * x * z,
          0.5 * c2 * (xx - yy),
          -c3 * y * (3.0 * xx - yy),
          0.5 * std::sqrt(105.0 / pi) * x * y * z,
          -c4 * y * (4.0 * zz - xx - yy),
          0.25 * std::sqrt(7.0 / pi) * z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
          -c4 * x * (4.0 * zz - xx - yy),
          0.25 * std::sqrt(105.0 / pi) * z * (xx - yy),
          -c3 * x * (xx - 3.0 * yy)};
}

void move_by_itself(const SplatCloud& cloud, std::size_t splat, double frame, Eigen::Vector3d& position,
                    Eigen::Quaterniond& rotation, double& opacity) {
  const SplatMotion& motion = *cloud.motion;
  const double dt = (frame - cloud.frame) / motion.frames - double{motion.center[splat]};
  for (int power = 1; power <= 3; ++power)
    position += std::pow(dt, power) * motion.path[splat][static_cast<std::size_t>(power - 1)].cast<double>();
  Eigen::Vector4d wxyz(rotation.w(), rotation.x(), rotation.y(), rotation.z());
  wxyz += dt * motion.turn[splat].cast<double>();
  if (wxyz.stableNorm() > 0.0) {
    wxyz.stableNormalize();
    rotation = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  }
  opacity *= std::exp(-std::pow(dt / double{motion.duration[splat]}, 2));
}

}  // namespace swept::reference
