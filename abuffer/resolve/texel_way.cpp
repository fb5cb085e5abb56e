#include "abuffer/resolve/texel_way.h"

#include <algorithm>
#include <cmath>

namespace swept {
namespace {

/// How far off a parabola may be, in texels: what it finds, or where what divides varies by more than twice,
/// what is summed up by nodes as well.
constexpr double most_off = 0x1p-10, most_off_steep = 0x1p-16;
constexpr int most_halvings = 5;
/// On one parabola's way.
constexpr double most_lines = 4096.0;

/// Appends the roots of p in ]0, 1[.
void add_roots(double start, double slope, double bend, std::vector<double>& roots) {
  const double square = slope * slope - 4.0 * bend * start;
  if (!(square >= 0.0)) return;
  // Without differences of what is nearly equal.
  const double q = -0.5 * (slope + std::copysign(std::sqrt(square), slope));
  for (const double root : {q / bend, start / q})
    if (root > 0.0 && root < 1.0) roots.push_back(root);
}

/// Texel `at` of a row or column of `count` that repeats.
std::size_t wrapped(double at, int count) {
  const auto texel = static_cast<std::size_t>(at - std::floor(at / count) * count);
  // Rounding may have it at the end of the turn.
  return texel < static_cast<std::size_t>(count) ? texel : 0;
}

}  // namespace

bool TexelWay::find(const TriangleStretch& triangle, const Eigen::Vector3d& ray, double begin, double end) {
  steps_.clear();
  begin_ = begin;
  per_time_ = 1.0 / (end - begin);
  degree_ = triangle.degree();
  return degree_ == 1   ? find_of<1>(triangle, ray, end)
         : degree_ == 2 ? find_of<2>(triangle, ray, end)
                        : find_of<3>(triangle, ray, end);
}

template <int n>
bool TexelWay::find_of(const TriangleStretch& triangle, const Eigen::Vector3d& ray, double end) {
  double whole[3][2 * most_path_degree + 1];
  triangle.way_over_texels(ray, whole);
  const double from = std::clamp(triangle.local(begin_), 0.0, 1.0),
               to = std::clamp(triangle.local(end), from, 1.0);
  Way<n> way;
  for (int i = 0; i < 3; ++i) {
    std::copy_n(whole[i], 2 * n + 1, way[i].c);
    way[i] = way[i].part(from, to);
    way[i].to_powers(powers_[i]);
  }
  return fit<n>(way, begin_, end, most_halvings);
}

template <int n>
bool TexelWay::fit(const Way<n>& way, double begin, double end, int halvings) {
  const FixedBernstein<2 * n>& below = way[2];
  if (below.side() != 0) {
    double least = std::abs(below.c[0]), most = least;
    for (const double v : below.c) least = std::min(least, std::abs(v)), most = std::max(most, std::abs(v));
    const double by_begin = 1.0 / below.c[0], by_middle = 1.0 / below.at(0.5), by_end = 1.0 / below.c[2 * n];
    Parabola found[2];
    double off = 0.0;
    for (int i = 0; i < 2; ++i) {
      const double first = way[i].c[0] * by_begin, middle = way[i].at(0.5) * by_middle,
                   last = way[i].c[2 * n] * by_end;
      const FixedBernstein<2> p{{first, 2.0 * middle - 0.5 * (first + last), last}};
      // above − p·below is 0 at the ends and the middle, and no larger than its coefficients.
      FixedBernstein<2 * n + 2> product{};
      add_product(p, below, product);
      const FixedBernstein<2 * n + 2> above = raised_to<2 * n + 2>(way[i]);
      for (int k = 1; k <= 2 * n + 1; ++k) off = std::max(off, std::abs(above.c[k] - product.c[k]));
      found[i] = {first, 2.0 * (p.c[1] - first), first - 2.0 * p.c[1] + last};
    }
    if (off <= (most <= 2.0 * least ? most_off : most_off_steep) * least) return add_steps(found, begin, end);
  }
  if (halvings == 0) return false;
  const double half = 0.5 * begin + 0.5 * end;
  const auto part = [&](double from, double to, double first, double last) {
    const Way<n> of = {way[0].part(from, to), way[1].part(from, to), way[2].part(from, to)};
    return fit<n>(of, first, last, halvings - 1);
  };
  return part(0.0, 0.5, begin, half) && part(0.5, 1.0, half, end);
}

/// From line to line between texels.
bool TexelWay::add_steps(const Parabola (&of)[2], double begin, double end) {
  cuts_.clear();
  for (const Parabola& p : of) {
    const double control = p.start + 0.5 * p.slope, last = p.at(1.0);
    const double low = std::floor(std::min({p.start, control, last})),
                 high = std::floor(std::max({p.start, control, last}));
    // Written so that what is no number fails it.
    if (!(high - low <= most_lines)) return false;
    for (double line = low + 1.0; line <= high; ++line) add_roots(p.start - line, p.slope, p.bend, cuts_);
  }
  std::sort(cuts_.begin(), cuts_.end());
  cuts_.push_back(1.0);
  double first = 0.0;
  for (const double last : cuts_) {
    const double middle = 0.5 * first + 0.5 * last, column = std::floor(of[0].at(middle)),
                 row = std::floor(of[1].at(middle));
    steps_.push_back({last < 1.0 ? begin + last * (end - begin) : end, column, row, 0.0, 0.0, 0.0, 0.0});
    first = last;
  }
  return true;
}

void TexelWay::see(const LightLeft::Part& part) {
  degree_ == 1 ? see_of<1>(part) : degree_ == 2 ? see_of<2>(part) : see_of<3>(part);
}

template <int n>
void TexelWay::see_of(const LightLeft::Part& part) {
  const auto value = [&](int i, double u) {
    double sum = powers_[i][2 * n];
    for (int k = 2 * n; k-- > 0;) sum = sum * u + powers_[i][k];
    return sum;
  };
  double begin = begin_;
  for (Step& step : steps_) {
    const double first = std::max(begin, part.begin), last = std::min(step.end, part.end);
    begin = step.end;
    if (!(first < last)) continue;
    const double span = last - first;
    const auto add = [&](double at, double light) {
      const double u = (first + at * span - begin_) * per_time_, by = 1.0 / value(2, u);
      const double x = value(0, u) * by - step.column, y = value(1, u) * by - step.row;
      step.one += light;
      step.of_x += light * x;
      step.of_y += light * y;
      step.of_xy += light * x * y;
    };
    if (part.is_even) {
      add(0.5 - ThreeNodes::offset, part.even * span * ThreeNodes::side);
      add(0.5, part.even * span * ThreeNodes::middle);
      add(0.5 + ThreeNodes::offset, part.even * span * ThreeNodes::side);
    } else {
      const LightLeft::Part within = part.between(first, last);
      for (std::size_t k = 0; k < smooth_points; ++k)
        add(smooth_part::at[k], within.changes.v[k] * smooth_part::weight[k] * span);
    }
  }
}

void TexelWay::add_colors(const Texture& texture, double (&sum)[3]) const {
  for (const Step& step : steps_) {
    if (step.one == 0.0) continue;
    const std::size_t left = wrapped(step.column, texture.width), top = wrapped(step.row, texture.height);
    const std::size_t right = left + 1 < static_cast<std::size_t>(texture.width) ? left + 1 : 0,
                      bottom = top + 1 < static_cast<std::size_t>(texture.height) ? top + 1 : 0;
    const auto texel = [&](std::size_t row, std::size_t column) {
      return texture.texels[row * static_cast<std::size_t>(texture.width) + column].data();
    };
    const float *a = texel(top, left), *b = texel(top, right), *c = texel(bottom, left),
                *d = texel(bottom, right);
    const double by_b = step.of_x - step.of_xy, by_c = step.of_y - step.of_xy,
                 by_a = step.one - step.of_x - by_c;
    for (int k = 0; k < 3; ++k)
      sum[k] += by_a * double{a[k]} + by_b * double{b[k]} + (by_c * double{c[k]} + step.of_xy * double{d[k]});
  }
}

void TexelWay::add_light(const TriangleStretch& triangle, LightSum& sum) const {
  double seen[3] = {0.0, 0.0, 0.0};
  add_colors(*triangle.texture, seen);
  for (int c = 0; c < 3; ++c) sum.v[c] += double{triangle.rgba[0][c]} * seen[c];
}

}  // namespace swept
