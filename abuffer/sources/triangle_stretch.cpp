#include "abuffer/sources/triangle_stretch.h"

#include <algorithm>
#include <cmath>

#include "splat/motion/look.h"

namespace swept {
namespace {

Bernstein sum(const Bernstein& a, const Bernstein& b, const Bernstein& c) {
  Bernstein s = a;
  for (std::size_t k = 0; k <= static_cast<std::size_t>(a.degree); ++k) s.c[k] += b.c[k] + c.c[k];
  return s;
}

/// 1 or −1 where all coefficients are on that side of 0 by `margin(k)` or more, else 0.
template <class Margin>
int one_side(const Bernstein& e, const Margin& margin) {
  bool above = true, below = true;
  for (std::size_t k = 0; k <= static_cast<std::size_t>(e.degree); ++k) {
    const double m = margin(k);
    above = above && e.c[k] > m;
    below = below && e.c[k] < -m;
  }
  return above ? 1 : below ? -1 : 0;
}

}  // namespace

TriangleStretch::TriangleStretch(const MovingMesh& of, std::uint32_t mesh_index, std::size_t stretch,
                                 std::size_t t, double near)
    : mesh(mesh_index),
      triangle(static_cast<std::uint32_t>(t)),
      begin(of.time(stretch)),
      end(of.time(stretch + 1)),
      degree_(of.degree()),
      near_(near) {
  const Object& object = of.object();
  PathPoints path[3];
  nearest_ = INFINITY, farthest_ = -INFINITY;
  cut_ = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t point = object.triangles[t][i];
    const Eigen::Vector3d* controls = of.path(stretch, point);
    z_[i].degree = degree_;
    for (std::size_t k = 0; k <= static_cast<std::size_t>(degree_); ++k) {
      path[i][k] = controls[k];
      z_[i].c[k] = controls[k].z();
      nearest_ = std::min(nearest_, controls[k].z());
      farthest_ = std::max(farthest_, controls[k].z());
      cut_ = cut_ || !(controls[k].z() >= near);
    }
    const Eigen::Vector4f first = LooksAt(object.cloud, of.frame(stretch))[point],
                          last = LooksAt(object.cloud, of.frame(stretch + 1))[point];
    for (int c = 0; c < 4; ++c) rgba[i][c] = first[c], more[i][c] = last[c] - first[c];
  }
  nearest_ = std::max(nearest_, near);
  plain = opaque = true;
  for (std::size_t i = 0; i < 3; ++i) {
    plain = plain && std::equal(rgba[i], rgba[i] + 4, rgba[0]);
    for (const float change : more[i]) plain = plain && change == 0.0f;
    opaque = opaque && rgba[i][3] >= 1.0f && rgba[i][3] + more[i][3] >= 1.0f;
  }
  if (object.texture) {
    texture = object.texture.get();
    for (std::size_t i = 0; i < 3; ++i)
      uv[i][0] = object.texture_corners[t][i].x(), uv[i][1] = object.texture_corners[t][i].y();
    plain = false;
    opaque = opaque && of.opaque_texture();
  }
  for (std::size_t i = 0; i < 3; ++i) edge_[i] = EdgeFunction(path[(i + 1) % 3], path[(i + 2) % 3], degree_);
  // Counter-clockwise from the front: all edge functions are below 0 there.
  shows_above_ = object.two_sided || of.mirrored(stretch);
  shows_below_ = object.two_sided || !of.mirrored(stretch);
}

bool TriangleStretch::misses(const Eigen::Vector3d& ray, double half_x, double half_y) const {
  bool above = false, below = false;
  for (const EdgeFunction& edge : edge_) {
    const int side = one_side(edge.at(ray), [&](std::size_t k) { return edge.variation(k, half_x, half_y); });
    above = above || side > 0;
    below = below || side < 0;
  }
  return (above || !shows_below_) && (below || !shows_above_);
}

DepthOverTime TriangleStretch::depth(const Eigen::Vector3d& ray) const {
  const Bernstein e[3] = {edge_[0].at(ray), edge_[1].at(ray), edge_[2].at(ray)};
  return {sum(product(e[0], z_[0]), product(e[1], z_[1]), product(e[2], z_[2])), sum(e[0], e[1], e[2])};
}

void TriangleStretch::add(const DepthOverTime& depth, double from, double to, double first, double last,
                          std::uint32_t place, std::uint32_t source, std::vector<PlaceInterval>& out) const {
  double low = nearest_, high = farthest_;
  // A quotient lies within those of its coefficients where the divisors have one sign.
  const Bernstein below = depth.below.part(first, last).raised(depth.above.degree),
                  above = depth.above.part(first, last);
  if (one_side(below, [](std::size_t) { return 0.0; }) != 0) {
    double least = INFINITY, most = -INFINITY;
    for (std::size_t k = 0; k <= static_cast<std::size_t>(above.degree); ++k) {
      const double z = above.c[k] / below.c[k];
      least = std::min(least, z);
      most = std::max(most, z);
    }
    // Their rounding, and a float's.
    const double slack = 1e-6 * std::max(std::abs(least), std::abs(most));
    low = std::max(low, least - slack);
    high = std::min(high, most + slack);
  }
  out.push_back({place, source, from, to, static_cast<float>(low - 1e-6 * std::abs(low)),
                 static_cast<float>(high + 1e-6 * std::abs(high))});
}

void TriangleStretch::meet(const Eigen::Vector3d& ray, double from, double to, std::uint32_t place,
                           std::uint32_t source, std::vector<PlaceInterval>& out) const {
  from = std::max(from, begin);
  to = std::min(to, end);
  if (!(from < to) || misses(ray, 0.0, 0.0)) return;
  const SignChanges sides[3] = {edge_[0].sides(ray), edge_[1].sides(ray), edge_[2].sides(ray)};
  DepthOverTime depth;
  bool known = false;
  int at[3] = {0, 0, 0};
  double first = 0.0;
  const auto time = [&](double t) {
    return t <= 0.0 ? begin : t >= 1.0 ? end : std::clamp(begin + t * (end - begin), begin, end);
  };
  const auto keep = [&](double a, double b) {
    const double time_a = std::max(from, time(a)), time_b = std::min(to, time(b));
    if (!(time_a < time_b)) return;
    const double low = std::clamp(local(time_a), 0.0, 1.0), high = std::clamp(local(time_b), low, 1.0);
    add(depth, time_a, time_b, low, high, place, source, out);
  };
  while (first < 1.0) {
    double last = 1.0;
    for (int i = 0; i < 3; ++i)
      if (at[i] < sides[i].count) last = std::min(last, sides[i].at[static_cast<std::size_t>(at[i])]);
    const int side = sides[0].sign(at[0]);
    if (first < last && side != 0 && side == sides[1].sign(at[1]) && side == sides[2].sign(at[2]) &&
        (side > 0 ? shows_above_ : shows_below_)) {
      if (!known) depth = this->depth(ray), known = true;
      if (!cut_) {
        keep(first, last);
      } else {
        // In front of the near plane Σe·z − near·Σe has the sign of Σe.
        Bernstein nearer = depth.below.raised(depth.above.degree);
        for (std::size_t k = 0; k <= static_cast<std::size_t>(nearer.degree); ++k)
          nearer.c[k] = side * (depth.above.c[k] - near_ * nearer.c[k]);
        const SignChanges in_front = sign_changes(nearer.part(first, last));
        double begins = first;
        for (int k = 0; k <= in_front.count; ++k) {
          const double ends =
              k < in_front.count ? first + (last - first) * in_front.at[static_cast<std::size_t>(k)] : last;
          if (in_front.sign(k) > 0) keep(begins, ends);
          begins = ends;
        }
      }
    }
    for (int i = 0; i < 3; ++i)
      while (at[i] < sides[i].count && sides[i].at[static_cast<std::size_t>(at[i])] <= last) ++at[i];
    if (last >= 1.0) break;
    first = last;
  }
}

TriangleStretch::OnTexture TriangleStretch::on_texture(const Eigen::Vector3d& ray, double time) const {
  const double t = std::clamp(local(time), 0.0, 1.0);
  double weight = 0.0, at[2] = {0.0, 0.0};
  for (std::size_t i = 0; i < 3; ++i) {
    const double e = edge_[i].at(ray).at(t);
    weight += e;
    for (int c = 0; c < 2; ++c) at[c] += e * double{uv[i][c]};
  }
  if (weight == 0.0) return {0.0, 0.0};
  return {at[0] / weight * texture->width - 0.5, (1.0 - at[1] / weight) * texture->height - 0.5};
}

TriangleStretch::Look TriangleStretch::look(const Eigen::Vector3d& ray, double time) const {
  const double t = std::clamp(local(time), 0.0, 1.0);
  double e[3], all = 0.0;
  for (int i = 0; i < 3; ++i) all += e[i] = edge_[i].at(ray).at(t);
  // What rounding puts outside lies on the edge.
  const double side = all < 0.0 ? -1.0 : 1.0;
  double weight = 0.0;
  for (double& v : e) weight += v = std::max(0.0, side * v);
  Look seen{nearest_, {rgba[0][0], rgba[0][1], rgba[0][2], rgba[0][3]}};
  if (!(weight > 0.0)) return seen;
  double z = 0.0;
  for (int i = 0; i < 3; ++i) z += e[i] * z_[i].at(t);
  seen.depth = z / weight;
  if (plain) return seen;
  for (int c = 0; c < 4; ++c) {
    seen.rgba[c] = 0.0;
    for (int i = 0; i < 3; ++i) seen.rgba[c] += e[i] / weight * (double{rgba[i][c]} + t * double{more[i][c]});
  }
  if (texture != nullptr) {
    double at[2] = {0.0, 0.0};
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 2; ++c) at[c] += e[i] / weight * double{uv[i][c]};
    const Eigen::Vector4f texel = texture->at(at[0], at[1]);
    for (int c = 0; c < 4; ++c) seen.rgba[c] *= double{texel[c]};
  }
  return seen;
}

}  // namespace swept
