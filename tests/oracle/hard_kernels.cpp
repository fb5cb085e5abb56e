#include "tests/oracle/hard_kernels.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace swept::oracle {

using Eigen::Vector3d;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

double magnitude(Random& random, double low, double high) {
  return (random() % 2 ? 1.0 : -1.0) * std::pow(10.0, uniform(random, low, high));
}

Vector3d direction(Random& random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

namespace {

/// On the film, 0.5 to 50 units away.
Vector3d some_center(Random& random) {
  const double z = std::abs(magnitude(random, -0.3, 1.7));
  return {z * uniform(random, -0.5, 0.5), z * uniform(random, -0.5, 0.5), z};
}

void set_axes(MovingKernel& kernel, Random& random, const Vector3d& normal, double radius) {
  const Vector3d side = normal.unitOrthogonal(), up = normal.cross(side);
  const double angle = uniform(random, 0.0, 2.0 * std::numbers::pi);
  kernel.axis_u = (radius * (std::cos(angle) * side + std::sin(angle) * up)).cast<float>();
  kernel.axis_v =
      (radius * uniform(random, 0.3, 1.0) * (std::cos(angle) * up - std::sin(angle) * side)).cast<float>();
}

/// A disc of 0.3 to 300 px that moves by about as much; the base the cases vary.
MovingKernel some_kernel(Random& random) {
  MovingKernel kernel;
  kernel.center = some_center(random);
  const double pixel = kernel.center.z() / focal_px;
  const double radius = pixel * std::abs(magnitude(random, -0.5, 2.5));
  set_axes(kernel, random, direction(random), radius);
  kernel.velocity = radius * std::abs(magnitude(random, -1.0, 1.0)) * direction(random);
  kernel.facing.setZero();
  kernel.color.setOnes();
  return kernel;
}

/// A ray through a point of the disc, or just beside it, at some time.
KernelAndRay with_ray(const MovingKernel& kernel, Random& random) {
  const double angle = uniform(random, 0.0, 2.0 * std::numbers::pi),
               radius = 1.1 * std::sqrt(uniform(random, 0.0, 1.0));
  const Vector3d point = kernel.center + uniform(random, -0.5, 0.5) * kernel.velocity +
                         radius * (std::cos(angle) * kernel.axis_u.cast<double>() +
                                   std::sin(angle) * kernel.axis_v.cast<double>());
  if (point.z() > 0.0) return {kernel, point.x() / point.z(), point.y() / point.z()};
  return {kernel, uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0)};
}

KernelAndRay ordinary(Random& random) { return with_ray(some_kernel(random), random); }

KernelAndRay no_motion(Random& random) {
  MovingKernel kernel = some_kernel(random);
  kernel.velocity.setZero();
  return with_ray(kernel, random);
}

KernelAndRay motion_in_plane(Random& random) {
  MovingKernel kernel = some_kernel(random);
  kernel.velocity = uniform(random, -3.0, 3.0) * kernel.axis_u.cast<double>() +
                    uniform(random, -3.0, 3.0) * kernel.axis_v.cast<double>();
  return with_ray(kernel, random);
}

KernelAndRay motion_along_ray(Random& random) {
  MovingKernel kernel = some_kernel(random);
  KernelAndRay result = with_ray(kernel, random);
  result.kernel.velocity = kernel.center.z() * uniform(random, -0.5, 0.5) * Vector3d(result.x, result.y, 1.0);
  return result;
}

/// Tilted by 10⁻¹² to 10⁻¹ from the line of sight.
KernelAndRay edge_on(Random& random) {
  MovingKernel kernel = some_kernel(random);
  const Vector3d sight = kernel.center.normalized();
  const Vector3d normal = sight.cross(direction(random)).normalized();
  const double radius = kernel.axis_u.norm();
  set_axes(kernel, random, (normal + magnitude(random, -12.0, -1.0) * sight).normalized(), radius);
  return with_ray(kernel, random);
}

KernelAndRay through_near_plane(Random& random) {
  MovingKernel kernel = some_kernel(random);
  kernel.center = Vector3d(uniform(random, -0.1, 0.1), uniform(random, -0.1, 0.1),
                           near_depth * uniform(random, 0.7, 1.3));
  kernel.velocity = direction(random) * near_depth;
  set_axes(kernel, random, direction(random), 0.03);
  return with_ray(kernel, random);
}

KernelAndRay through_eye(Random& random) {
  MovingKernel kernel = some_kernel(random);
  kernel.center = direction(random) * std::abs(magnitude(random, -9.0, -2.0));
  kernel.velocity = direction(random) * uniform(random, 1.0, 3.0);
  set_axes(kernel, random, direction(random), std::abs(magnitude(random, -2.0, 0.0)));
  return with_ray(kernel, random);
}

KernelAndRay motion_px(Random& random, double px) {
  MovingKernel kernel = some_kernel(random);
  kernel.velocity = direction(random) * px * kernel.center.z() / focal_px;
  return with_ray(kernel, random);
}

KernelAndRay motion_minute(Random& random) { return motion_px(random, 1e-6); }
KernelAndRay motion_vast(Random& random) { return motion_px(random, 1e5); }

KernelAndRay zero_axis(Random& random) {
  MovingKernel kernel = some_kernel(random);
  (random() % 2 ? kernel.axis_u : kernel.axis_v).setZero();
  return with_ray(kernel, random);
}

KernelAndRay parallel_axes(Random& random) {
  MovingKernel kernel = some_kernel(random);
  kernel.axis_v = static_cast<float>(uniform(random, -2.0, 2.0)) * kernel.axis_u;
  return with_ray(kernel, random);
}

KernelAndRay enormous_axes(Random& random) {
  MovingKernel kernel = some_kernel(random);
  set_axes(kernel, random, direction(random), std::abs(magnitude(random, 4.0, 30.0)));
  KernelAndRay result{kernel, uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5)};
  return result;
}

KernelAndRay survey(Random& random) {
  MovingKernel kernel = some_kernel(random);
  kernel.center = 5e6 * Vector3d(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), 1.0);
  set_axes(kernel, random, direction(random), std::abs(magnitude(random, -1.0, 5.0)));
  kernel.velocity = kernel.axis_u.norm() * uniform(random, 0.0, 3.0) * direction(random);
  return with_ray(kernel, random);
}

KernelAndRay sub_pixel(Random& random) {
  MovingKernel kernel = some_kernel(random);
  set_axes(kernel, random, direction(random),
           std::abs(magnitude(random, -8.0, -1.0)) * kernel.center.z() / focal_px);
  return with_ray(kernel, random);
}

KernelAndRay screen_filling(Random& random) {
  MovingKernel kernel = some_kernel(random);
  set_axes(kernel, random, direction(random), kernel.center.z() * uniform(random, 0.5, 5.0));
  return {kernel, uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5)};
}

}  // namespace

const std::vector<HardCase>& hard_cases() {
  static const std::vector<HardCase> cases = {
      {"ordinary", ordinary, true},
      {"no motion", no_motion, false},
      {"motion in the disc's plane", motion_in_plane, false},
      {"motion along the ray", motion_along_ray, true},
      {"edge-on", edge_on, true},
      {"through the near plane", through_near_plane, true},
      {"through the eye", through_eye, true},
      {"1e-6 px of motion", motion_minute, true},
      {"1e5 px of motion", motion_vast, true},
      {"an axis of length zero", zero_axis, false},
      {"parallel axes", parallel_axes, false},
      {"enormous axes", enormous_axes, true},
      {"5e6 m away", survey, false},
      {"sub-pixel", sub_pixel, true},
      {"screen-filling", screen_filling, true},
  };
  return cases;
}

}  // namespace swept::oracle
