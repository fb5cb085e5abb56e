#include "abuffer/stochastic/moving_triangle.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "splat/motion/look.h"

namespace swept::stochastic {
namespace {

/// Times come out a little wide, for the rounding of what they are computed from; as shares of a piece.
constexpr double time_margin = 1e-7;
/// Of the products that edge functions and planes are sums of; rounding leaves 10⁻¹⁵ or so.
constexpr double value_margin = 1e-12;

/// d · (a × b), which is −d · (b × a) to the bit.
double volume(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double x, double y,
              Eigen::Vector3d& normal) {
  normal = a.cross(b);
  return (normal.x() * x + normal.y() * y) + normal.z();
}

/// Of a place on an edge that two triangles share one has it.
bool owns(const Eigen::Vector3d& inward) {
  return inward.x() > 0.0 ||
         (inward.x() == 0.0 && (inward.y() > 0.0 || (inward.y() == 0.0 && inward.z() > 0.0)));
}

}  // namespace

MovingTriangle::MovingTriangle(const MeshPaths& paths, std::uint32_t triangle, const FilmView& view)
    : paths_(paths),
      view_(view),
      per_focal_(1.0 / view.projection.focal_px),
      degree_(paths.degree()),
      triangle_(triangle),
      opaque_(paths.opaque_looks()) {
  const Object& object = paths.object();
  for (std::size_t i = 0; i < 3; ++i) {
    corner_[i] = object.triangles[triangle][i];
    opaque_ = opaque_ && (!object.cloud.looks.empty() || object.cloud.opacity.empty() ||
                          object.cloud.opacity[corner_[i]] >= 1.0f);
  }
}

PixelRange MovingTriangle::pixels(const Span& time, const PixelRange& window) const {
  PixelRange range{};
  for (int p = paths_.piece_of(time.begin); p < paths_.pieces() && (paths_.cut(p) <= time.end); ++p) {
    HullBounds hull(view_);
    const double begin = paths_.cut(p), width = paths_.cut(p + 1) - begin;
    const double a = std::clamp((time.begin - begin) / width, 0.0, 1.0),
                 b = std::clamp((time.end - begin) / width, 0.0, 1.0);
    for (const std::uint32_t corner : corner_) {
      const Eigen::Vector3d* const c = paths_.controls(corner, p);
      // The blossom at (a, a), (a, b), (b, b).
      const auto blossom = [&](double s, double t) -> Eigen::Vector3d {
        return (1 - s) * ((1 - t) * c[0] + t * c[1]) + s * ((1 - t) * c[1] + t * c[2]);
      };
      hull.include(blossom(a, a));
      if (degree_ == 2) hull.include(blossom(a, b));
      hull.include(blossom(b, b));
    }
    range = join(range, hull.pixels(window, 0.0));
  }
  return range;
}

void MovingTriangle::begin_tiles(int p, const PixelRange& range, int tile_px, CurveBounds bounds) {
  bounds_ = bounds;
  time_ = piece(p);
  half_ = (0.5 * tile_px + 1e-3) * per_focal_;
  const LensReach& lens = view_.lens;
  const double reach[2] = {lens.x * lens.most_inverse_focus, lens.y * lens.most_inverse_focus};
  const double first[2] = {(range.x0 - view_.projection.center_x) * per_focal_,
                           (range.y0 - view_.projection.center_y) * per_focal_},
               last[2] = {(range.x1 - view_.projection.center_x) * per_focal_,
                          (range.y1 - view_.projection.center_y) * per_focal_};
  const int controls = degree_ + 1, step = degree_ == 2 ? 1 : 2;
  for (int axis = 0; axis < 2; ++axis) {
    // Tiles reach beyond the range by up to their width.
    tangent_low_[axis] = first[axis] - reach[axis] - 2.0 * half_;
    tangent_high_[axis] = last[axis] + reach[axis] + 2.0 * half_;
    for (int side = 0; side < 2; ++side)
      for (const bool high : {false, true}) {
        const double gamma = high ? tangent_high_[axis] : tangent_low_[axis];
        double* const least = high ? side_[axis][side].high : side_[axis][side].low;
        for (std::size_t i = 0; i < 3; ++i) {
          const Eigen::Vector3d* const c = paths_.controls(corner_[i], p);
          double distance[3], value[3];
          for (int k = 0; k < controls; ++k) {
            const Eigen::Vector3d v = view_.seen(c[k * step]);
            const double beyond = v[axis] - gamma * v.z();
            distance[k] =
                (side == 1 ? beyond : -beyond) - value_margin * (std::abs(v[axis]) + std::abs(gamma * v.z()));
          }
          if (bounds == CurveBounds::slefes)
            slefe_below(distance, degree_, value);
          else
            std::copy(distance, distance + controls, value);
          for (int k = 0; k < controls; ++k) least[k] = i == 0 ? value[k] : std::min(least[k], value[k]);
        }
      }
  }
  begin_edges(p, tile_px);
}

void MovingTriangle::begin_edges(int p, int tile_px) {
  static_cast<void>(tile_px);
  const int degree = 2 * degree_, step = degree_ == 2 ? 1 : 2;
  const double binomial[2][3] = {{1, 1, 0}, {1, 2, 1}};
  const double inverse[2][5] = {{1, 1.0 / 2, 1, 0, 0}, {1, 1.0 / 4, 1.0 / 6, 1.0 / 4, 1}};
  const double* const n = binomial[degree_ - 1];
  const double* const scale = inverse[degree_ - 1];
  const double farthest = 1.0 + std::max(std::abs(tangent_low_[0]), std::abs(tangent_high_[0])) +
                          std::max(std::abs(tangent_low_[1]), std::abs(tangent_high_[1]));
  double largest = 0.0;
  for (const std::uint32_t corner : corner_)
    for (int k = 0; k < 3; ++k)
      largest = std::max(largest, paths_.controls(corner, p)[k].cwiseAbs().maxCoeff());
  const double from = view_.lens.x + view_.lens.y;
  const double rounding = value_margin * 6.0 * (largest + from) * (largest + from) * farthest;
  for (std::size_t e = 0; e < 3; ++e) {
    const Eigen::Vector3d* const a = paths_.controls(corner_[(e + 1) % 3], p);
    const Eigen::Vector3d* const b = paths_.controls(corner_[(e + 2) % 3], p);
    Edge& edge = edge_[e];
    for (int k = 0; k <= degree; ++k) edge.normal[k].setZero(), edge.along[k].setZero();
    for (int i = 0; i <= degree_; ++i)
      for (int j = 0; j <= degree_; ++j) {
        const double share = n[i] * n[j] * scale[i + j];
        edge.normal[i + j] += share * view_.seen(a[i * step]).cross(view_.seen(b[j * step]));
        if (view_.lens.any()) edge.along[i + j] += share * (a[i * step] - b[j * step]);
      }
    for (int k = 0; k <= degree; ++k)
      edge.pad[k] = (std::abs(edge.normal[k].x()) + std::abs(edge.normal[k].y())) * half_ + rounding;
  }
}

/// The time in which corners may be within the tile's side.
Span MovingTriangle::plane(int axis, int side, double tangent) const {
  const Side& of = side_[axis][side];
  const int controls = degree_ + 1;
  const auto within = [&](double gamma, double further) {
    const double t = (gamma - tangent_low_[axis]) / (tangent_high_[axis] - tangent_low_[axis]);
    double value[3];
    for (int k = 0; k < controls; ++k) value[k] = (1.0 - t) * of.low[k] + t * of.high[k] - further;
    if (bounds_ == CurveBounds::hulls) return where_not_above(below(value, degree_, bounds_));
    Polyline line;
    line.count = controls;
    for (int k = 0; k < controls; ++k) line.t[k] = static_cast<double>(k) / degree_, line.v[k] = value[k];
    return where_not_above(line);
  };
  return view_.inside(axis, side, tangent, within);
}

/// The time in which no edge has all of the tile outside, about the place (x, y).
Span MovingTriangle::edges(double x, double y) const {
  const int degree = 2 * degree_;
  const bool mirrored = paths_.mirrored(), both = paths_.object().two_sided;
  Span front, back;
  const LensReach& lens = view_.lens;
  for (const Edge& edge : edge_) {
    double up[most_degree + 1], down[most_degree + 1];
    for (int k = 0; k <= degree; ++k) {
      const Eigen::Vector3d &n = edge.normal[k], &w = edge.along[k];
      const double middle = n.x() * x + n.y() * y + n.z();
      double pad = edge.pad[k];
      if (lens.any()) {
        // e = (x, y, 1)·n + o·g, g = ((p − q) × (x, y, 1))_xy − n_xy/F.
        const double gx = w.y() - w.z() * y, gy = w.z() * x - w.x(), wide = std::abs(w.z()) * half_;
        const auto most = [&](double g, double of) {
          return std::max(std::abs(g - of * lens.least_inverse_focus),
                          std::abs(g - of * lens.most_inverse_focus));
        };
        pad += lens.x * (most(gx, n.x()) + wide) + lens.y * (most(gy, n.y()) + wide);
      }
      up[k] = middle - pad;
      down[k] = -middle - pad;
    }
    // A front is seen where all three are negative, as volumes from the eye; mirrored, where they are
    // positive.
    if (both || !mirrored)
      if (!front.empty()) front = meet(front, where_not_above(below(up, degree, bounds_)));
    if (both || mirrored)
      if (!back.empty()) back = meet(back, where_not_above(below(down, degree, bounds_)));
  }
  if (both) return join(front, back);
  return mirrored ? back : front;
}

Span MovingTriangle::tile(int x, int y) const {
  const double tile = 2.0 * (half_ - 1e-3 * per_focal_), left = (x - view_.projection.center_x) * per_focal_,
               top = (y - view_.projection.center_y) * per_focal_;
  const double margin = 1e-3 * per_focal_;
  Span span = meet(plane(0, 0, left - margin), plane(0, 1, left + tile + margin));
  if (span.empty()) return span;
  span = meet(span, meet(plane(1, 0, top - margin), plane(1, 1, top + tile + margin)));
  if (span.empty()) return span;
  span = meet(span, edges(left + 0.5 * tile, top + 0.5 * tile));
  if (span.empty()) return span;
  const double width = time_.end - time_.begin;
  return {time_.begin + width * (span.begin - time_margin), time_.begin + width * (span.end + time_margin)};
}

void MovingTriangle::place(float time) {
  placed_ = time;
  const int p = paths_.piece_of(double{time});
  const MeshPaths::Weights weights = paths_.weights(p, double{time});
  for (std::size_t i = 0; i < 3; ++i) at_[i] = paths_.at(corner_[i], p, weights);
}

void MovingTriangle::add_light(const Eigen::Vector3d& shares, double (&rgba)[4]) const {
  const Object& object = paths_.object();
  const SurfelCloud& cloud = object.cloud;
  std::optional<LooksAt> looks;
  if (!cloud.looks.empty()) looks.emplace(cloud, paths_.frame(double{placed_}));
  for (std::size_t i = 0; i < 3; ++i) {
    const double share = shares[static_cast<Eigen::Index>(i)];
    if (looks) {
      const Eigen::Vector4f light = (*looks)[corner_[i]];
      for (int c = 0; c < 4; ++c) rgba[c] += share * double{light[c]};
      continue;
    }
    const double opacity = cloud.opacity.empty() ? 1.0 : double{cloud.opacity[corner_[i]]};
    for (int c = 0; c < 3; ++c)
      rgba[c] += share * opacity * (cloud.color.empty() ? 1.0 : double{cloud.color[corner_[i]][c]});
    rgba[3] += share * opacity;
  }
  const Eigen::Vector4f tint = object.tint_of(triangle_);
  for (int c = 0; c < 4; ++c) rgba[c] *= double{tint[c]};
  const Texture* const texture = object.texture_of(triangle_);
  if (texture == nullptr) return;
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    uv += shares[static_cast<Eigen::Index>(i)] * object.texture_corners[triangle_][i].cast<double>();
  const Eigen::Vector4f texel = texture->at(static_cast<float>(uv.x()), static_cast<float>(uv.y()));
  for (int c = 0; c < 4; ++c) rgba[c] *= double{texel[c]};
}

bool MovingTriangle::test_placed(const BlockSamples& samples, std::size_t k, int x, int y,
                                 SampleHits& hits) const {
  const SampleRay ray = ray_of(samples, k, x, y, view_.projection, per_focal_);
  Eigen::Vector3d from[3];
  for (std::size_t i = 0; i < 3; ++i)
    from[i] = view_.seen({at_[i].x() - ray.from_x, at_[i].y() - ray.from_y, at_[i].z()});
  Eigen::Vector3d normal[3];
  double value[3];
  int positive = 0, negative = 0;
  for (std::size_t e = 0; e < 3; ++e) {
    const std::size_t a = (e + 1) % 3, b = (e + 2) % 3;
    // One order for both triangles at an edge, so that they agree to the bit on which side of it the ray is.
    if (corner_[a] < corner_[b]) {
      value[e] = volume(from[a], from[b], ray.x, ray.y, normal[e]);
    } else {
      value[e] = -volume(from[b], from[a], ray.x, ray.y, normal[e]);
      normal[e] = -normal[e];
    }
    positive += value[e] > 0.0, negative += value[e] < 0.0;
    if (positive > 0 && negative > 0) return false;
  }
  const double sum = value[0] + value[1] + value[2];
  if (sum == 0.0 || !std::isfinite(sum)) return false;
  const double side = sum > 0.0 ? 1.0 : -1.0;
  for (std::size_t e = 0; e < 3; ++e)
    if (value[e] == 0.0 && !owns(side * normal[e])) return false;
  const double z = (value[0] * at_[0].z() + value[1] * at_[1].z() + value[2] * at_[2].z()) / sum;
  if (!(z >= view_.near)) return false;
  if (!paths_.object().two_sided && (sum < 0.0) == paths_.mirrored()) return false;
  if (opaque_ && z > hits.nearest(k)) return true;
  LayerHit hit{static_cast<std::uint32_t>(k), z, {0.0f, 0.0f, 0.0f, 0.0f}};
  double rgba[4] = {0.0, 0.0, 0.0, 0.0};
  add_light({value[0] / sum, value[1] / sum, value[2] / sum}, rgba);
  for (int c = 0; c < 4; ++c) hit.rgba[c] = static_cast<float>(rgba[c]);
  hits.add(hit, opaque_);
  return true;
}

}  // namespace swept::stochastic
