#include "splat/io/frame_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

namespace swept::io {
namespace {

struct Box {
  Eigen::Vector3d low, high;
};

/// Where nearly all points are.
Box bulk_of(const std::vector<Eigen::Vector3d>& points) {
  const auto n = static_cast<std::ptrdiff_t>(points.size());
  Box box;
  std::vector<double> along(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), along.begin(),
                   [axis](const Eigen::Vector3d& p) { return p[axis]; });
    const auto value_at = [&](std::ptrdiff_t rank) {
      std::nth_element(along.begin(), along.begin() + rank, along.end());
      return along[static_cast<std::size_t>(rank)];
    };
    const double low = value_at(n / 100), high = value_at(n - 1 - n / 100);
    const double slack = 0.1 * (high - low);
    box.low[axis] = low - slack;
    box.high[axis] = high + slack;
  }
  return box;
}

/// Rounded to a ten-thousandth of the distance, so that the scene file can be read.
double rounded(double value, double distance) {
  const double unit = std::pow(10.0, std::abs(std::floor(std::log10(distance)) - 4.0));
  const double result = distance < 1e4 ? std::round(value * unit) / unit : std::round(value / unit) * unit;
  return std::isfinite(result) ? result + 0.0 : value;
}

}  // namespace

Result<Framing> frame_points(const std::vector<Eigen::Vector3d>& points, double reach, const Front& front,
                             double tan_x, double tan_y) {
  constexpr double filled = 0.9, radians = std::numbers::pi / 180.0;
  tan_x *= filled;
  tan_y *= filled;
  const double above = front.above_degrees * radians, aside = front.aside_degrees * radians;
  const Eigen::Vector3d right = front.forward.cross(front.up);
  const Eigen::Vector3d back =
      (std::cos(aside) * -front.forward + std::sin(aside) * right) * std::cos(above) +
      std::sin(above) * front.up;
  const Eigen::Vector3d x_axis = front.up.cross(back).normalized(), y_axis = back.cross(x_axis);

  const Box bulk = bulk_of(points);
  std::vector<Eigen::Vector3d> near;
  for (const Eigen::Vector3d& p : points)
    if ((p.array() >= bulk.low.array()).all() && (p.array() <= bulk.high.array()).all()) near.push_back(p);
  // One that is far on one axis and another on the next may leave nothing between them.
  if (near.empty()) near = points;
  Framing framing;
  framing.far = points.size() - near.size();
  framing.back = back.unaryExpr([](double v) { return std::round(v * 1e3) / 1e3 + 0.0; });

  Eigen::Vector3d low = near.front(), high = near.front();
  for (const Eigen::Vector3d& p : near) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double size = (high - low).norm();
  Eigen::Vector3d target = low + 0.5 * (high - low);
  if (!std::isfinite(size) || !(size < 1e100)) return Error{"", "", "its points are too far apart to frame"};
  if (!(reach > 0.0) && size == 0.0) reach = 1.0;
  // Points nearer than this would fill the picture, or lie behind the eye.
  const double least = 0.05 * size + 1.5 * reach;
  double distance = 0.0;
  // Each round centres what the last one saw.
  for (int round = 0; round < 12; ++round) {
    distance = 0.0;
    for (const Eigen::Vector3d& p : near) {
      const Eigen::Vector3d q = p - target;
      const double toward = q.dot(back), x = std::abs(q.dot(x_axis)) + reach,
                   y = std::abs(q.dot(y_axis)) + reach;
      distance = std::max(distance, toward + std::max({x / tan_x, y / tan_y, least}));
    }
    if (round == 11) break;
    Eigen::Vector2d first = Eigen::Vector2d::Constant(HUGE_VAL), last = -first;
    for (const Eigen::Vector3d& p : near) {
      const Eigen::Vector3d q = p - target;
      const double depth = distance - q.dot(back);
      const Eigen::Vector2d seen(q.dot(x_axis) / depth, q.dot(y_axis) / depth);
      const Eigen::Vector2d disc = Eigen::Vector2d::Constant(reach / depth);
      first = first.cwiseMin(seen - disc);
      last = last.cwiseMax(seen + disc);
    }
    const Eigen::Vector2d middle = 0.5 * distance * (first + last);
    target += middle.x() * x_axis + middle.y() * y_axis;
  }
  const Eigen::Vector3d eye = target + distance * back;
  if (!(distance > 1e-100) || !eye.allFinite())
    return Error{"", "", "its points are too near each other or too far away to frame"};
  for (int axis = 0; axis < 3; ++axis) {
    framing.target[axis] = rounded(target[axis], distance);
    framing.eye[axis] = rounded(eye[axis], distance);
  }
  framing.distance = distance;
  return framing;
}

}  // namespace swept::io
