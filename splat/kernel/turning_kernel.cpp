#include "splat/kernel/turning_kernel.h"

namespace swept {
namespace {

/// The kernel as it stands at that time.
KernelPlane<double> plane_at(const MovingKernel& kernel, const DiscTurn& turn, double time, double later,
                             bool orthographic) {
  const double s = time - double{kernel.t_mid()}, half = kernel.half_time();
  const DiscTurn::Axes axes = turn.at(kernel, time + later);
  MovingKernel still = kernel;
  still.center += s * kernel.velocity + (s * s - half * half / 3.0) * kernel.bend;
  still.velocity.setZero();
  still.axis_u = axes.u.cast<float>();
  still.axis_v = axes.v.cast<float>();
  return KernelPlane<double>(still, orthographic);
}

}  // namespace

void turn_towards(const Eigen::Vector3d& to_u, const Eigen::Vector3d& to_v, Eigen::Vector3d& u,
                  Eigen::Vector3d& v) {
  const double cosine = u.dot(to_u) + v.dot(to_v), sine = v.dot(to_u) - u.dot(to_v);
  const double length = std::hypot(cosine, sine);
  if (!(length > 0.0)) return;
  const double c = cosine / length, s = sine / length;
  const Eigen::Vector3d turned = c * u + s * v;
  v = c * v - s * u;
  u = turned;
}

DiscTurn turn_through(const FilteredDisc& first, const MovingKernel& kernel, const FilteredDisc& last) {
  const double half = kernel.half_time();
  const Eigen::Vector3d u = kernel.axis_u.cast<double>(), v = kernel.axis_v.cast<double>();
  FilteredDisc from = first, to = last;
  turn_towards(u, v, from.axis_u, from.axis_v);
  turn_towards(u, v, to.axis_u, to.axis_v);
  const auto rate = [&](const auto& a, const auto& b) { return (b - a) / (2.0 * half); };
  const auto bend = [&](const auto& a, const auto& m, const auto& b) {
    return (a + b - 2.0 * m) / (2.0 * half * half);
  };
  const double weight = kernel.weight;
  DiscTurn turn;
  turn.u_rate = Eigen::Vector3d(rate(from.axis_u, to.axis_u)).cast<float>();
  turn.v_rate = Eigen::Vector3d(rate(from.axis_v, to.axis_v)).cast<float>();
  turn.u_bend = Eigen::Vector3d(bend(from.axis_u, u, to.axis_u)).cast<float>();
  turn.v_bend = Eigen::Vector3d(bend(from.axis_v, v, to.axis_v)).cast<float>();
  turn.weight_rate = static_cast<float>(rate(from.weight, to.weight));
  turn.weight_bend = static_cast<float>(bend(from.weight, weight, to.weight));
  turn.t_mid = kernel.t_mid();
  return turn;
}

TurningPlane::TurningPlane(const MovingKernel& kernel, const DiscTurn& turn, double later, bool orthographic)
    : begin_(kernel.t_begin),
      end_(kernel.t_end),
      first_(plane_at(kernel, turn, begin_, later, orthographic)),
      middle_(plane_at(kernel, turn, 0.5 * (begin_ + end_), later, orthographic)),
      last_(plane_at(kernel, turn, end_, later, orthographic)),
      weight_(kernel.weight),
      weight_rate_(turn.weight_rate),
      weight_bend_(turn.weight_bend),
      t_mid_(double{turn.t_mid} - later) {}

bool TurningPlane::intersect(double x, double y, double near, double delta,
                             RayFragment<double>& fragment) const {
  const Seen seen = along(x, y);
  return intersect_bent_tube<double>(seen.mean, seen.bend, begin_, end_, near, delta, 1.0, fragment) &&
         weigh(fragment);
}

/// Times a weight that changes evenly, e^(κs): that makes another Gaussian of it, whose peak is elsewhere.
/// One that hardly changes by itself gets what width the change asks for, with the mean it had.
bool TurningPlane::weigh(RayFragment<double>& fragment) const {
  const double reach = 0.5 * (fragment.t_end - fragment.t_begin), center = fragment.t_begin + reach;
  const double weight = weight_at(center) + weight_bend_ * reach * reach / 3.0;
  if (!(weight > 0.0)) return false;
  fragment.peak *= weight;
  constexpr double least = 0.004, most = 0.5, narrowest = 0.25;
  const double change = (weight_rate_ + 2.0 * (center - t_mid_) * weight_bend_) / weight * reach;
  if (!(std::abs(change) > least)) return fragment.peak > 0.0;
  // In units of `reach`, from the middle.
  const double y = fragment.y_begin + fragment.rate * reach, rate = fragment.rate * reach;
  const double slope = std::clamp(change, -most, most) - 2.0 * y * rate;
  const double new_rate = std::max(rate, narrowest), new_y = -slope / (2.0 * new_rate);
  fragment.peak *= std::exp(new_y * new_y - y * y) * (1.0 + (new_rate * new_rate - rate * rate) / 3.0);
  fragment.rate = new_rate / reach;
  fragment.y_begin = new_y - new_rate;
  return fragment.peak > 0.0;
}

}  // namespace swept
