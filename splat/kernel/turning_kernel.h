// A moving kernel whose disc turns, grows or comes nearer along its segment, seen along one viewing ray.
//
// Source: our own; bent_kernel.h. A kernel has the axes of its segment's middle, and the pixel filter that
// belongs there. Where these change the disc's coordinates along a ray are those of three discs, at the
// begin, the middle and the end: through them goes a parabola in time, of which the ray has the line that
// fits while it sees the disc.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/kernel/bent_kernel.h"
#include "splat/kernel/ray_kernel.h"
#include "splat/kernel/screen_bounds.h"

namespace SWEPT_API swept {

/// How the axes and the weight of a kernel's filtered disc change: at shutter time t_mid they are the
/// kernel's, s later axis_u + s·u_rate + s²·u_bend and so on.
struct DiscTurn {
  Eigen::Vector3f u_rate, v_rate, u_bend, v_bend;
  float weight_rate = 0.0f, weight_bend = 0.0f;
  float t_mid = 0.0f;

  struct Axes {
    Eigen::Vector3d u, v;
  };
  [[nodiscard]] Axes at(const MovingKernel& kernel, double time) const {
    const double s = time - double{t_mid};
    return {kernel.axis_u.cast<double>() + s * (u_rate.cast<double>() + s * u_bend.cast<double>()),
            kernel.axis_v.cast<double>() + s * (v_rate.cast<double>() + s * v_bend.cast<double>())};
  }
  [[nodiscard]] std::array<float, 15> content() const {
    return {u_rate[0], u_rate[1], u_rate[2], v_rate[0], v_rate[1],   v_rate[2],   u_bend[0], u_bend[1],
            u_bend[2], v_bend[0], v_bend[1], v_bend[2], weight_rate, weight_bend, t_mid};
  }
};

/// Through what is there at the ends and in the middle of a segment, whose filtered disc that of the kernel
/// is. The discs at the ends are first turned within themselves, to be as near to that as they can.
[[nodiscard]] DiscTurn turn_through(const FilteredDisc& first, const MovingKernel& kernel,
                                    const FilteredDisc& last);

/// Of two axes those of the same disc that are nearest to `to_u` and `to_v`.
void turn_towards(const Eigen::Vector3d& to_u, const Eigen::Vector3d& to_v, Eigen::Vector3d& u,
                  Eigen::Vector3d& v);

/// screen_bounds() of such a kernel.
[[nodiscard]] bool turning_bounds(const MovingKernel& kernel, const DiscTurn& turn,
                                  const Projection& projection, double near, Octagon& octagon);

/// Whichever the kernel is.
[[nodiscard]] inline bool bounds_of(const MovingKernel& kernel, const DiscTurn* turn,
                                    const Projection& projection, double near, Octagon& octagon) {
  return turn != nullptr ? turning_bounds(kernel, *turn, projection, near, octagon)
                         : screen_bounds(kernel, projection, near, octagon);
}

/// What of such a kernel does not depend on the ray.
class TurningPlane {
 public:
  /// `later`: by which the kernel's times are earlier than the turn's.
  TurningPlane(const MovingKernel& kernel, const DiscTurn& turn, double later, bool orthographic);

  /// As intersect_bent_tube(), for the ray (x, y).
  [[nodiscard]] bool intersect(double x, double y, double near, double delta,
                               RayFragment<double>& fragment) const;

  /// What intersect() takes its kernel of weight 1 for.
  struct Seen {
    RayCoordinates<double> mean;
    RayBend<double> bend;
  };
  [[nodiscard]] Seen along(double x, double y) const {
    const double half = 0.5 * (end_ - begin_);
    const RayCoordinates<double> a = first_.along(x, y), m = middle_.along(x, y), b = last_.along(x, y);
    const auto mean = [](double from, double middle, double to) {
      return (from + to + 4.0 * middle) * (1.0 / 6.0);
    };
    const double per_time = 0.5 / half, per_square = 0.5 / (half * half);
    return {{mean(a.u, m.u, b.u), mean(a.v, m.v, b.v), mean(a.z, m.z, b.z), (b.u - a.u) * per_time,
             (b.v - a.v) * per_time, (b.z - a.z) * per_time},
            {(a.u + b.u - 2.0 * m.u) * per_square, (a.v + b.v - 2.0 * m.v) * per_square,
             (a.z + b.z - 2.0 * m.z) * per_square}};
  }
  /// And gives the fragment of it the weight that there is. False: none.
  [[nodiscard]] bool weigh(RayFragment<double>& fragment) const;

 private:
  [[nodiscard]] double weight_at(double time) const {
    const double s = time - t_mid_;
    return weight_ + s * (weight_rate_ + s * weight_bend_);
  }

  double begin_, end_;
  KernelPlane<double> first_, middle_, last_;
  double weight_, weight_rate_, weight_bend_, t_mid_;
};

}  // namespace swept
