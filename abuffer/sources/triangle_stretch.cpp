#include "abuffer/sources/triangle_stretch.h"

#include <algorithm>
#include <cmath>

#include "splat/interval/fixed_bernstein.h"
#include "splat/interval/only_root.h"
#include "splat/motion/look.h"

namespace swept {
namespace {

template <int n>
FixedBernstein<2 * n> edge_at(const EdgeFunction& edge, const Eigen::Vector3d& ray) {
  FixedBernstein<2 * n> e;
  for (int k = 0; k <= 2 * n; ++k) {
    const Eigen::Vector3d& normal = edge.normal(static_cast<std::size_t>(k));
    e.c[k] = normal.x() * ray.x() + (normal.y() * ray.y() + normal.z());
  }
  return e;
}

template <int degree>
FixedBernstein<degree> fixed(const Bernstein& p) {
  FixedBernstein<degree> f;
  std::copy_n(p.c.begin(), degree + 1, f.c);
  return f;
}

template <int degree>
Bernstein general(const FixedBernstein<degree>& p) {
  Bernstein b;
  b.degree = degree;
  std::copy_n(p.c, degree + 1, b.c.begin());
  return b;
}

/// The depth of a triangle at a ray, Σe·z / Σe.
template <int n>
struct DepthOf {
  FixedBernstein<3 * n> above;
  FixedBernstein<2 * n> below;

  DepthOf(const FixedBernstein<2 * n> (&e)[3], const Bernstein (&z)[3]) : above{}, below{} {
    for (int k = 0; k <= 2 * n; ++k) below.c[k] = e[0].c[k] + (e[1].c[k] + e[2].c[k]);
    for (int i = 0; i < 3; ++i) add_product(e[i], fixed<n>(z[i]), above);
  }
};

/// Where an edge's sign changes, and the sign before that.
struct Sides {
  int first = 0, count = 0;
  double at[2 * most_path_degree];

  [[nodiscard]] int sign(int k) const { return k % 2 == 0 ? first : -first; }
};

template <int n>
Sides sides_of(const FixedBernstein<2 * n>& e, const EdgeFunction& edge, const Eigen::Vector3d& ray) {
  Sides sides;
  double most = 0.0;
  for (const double v : e.c) most = std::max(most, std::abs(v));
  if (most > 1e-100 && most < 1e100) {
    sides.first = e.side();
    if (sides.first != 0) return sides;
    if constexpr (n == 1) {
      const double sign = e.c[0] != 0.0 ? e.c[0] : e.c[1] != 0.0 ? e.c[1] : e.c[2];
      sides.first = sign > 0.0 ? 1 : -1;
      // 0 at an end alone does not count as a sign, and three of one sign have no root.
      const bool above = e.c[0] >= 0.0 && e.c[1] >= 0.0 && e.c[2] >= 0.0,
                 below = e.c[0] <= 0.0 && e.c[1] <= 0.0 && e.c[2] <= 0.0;
      if (!above && !below) sides.count = quadratic_sign_changes(e.c, sides.at);
      return sides;
    } else {
      const CoefficientSigns signs = signs_of(e.c, e.size);
      const bool finite = std::all_of(e.c, e.c + e.size, [](double v) { return std::isfinite(v); });
      if (signs.changes == 1 && finite) {
        sides.first = signs.first;
        sides.count = 1;
        sides.at[0] = only_root<2 * n>(e.c, 2 * n, sides.first);
        return sides;
      }
    }
  }
  const SignChanges changes = edge.sides(ray);
  sides.first = changes.first;
  sides.count = std::min(changes.count, 2 * most_path_degree);
  std::copy_n(changes.at.begin(), sides.count, sides.at);
  return sides;
}

/// Below this share of itself a depth's range over time is taken from that of the corners.
constexpr double flat_enough = 1e-3;

}  // namespace

TriangleStretch::TriangleStretch(const MovingMesh& of, std::uint32_t mesh_index, std::size_t stretch,
                                 std::size_t t, double near, bool orthographic)
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
  const Eigen::Vector4f tint = object.tint_of(t);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t point = object.triangles[t][i];
    const Eigen::Vector3d* controls = of.path(stretch, point);
    z_[i].degree = degree_;
    for (std::size_t k = 0; k <= static_cast<std::size_t>(degree_); ++k) {
      path[i][k] = controls[k];
      // Parallel rays see of it what those from an eye do of its shadow at depth 1.
      if (orthographic) path[i][k].z() = 1.0;
      z_[i].c[k] = controls[k].z();
      nearest_ = std::min(nearest_, controls[k].z());
      farthest_ = std::max(farthest_, controls[k].z());
      cut_ = cut_ || !(controls[k].z() >= near);
    }
    const Eigen::Vector4f first = LooksAt(object.cloud, of.frame(stretch))[point].cwiseProduct(tint),
                          last = LooksAt(object.cloud, of.frame(stretch + 1))[point].cwiseProduct(tint);
    for (int c = 0; c < 4; ++c) rgba[i][c] = first[c], more[i][c] = last[c] - first[c];
  }
  nearest_ = std::max(nearest_, near);
  one_color = opaque = true;
  for (std::size_t i = 0; i < 3; ++i) {
    one_color = one_color && std::equal(rgba[i], rgba[i] + 4, rgba[0]);
    for (const float change : more[i]) one_color = one_color && change == 0.0f;
    opaque = opaque && rgba[i][3] >= 1.0f && rgba[i][3] + more[i][3] >= 1.0f;
  }
  even_alpha = true;
  for (std::size_t i = 0; i < 3; ++i)
    even_alpha = even_alpha && rgba[i][3] == rgba[0][3] && more[i][3] == 0.0f;
  texture = object.texture_of(t);
  plain = one_color && texture == nullptr;
  if (texture != nullptr) {
    even_alpha = even_alpha && of.opaque_texture(t);
    for (std::size_t i = 0; i < 3; ++i)
      uv[i][0] = object.texture_corners[t][i].x(), uv[i][1] = object.texture_corners[t][i].y();
    opaque = opaque && of.opaque_texture(t);
  }
  least_alpha = 1.0f;
  for (std::size_t i = 0; i < 3; ++i)
    least_alpha = std::min({least_alpha, rgba[i][3], rgba[i][3] + more[i][3]});
  if (texture != nullptr && !of.opaque_texture(t)) least_alpha = 0.0f;
  for (std::size_t i = 0; i < 3; ++i) edge_[i] = EdgeFunction(path[(i + 1) % 3], path[(i + 2) % 3], degree_);
  degree_ == 1 ? set_depth<1>() : degree_ == 2 ? set_depth<2>() : set_depth<3>();
  // Counter-clockwise from the front: all edge functions are below 0 there.
  shows_above_ = object.two_sided || of.mirrored(stretch);
  shows_below_ = object.two_sided || !of.mirrored(stretch);
}

/// What the rays (1, 0, 0), (0, 1, 0) and (0, 0, 1) find, of which any other is a sum.
template <int n>
void TriangleStretch::set_depth() {
  for (int axis = 0; axis < 3; ++axis) {
    FixedBernstein<2 * n> e[3];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k <= 2 * n; ++k) e[i].c[k] = edge_[i].normal(static_cast<std::size_t>(k))[axis];
    const DepthOf<n> of_axis(e, z_);
    for (int k = 0; k <= 3 * n; ++k) above_[k][axis] = of_axis.above.c[k];
    for (int k = 0; k <= 2 * n; ++k) below_[k][axis] = of_axis.below.c[k];
  }
}

template <int n>
bool TriangleStretch::misses_of(const Eigen::Vector3d& ray, double half_x, double half_y) const {
  bool above = false, below = false;
  for (const EdgeFunction& edge : edge_) {
    const FixedBernstein<2 * n> e = edge_at<n>(edge, ray);
    bool all_above = true, all_below = true;
    for (int k = 0; k <= 2 * n; ++k) {
      const double margin = edge.variation(static_cast<std::size_t>(k), half_x, half_y);
      all_above = all_above && e.c[k] > margin;
      all_below = all_below && e.c[k] < -margin;
    }
    above = above || all_above;
    below = below || all_below;
  }
  return (above || !shows_below_) && (below || !shows_above_);
}

template <int n>
std::uint32_t TriangleStretch::may_meet_of(const RaysOfPixel& rays) const {
  // As numbers of one width, which lets a compiler do several places at once.
  using Wide = std::uint64_t;
  constexpr Wide yes = ~Wide{0};
  Wide above[pixel_places] = {}, below[pixel_places] = {};
  for (const EdgeFunction& edge : edge_) {
    Wide all_above[pixel_places], all_below[pixel_places];
    std::fill(all_above, all_above + pixel_places, yes);
    std::fill(all_below, all_below + pixel_places, yes);
    for (int k = 0; k <= 2 * n; ++k) {
      const Eigen::Vector3d& normal = edge.normal(static_cast<std::size_t>(k));
      const double a = normal.x(), b = normal.y(), c = normal.z();
      for (int p = 0; p < pixel_places; ++p) {
        const double e = a * rays.x[p] + (b * rays.y[p] + c);
        all_above[p] &= e > 0.0 ? yes : 0;
        all_below[p] &= e < 0.0 ? yes : 0;
      }
    }
    for (int p = 0; p < pixel_places; ++p) above[p] |= all_above[p], below[p] |= all_below[p];
  }
  const Wide no_below = shows_below_ ? 0 : yes, no_above = shows_above_ ? 0 : yes;
  std::uint32_t may = 0;
  for (int p = 0; p < pixel_places; ++p)
    if (((above[p] | no_below) & (below[p] | no_above)) == 0) may |= 1u << p;
  return may;
}

/// From `first` to `last` of the stretch it is met: by its corners, who hold it, or by the quotient, which
/// lies within those of its coefficients where the divisors have one sign.
template <int n>
void TriangleStretch::keep_of(const Eigen::Vector3d& ray, double from, double to, double first, double last,
                              std::uint32_t place, std::uint32_t source,
                              std::vector<PlaceInterval>& out) const {
  const auto time = [&](double t) {
    return t <= 0.0 ? begin : t >= 1.0 ? end : std::clamp(begin + t * (end - begin), begin, end);
  };
  const double time_a = std::max(from, time(first)), time_b = std::min(to, time(last));
  if (!(time_a < time_b)) return;
  const double a = std::clamp(local(time_a), 0.0, 1.0), b = std::clamp(local(time_b), a, 1.0);
  double low = INFINITY, high = -INFINITY;
  for (const Bernstein& corner : z_)
    for (const double z : fixed<n>(corner).part(a, b).c) low = std::min(low, z), high = std::max(high, z);
  low = std::max(low - 1e-12 * std::abs(low), nearest_);
  high = std::min(high + 1e-12 * std::abs(high), farthest_);
  // Layers that are peeled off find closer bounds by themselves.
  if (high - low > flat_enough * low && opaque) {
    const FixedBernstein<2 * n> e[3] = {edge_at<n>(edge_[0], ray), edge_at<n>(edge_[1], ray),
                                        edge_at<n>(edge_[2], ray)};
    const DepthOf<n> depth(e, z_);
    const FixedBernstein<2 * n> divisors = depth.below.part(a, b);
    if (divisors.side() != 0) {
      const FixedBernstein<3 *n> over = depth.above.part(a, b), under = raised_to<3 * n>(divisors);
      double least = INFINITY, most = -INFINITY;
      for (int k = 0; k <= 3 * n; ++k) {
        const double z = over.c[k] / under.c[k];
        least = std::min(least, z);
        most = std::max(most, z);
      }
      // Their rounding, and a float's.
      const double slack = 1e-6 * std::max(std::abs(least), std::abs(most));
      low = std::max(low, least - slack);
      high = std::min(high, most + slack);
    }
  }
  out.push_back({place, source, time_a, time_b, static_cast<float>(low - 1e-6 * std::abs(low)),
                 static_cast<float>(high + 1e-6 * std::abs(high))});
}

template <int n>
void TriangleStretch::meet_of(const Eigen::Vector3d& ray, double from, double to, std::uint32_t place,
                              std::uint32_t source, std::vector<PlaceInterval>& out) const {
  from = std::max(from, begin);
  to = std::min(to, end);
  if (!(from < to)) return;
  const FixedBernstein<2 * n> e[3] = {edge_at<n>(edge_[0], ray), edge_at<n>(edge_[1], ray),
                                      edge_at<n>(edge_[2], ray)};
  const int whole[3] = {e[0].side(), e[1].side(), e[2].side()};
  const bool above = whole[0] > 0 || whole[1] > 0 || whole[2] > 0,
             below = whole[0] < 0 || whole[1] < 0 || whole[2] < 0;
  if ((above || !shows_below_) && (below || !shows_above_)) return;
  const Sides sides[3] = {sides_of<n>(e[0], edge_[0], ray), sides_of<n>(e[1], edge_[1], ray),
                          sides_of<n>(e[2], edge_[2], ray)};
  const auto keep = [&](double a, double b) { keep_of<n>(ray, from, to, a, b, place, source, out); };
  int at[3] = {0, 0, 0};
  double first = 0.0;
  while (first < 1.0) {
    double last = 1.0;
    for (int i = 0; i < 3; ++i)
      if (at[i] < sides[i].count) last = std::min(last, sides[i].at[at[i]]);
    const int side = sides[0].sign(at[0]);
    if (first < last && side != 0 && side == sides[1].sign(at[1]) && side == sides[2].sign(at[2]) &&
        (side > 0 ? shows_above_ : shows_below_)) {
      if (!cut_) {
        keep(first, last);
      } else {
        // In front of the near plane Σe·z − near·Σe has the sign of Σe.
        const DepthOf<n> depth(e, z_);
        const Bernstein over = general(depth.above);
        Bernstein nearer = general(depth.below).raised(3 * n);
        for (std::size_t k = 0; k <= 3 * n; ++k) nearer.c[k] = side * (over.c[k] - near_ * nearer.c[k]);
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
      while (at[i] < sides[i].count && sides[i].at[at[i]] <= last) ++at[i];
    if (last >= 1.0) break;
    first = last;
  }
}

TriangleStretch::OnTexture TriangleStretch::on_texture(const Eigen::Vector3d& ray, double time) const {
  const double t = std::clamp(local(time), 0.0, 1.0);
  return texels({edge_[0].at(ray).at(t), edge_[1].at(ray).at(t), edge_[2].at(ray).at(t)});
}

TriangleStretch::OnTexture TriangleStretch::texels(const double (&e)[3]) const {
  double weight = 0.0, at[2] = {0.0, 0.0};
  for (std::size_t i = 0; i < 3; ++i) {
    weight += e[i];
    for (int c = 0; c < 2; ++c) at[c] += e[i] * double{uv[i][c]};
  }
  if (weight == 0.0) return {0.0, 0.0};
  return {at[0] / weight * texture->width - 0.5, (1.0 - at[1] / weight) * texture->height - 0.5};
}

void TriangleStretch::way_over_texels(const Eigen::Vector3d& ray,
                                      double (&way)[3][2 * most_path_degree + 1]) const {
  double e[3][2 * most_path_degree + 1], column[3], row[3];
  const int degree = edges(ray, e);
  for (int i = 0; i < 3; ++i) {
    column[i] = double{uv[i][0]} * texture->width - 0.5;
    row[i] = (1.0 - double{uv[i][1]}) * texture->height - 0.5;
  }
  for (int k = 0; k <= 2 * degree; ++k) {
    way[0][k] = e[0][k] * column[0] + (e[1][k] * column[1] + e[2][k] * column[2]);
    way[1][k] = e[0][k] * row[0] + (e[1][k] * row[1] + e[2][k] * row[2]);
    way[2][k] = e[0][k] + (e[1][k] + e[2][k]);
  }
}

namespace {

/// What rounding puts outside lies on the edge. Returns their sum.
double put_inside(double (&e)[3]) {
  const double side = e[0] + e[1] + e[2] < 0.0 ? -1.0 : 1.0;
  double weight = 0.0;
  for (double& v : e) weight += v = std::max(0.0, side * v);
  return weight;
}

}  // namespace

void TriangleStretch::color(const double (&edge)[3], double t, double (&seen)[4]) const {
  double e[3] = {edge[0], edge[1], edge[2]};
  const double weight = put_inside(e);
  if (plain || !(weight > 0.0)) return void(std::copy_n(rgba[0], 4, seen));
  mix(e, weight, t, seen);
}

void TriangleStretch::mix(const double (&e)[3], double weight, double t, double (&seen)[4]) const {
  const double share[3] = {e[0] / weight, e[1] / weight, e[2] / weight};
  for (int c = 0; c < 4; ++c) {
    seen[c] = 0.0;
    for (int i = 0; i < 3; ++i) seen[c] += share[i] * (double{rgba[i][c]} + t * double{more[i][c]});
  }
  if (texture == nullptr) return;
  double at[2] = {0.0, 0.0};
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 2; ++c) at[c] += share[i] * double{uv[i][c]};
  const Eigen::Vector4f texel = texture->at(at[0], at[1]);
  for (int c = 0; c < 4; ++c) seen[c] *= double{texel[c]};
}

template <int n>
TriangleStretch::Look TriangleStretch::look_of(const Eigen::Vector3d& ray, double time) const {
  const double t = std::clamp(local(time), 0.0, 1.0);
  double e[3];
  for (int i = 0; i < 3; ++i) e[i] = edge_at<n>(edge_[i], ray).at(t);
  const double weight = put_inside(e);
  Look seen{nearest_, {rgba[0][0], rgba[0][1], rgba[0][2], rgba[0][3]}};
  if (!(weight > 0.0)) return seen;
  double z = 0.0;
  for (int i = 0; i < 3; ++i) z += e[i] * fixed<n>(z_[i]).at(t);
  seen.depth = z / weight;
  if (!plain) mix(e, weight, t, seen.rgba);
  return seen;
}

// What follows chooses by the degree of the paths.

bool TriangleStretch::misses(const Eigen::Vector3d& ray, double half_x, double half_y) const {
  return degree_ == 1   ? misses_of<1>(ray, half_x, half_y)
         : degree_ == 2 ? misses_of<2>(ray, half_x, half_y)
                        : misses_of<3>(ray, half_x, half_y);
}

std::uint32_t TriangleStretch::may_meet(const RaysOfPixel& rays) const {
  return degree_ == 1 ? may_meet_of<1>(rays) : degree_ == 2 ? may_meet_of<2>(rays) : may_meet_of<3>(rays);
}

void TriangleStretch::meet(const Eigen::Vector3d& ray, double from, double to, std::uint32_t place,
                           std::uint32_t source, std::vector<PlaceInterval>& out) const {
  if (degree_ == 1) return meet_of<1>(ray, from, to, place, source, out);
  if (degree_ == 2) return meet_of<2>(ray, from, to, place, source, out);
  meet_of<3>(ray, from, to, place, source, out);
}

void TriangleStretch::keep(const Eigen::Vector3d& ray, double from, double to, const MetPlaces& met,
                           std::uint32_t k, std::uint32_t place, std::uint32_t source,
                           std::vector<PlaceInterval>& out) const {
  from = std::max(from, begin);
  to = std::min(to, end);
  if (!(from < to)) return;
  const std::uint32_t on[2] = {met.above >> k & 1, met.below >> k & 1};
  const int sooner = on[0] != 0 && (on[1] == 0 || met.first[0][k] < met.first[1][k]) ? 0 : 1;
  for (const int side : {sooner, 1 - sooner})
    if (on[side] != 0) keep_of<1>(ray, from, to, met.first[side][k], met.last[side][k], place, source, out);
}

TriangleStretch::Look TriangleStretch::look(const Eigen::Vector3d& ray, double time) const {
  return degree_ == 1 ? look_of<1>(ray, time) : degree_ == 2 ? look_of<2>(ray, time) : look_of<3>(ray, time);
}

}  // namespace swept
