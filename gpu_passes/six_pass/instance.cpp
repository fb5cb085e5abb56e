#include "gpu_passes/six_pass/instance.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace swept {
namespace {

using Eigen::Vector3d;

/// How far from the window an anchor may lie, px: whole pixels up to 2²⁴ are floats.
constexpr double anchor_reach = 4096.0;

struct Anchor {
  double x, y;         ///< px on the film
  bool at_the_center;  ///< the kernel's projected centre, where (u, v) vanish
};

Anchor anchor_of(const Vector3d& center, const Projection& p, const PixelWindow& window) {
  const double x_min = window.x - anchor_reach, x_max = window.x + window.width + anchor_reach;
  const double y_min = window.y - anchor_reach, y_max = window.y + window.height + anchor_reach;
  if (!(center.z() > 0.0)) return {window.x + 0.5 * window.width, window.y + 0.5 * window.height, false};
  const double x = p.center_x + p.focal_px * center.x() / center.z();
  const double y = p.center_y + p.focal_px * center.y() / center.z();
  const bool inside = x >= x_min && x <= x_max && y >= y_min && y <= y_max;
  return {std::clamp(x, x_min, x_max), std::clamp(y, y_min, y_max), inside};
}

/// `box` in px from the window's corner.
glm::vec4 relative(const PixelBox& box, const PixelWindow& window, double padding) {
  return {
      static_cast<float>(box.x_min - window.x - padding), static_cast<float>(box.y_min - window.y - padding),
      static_cast<float>(box.x_max - window.x + padding), static_cast<float>(box.y_max - window.y + padding)};
}

/// Rasterisers snap vertices to 1/16 px or finer, and coordinates are floats: 2⁻²³ relative after the two
/// roundings on the way to clip space.
constexpr double snap_px = 0.125;
constexpr double float_relative = 0x1p-22;
/// Beyond this distance from the window a box of both ends, cut to the window, replaces the octagon.
constexpr double far_px = 65536.0;

}  // namespace

Instance make_instance(const MovingKernel& kernel, const Octagon& octagon, const Projection& projection,
                       const PixelWindow& window) {
  // As KernelPlane: a common factor of the axes cancels; scaling it to 1 keeps tiny and huge discs in range.
  const Vector3d c = kernel.center, m = kernel.velocity;
  Vector3d a = kernel.axis_u.cast<double>(), b = kernel.axis_v.cast<double>();
  const double scale = 1.0 / std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
  a *= scale;
  b *= scale;
  const Vector3d normal = a.cross(b);

  const Anchor anchor = anchor_of(c, projection, window);
  const double per_px = 1.0 / projection.focal_px;
  const Vector3d ray((anchor.x - projection.center_x) * per_px, (anchor.y - projection.center_y) * per_px,
                     1.0);
  const auto affine = [&](const Vector3d& n) { return Vector3d(n.dot(ray), n.x() * per_px, n.y() * per_px); };
  Vector3d plane = affine(normal);
  // All coefficients may be divided by one number; this one makes those of the plane 1 at most.
  const double unit = 1.0 / plane.cwiseAbs().maxCoeff();
  const auto pack = [&](Vector3d coefficients, double w) {
    coefficients *= unit;
    return glm::vec4(static_cast<float>(coefficients.x()), static_cast<float>(coefficients.y()),
                     static_cast<float>(coefficients.z()), static_cast<float>(w));
  };

  Vector3d line_u = affine(b.cross(c) * scale), line_v = affine(c.cross(a) * scale);
  if (anchor.at_the_center) line_u.x() = line_v.x() = 0.0;
  const Vector3d facing = affine(kernel.facing.cast<double>());
  const double pixel_x = std::floor(anchor.x), pixel_y = std::floor(anchor.y);

  Instance instance;
  instance.plane = pack(plane, normal.dot(c) * unit);
  instance.line_u = pack(line_u, normal.dot(m) * unit);
  instance.line_v = pack(line_v, kernel.weight);
  instance.rate_u = pack(affine(b.cross(m) * scale), kernel.depth_tolerance);
  instance.rate_v = pack(affine(m.cross(a) * scale), 0.0);
  instance.facing = {static_cast<float>(facing.x()), static_cast<float>(facing.y()),
                     static_cast<float>(facing.z()), kernel.facing.isZero(0.0f) ? 0.0f : 1.0f};
  instance.color = {kernel.color[0], kernel.color[1], kernel.color[2], kernel.color[3]};
  instance.anchor = {static_cast<float>(pixel_x), static_cast<float>(pixel_y),
                     static_cast<float>(anchor.x - (pixel_x + 0.5)),
                     static_cast<float>(anchor.y - (pixel_y + 0.5))};

  const PixelBox all = octagon.box();
  const double distance = std::max({std::abs(all.x_min - window.x), std::abs(all.x_max - window.x),
                                    std::abs(all.y_min - window.y), std::abs(all.y_max - window.y)});
  if (distance <= far_px) {
    const double padding = snap_px + float_relative * distance;
    instance.box_open = relative(octagon.begin, window, padding);
    instance.box_close = relative(octagon.end, window, padding);
  } else {
    const double x = window.x, y = window.y;
    const PixelBox cut{std::clamp(all.x_min, x, x + window.width), std::clamp(all.x_max, x, x + window.width),
                       std::clamp(all.y_min, y, y + window.height),
                       std::clamp(all.y_max, y, y + window.height)};
    instance.box_open = instance.box_close = relative(cut, window, snap_px);
  }
  return instance;
}

std::vector<Instance> make_instances(const KernelSet& set, const PixelWindow& window) {
  const PixelBox centers{window.x + 0.5, window.x + window.width - 0.5, window.y + 0.5,
                         window.y + window.height - 0.5};
  std::vector<Instance> instances;
  instances.reserve(set.kernels.size());
  Octagon octagon;
  for (const MovingKernel& kernel : set.kernels)
    if (screen_bounds(kernel, set.projection, set.near, octagon) && octagon.overlaps(centers))
      instances.push_back(make_instance(kernel, octagon, set.projection, window));
  return instances;
}

}  // namespace swept
