#include "abuffer/stochastic/moving_disc.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace swept::stochastic {

MovingDisc::MovingDisc(const MovingKernel& kernel, double delta, const FilmView& view)
    : kernel_(kernel),
      view_(view),
      delta_(delta),
      per_focal_(1.0 / view.projection.focal_px),
      axis_u_(kernel.axis_u.cast<double>()),
      axis_v_(kernel.axis_v.cast<double>()),
      normal_(axis_u_.cross(axis_v_)),
      center_(kernel.center) {
  const double squared = normal_.squaredNorm();
  exists_ = squared > 0.0 && kernel.weight > 0.0f && kernel.t_begin < 1.0f && kernel.t_end > 0.0f;
  dual_u_ = axis_v_.cross(normal_) / squared;
  dual_v_ = normal_.cross(axis_u_) / squared;
  half_ = (axis_u_.array().square() + axis_v_.array().square()).sqrt();
}

PixelRange MovingDisc::pixels(const Span& time, const PixelRange& window) const {
  const Span span = meet(time, {double{kernel_.t_begin}, double{kernel_.t_end}});
  if (span.empty()) return {};
  HullBounds hull(view_);
  for (const double t : {span.begin, span.end}) {
    const Eigen::Vector3d center = center_at(t);
    for (int corner = 0; corner < 8; ++corner)
      hull.include(center + Eigen::Vector3d((corner & 1) != 0 ? half_.x() : -half_.x(),
                                            (corner & 2) != 0 ? half_.y() : -half_.y(),
                                            (corner & 4) != 0 ? half_.z() : -half_.z()));
  }
  return hull.pixels(window, 0.5);
}

Span MovingDisc::plane(int axis, int side, double tangent) const {
  // How far the disc is beyond the plane at depth z: ±(p − γz), the least over the disc, minus what the lens
  // adds.
  const auto within = [&](double gamma, double further) {
    const double sign = side == 1 ? 1.0 : -1.0;
    const bool parallel = view_.projection.orthographic;
    const double u = axis_u_[axis] - (parallel ? 0.0 : gamma * axis_u_.z()),
                 v = axis_v_[axis] - (parallel ? 0.0 : gamma * axis_v_.z());
    const double reach = std::sqrt(u * u + v * v);
    const auto beyond = [&](double t) {
      const Eigen::Vector3d c = view_.seen(center_at(t));
      return sign * (c[axis] - gamma * c.z()) - reach - further -
             1e-12 * (std::abs(c[axis]) + std::abs(gamma * c.z()) + reach);
    };
    Polyline line;
    line.count = 2;
    line.t[0] = 0.0, line.t[1] = 1.0;
    line.v[0] = beyond(0.0), line.v[1] = beyond(1.0);
    return where_not_above(line);
  };
  return view_.inside(axis, side, tangent, within);
}

Span MovingDisc::tile(int x, int y) const {
  constexpr double margin = 1e-3;  // px
  const Projection& film = view_.projection;
  const double low = 0.5 - margin, high = tile_px_ - 0.5 + margin;
  Span span = meet(plane(0, 0, (x + low - film.center_x) * per_focal_),
                   plane(0, 1, (x + high - film.center_x) * per_focal_));
  span = meet(span, plane(1, 0, (y + low - film.center_y) * per_focal_));
  span = meet(span, plane(1, 1, (y + high - film.center_y) * per_focal_));
  span = meet(span, {double{kernel_.t_begin}, double{kernel_.t_end}});
  if (span.empty()) return span;
  return {span.begin - 1e-7, span.end + 1e-7};
}

std::array<float, 4> MovingDisc::light() const {
  Eigen::Vector4f rgba = kernel_.color;
  if (kernel_.changes_color()) rgba += (placed_ - kernel_.t_mid()) * kernel_.color_rate;
  return {rgba[0], rgba[1], rgba[2], rgba[3]};
}

float MovingDisc::tolerance() const {
  if (kernel_.tolerance_rate == 0.0f) return kernel_.depth_tolerance;
  const double since = double{placed_} - double{kernel_.t_mid()};
  return static_cast<float>(std::max(0.0, kernel_.depth_tolerance + since * kernel_.tolerance_rate));
}

bool MovingDisc::test_placed(const BlockSamples& samples, std::size_t k, int x, int y,
                             SampleHits& hits) const {
  // Segments are half open, so that of two that meet only one is seen.
  if (!(placed_ >= kernel_.t_begin && (placed_ < kernel_.t_end || kernel_.t_end >= 1.0f))) return false;
  const Projection& film = view_.projection;
  Eigen::Vector3d ray((x + 0.5 - film.center_x) * per_focal_, (y + 0.5 - film.center_y) * per_focal_, 1.0);
  Eigen::Vector3d center = center_;
  if (film.orthographic) {
    // From where the ray begins, along the depth.
    center.x() -= ray.x(), center.y() -= ray.y();
    ray = Eigen::Vector3d::UnitZ();
  }
  if (!samples.lens_x.empty()) {
    ray.x() -= double{samples.toward_x[k]}, ray.y() -= double{samples.toward_y[k]};
    center.x() -= double{samples.lens_x[k]}, center.y() -= double{samples.lens_y[k]};
  }
  const Eigen::Vector3d facing = kernel_.facing.cast<double>(), outside = kernel_.outside.cast<double>();
  if (!facing.isZero(0.0) && !(facing.dot(ray) < 0.0)) return false;
  const double slope = normal_.dot(ray);
  if (slope == 0.0) return false;
  const double z = normal_.dot(center) / slope;
  if (!(z >= view_.near)) return false;
  const Eigen::Vector3d off = z * ray - center;
  const double u = dual_u_.dot(off), v = dual_v_.dot(off), radius = u * u + v * v;
  if (!(radius <= 1.0)) return false;
  const Side side = outside.isZero(0.0) ? Side::unknown : outside.dot(ray) < 0.0 ? Side::front : Side::back;
  hits.add(DiscHit{static_cast<std::uint32_t>(k), z,
                   static_cast<float>(double{kernel_.weight} * std::exp(-delta_ * radius)), tolerance(), side,
                   light()});
  return true;
}

}  // namespace swept::stochastic
