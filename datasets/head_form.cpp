#include "datasets/head_form.h"

#include <cmath>

#include "datasets/paint.h"

namespace swept::datasets {
namespace {

// A bump over the face at (cx, cy), seen from the front; x is taken on both sides alike.
double bump(const Eigen::Vector3d& d, double cx, double cy, double wide, double high) {
  const double x = (std::abs(d.x()) - cx) / wide, y = (d.y() - cy) / high;
  return std::exp(-x * x - y * y) * smoothstep(0.05, 0.35, d.z());
}

double nose(const Eigen::Vector3d& d) {
  const double y = d.y();
  const double bridge = smoothstep(0.30, -0.12, y), under = smoothstep(-0.25, -0.15, y);
  const double profile = (0.04 + 0.17 * bridge) * under * smoothstep(0.36, 0.2, y);
  const double width = 0.075 + 0.07 * bridge;
  return profile * std::exp(-std::pow(d.x() / width, 2)) * smoothstep(0.1, 0.4, d.z());
}

}  // namespace

double hair_at(const Eigen::Vector3d& d) {
  // The hairline: high over the forehead, down in front of the ears, low at the back.
  const double side = smoothstep(0.55, 0.05, d.z()), back = smoothstep(0.1, -0.35, d.z());
  const double parting = 0.05 * std::cos(9.0 * d.x() + 0.6);
  const double line = 0.56 + parting - 0.42 * side * side - 0.62 * back;
  return smoothstep(line - 0.02, line + 0.05, d.y());
}

Eigen::Vector3d head_form(const Eigen::Vector3d& d) {
  const double x = d.x(), y = d.y(), z = d.z();
  const double jaw = smoothstep(0.05, -0.95, y), front = smoothstep(-0.25, 0.45, z);
  Eigen::Vector3d p(0.74 * x, 0.98 * y, 0.86 * z);
  p.x() *= 1.0 - 0.34 * jaw + 0.05 * smoothstep(0.1, 0.6, y);
  p.z() *= 1.0 - (1.0 - front) * 0.45 * jaw;
  p.z() -= 0.10 * smoothstep(0.4, 1.0, z) * (1.0 - jaw);                 // the face is flatter than the skull
  p.z() -= 0.10 * smoothstep(-0.1, -0.9, z) * smoothstep(-0.3, 0.5, y);  // the back of the head
  p.y() -= 0.10 * jaw * front;

  double out = 0.0;  // along z
  out += nose(d);
  out += 0.06 * bump(d, 0.115, -0.165, 0.06, 0.055);  // wings of the nose
  out += 0.055 * bump(d, 0.25, 0.27, 0.22, 0.08);     // brows
  out -= 0.13 * bump(d, 0.27, 0.10, 0.135, 0.095);    // eye sockets
  out += 0.05 * bump(d, 0.42, -0.14, 0.17, 0.16);     // cheekbones
  out += 0.05 * bump(d, 0.0, -0.46, 0.30, 0.20);      // the muzzle behind the lips
  out += 0.055 * bump(d, 0.05, -0.385, 0.13, 0.035);  // upper lip
  out += 0.06 * bump(d, 0.0, -0.50, 0.15, 0.045);     // lower lip
  out -= 0.03 * bump(d, 0.0, -0.44, 0.20, 0.022);     // between them
  out -= 0.04 * bump(d, 0.0, -0.60, 0.16, 0.045);     // above the chin
  out += 0.09 * bump(d, 0.0, -0.80, 0.20, 0.14);      // chin
  p.z() += out;

  const double strands = 0.012 * std::sin(46.0 * std::atan2(x, 0.35 + y)) * smoothstep(-0.25, 0.15, y);
  return p + (0.055 + strands) * hair_at(d) * d;
}

Eigen::Vector3d head_color(const Eigen::Vector3d& d, const Eigen::Vector3d& skin,
                           const Eigen::Vector3d& hair) {
  const double x = std::abs(d.x());
  Eigen::Vector3d color = skin;
  color = mix(color, Eigen::Vector3d(skin.x(), 0.45 * skin.y(), 0.4 * skin.z()),
              0.45 * bump(d, 0.45, -0.20, 0.16, 0.14));
  const bool front = d.z() > 0.0;
  const double lip_end = smoothstep(0.27, 0.2, x);
  const double upper = std::abs(d.y() + 0.395 - 0.03 * std::cos(14.0 * x)) - 0.040 * lip_end;
  const double lower =
      std::abs(d.y() + 0.495) - 0.052 * lip_end * std::sqrt(std::max(0.0, 1.0 - x * x / 0.055));
  if (front && x < 0.27) {
    if (upper < 0.0) color = mix(srgb(0xb4413f), skin, 0.15);
    if (lower < 0.0) color = mix(srgb(0xc9544f), skin, 0.15);
    if (std::abs(d.y() + 0.442 - 0.15 * x * x) < 0.012) color = srgb(0x4a1414);
  }
  const double brow = d.y() - (0.265 + 0.25 * (x - 0.12) - 0.75 * (x - 0.12) * (x - 0.12));
  if (front && x > 0.1 && x < 0.5 && std::abs(brow) < 0.035 * smoothstep(0.52, 0.3, x)) color = 0.7 * hair;
  if (front && std::hypot(x - 0.075, 1.6 * (d.y() + 0.238)) < 0.032) color = 0.12 * skin;  // nostrils
  const double strands = 0.75 + 0.35 * std::sin(46.0 * std::atan2(d.x(), 0.35 + d.y()) + 5.0 * d.z());
  return mix(color, strands * hair, smoothstep(0.3, 0.6, hair_at(d)));
}

}  // namespace swept::datasets
