// Where what a place sees of a texture is not smooth in time. Source: model section 15.2; Rönnow et al. 2021,
// section 4.3, whose texture is filtered from uv_s to uv_e, in parts at every event.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "abuffer/sources/triangle_stretch.h"

namespace swept {

/// Appends, in any order, when within ]begin, end[ the place on a triangle's texture, on_texture(time),
/// passes from texel to texel. Where it passes more than 2¹² of them the rest is left to the eye.
template <class On>
void add_texel_cuts(const On& on_texture, double begin, double end, std::vector<double>& cuts) {
  using At = TriangleStretch::OnTexture;
  const auto crossing = [&](double from, const At& a, double to, const At& b, double At::*axis) {
    const double low = std::floor(std::min(a.*axis, b.*axis)), line = std::floor(std::max(a.*axis, b.*axis));
    if (low == line) return;
    // Chords: the path is nearly straight on its way over a texel.
    double first = from, last = to, off_first = a.*axis - line, off_last = b.*axis - line, t = from;
    for (int step = 0; step < 6 && off_first != off_last; ++step) {
      t = first + (last - first) * (off_first / (off_first - off_last));
      if (!(t > from && t < to)) return;
      const double off = on_texture(t).*axis - line;
      if (std::abs(off) < 1e-7) break;
      if ((off < 0.0) == (off_first < 0.0))
        first = t, off_first = off;
      else
        last = t, off_last = off;
    }
    if (t > from && t < to) cuts.push_back(t);
  };
  const auto divide = [&](const auto& self, double from, const At& a, double to, const At& b,
                          int halvings) -> void {
    const double half = 0.5 * from + 0.5 * to;
    const At middle = on_texture(half);
    const auto way = [](const At& p, const At& q) {
      return std::max(std::abs(q.x - p.x), std::abs(q.y - p.y));
    };
    if (halvings > 0 && way(a, middle) + way(middle, b) > 1.0) {
      self(self, from, a, half, middle, halvings - 1);
      cuts.push_back(half);
      self(self, half, middle, to, b, halvings - 1);
      return;
    }
    crossing(from, a, to, b, &At::x);
    crossing(from, a, to, b, &At::y);
  };
  divide(divide, begin, on_texture(begin), end, on_texture(end), 12);
}

/// Calls add(from, to) for the parts of [begin, end] between these cuts, which it sorts and drops.
template <class Add>
void between_cuts(double begin, double end, std::vector<double>& cuts, const Add& add) {
  std::sort(cuts.begin(), cuts.end());
  for (const double cut : cuts) {
    if (!(begin < cut && cut < end)) continue;
    add(begin, cut);
    begin = cut;
  }
  cuts.clear();
  add(begin, end);
}

}  // namespace swept
