#include "abuffer/resolve/place_peel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "splat/interval/fixed_bernstein.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

/// Where a depth is off its parabola by less than this share of itself, the parabola's mean stands for it.
constexpr double nearly_parabola = 1e-7;
/// An interval that was cut goes on at least so much later.
constexpr double least_step = 0x1p-46;

template <int degree>
double half_way(const FixedBernstein<degree>& p) {
  double sum = 0.0;
  for (int k = 0; k <= degree; ++k) sum += binomial_of(degree, k) * p.c[k];
  return sum * (1.0 / (1 << degree));
}

/// A depth over an interval: at both ends and half-way, by how much it is off the parabola through these at
/// most, and its slope off that of the parabola, the interval taken as 1.
struct Parabola {
  double z_begin, z_middle, z_end, off, slope_off;
};

/// Of above/below of a triangle's stretch between these shares of it. What is no number is off by infinity.
template <int n>
Parabola parabola_of(const double* above, const double* below, double from, double to) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  FixedBernstein<3 * n> over;
  FixedBernstein<2 * n> under;
  std::copy_n(above, 3 * n + 1, over.c);
  std::copy_n(below, 2 * n + 1, under.c);
  over = over.part(from, to);
  under = under.part(from, to);
  const double first = over.c[0] / under.c[0], middle = half_way(over) / half_way(under),
               last = over.c[3 * n] / under.c[2 * n];
  Parabola parabola{first, middle, last, infinity, infinity};
  if (under.side() == 0) return parabola;
  // Off by R/D, R = above − parabola·below and D = below, each no larger than its coefficients.
  FixedBernstein<2 * n + 2> product{};
  add_product(FixedBernstein<2>{{first, 2.0 * middle - 0.5 * (first + last), last}}, under, product);
  constexpr int degree = std::max(3 * n, 2 * n + 2);
  const FixedBernstein<degree> whole = raised_to<degree>(over), fitted = raised_to<degree>(product);
  double largest = 0.0, off = 0.0, slope_off = 0.0, before = 0.0;
  for (int k = 0; k <= degree; ++k) {
    const double apart = whole.c[k] - fitted.c[k];
    largest = std::max(largest, std::abs(whole.c[k]));
    off = std::max(off, std::abs(apart));
    if (k > 0) slope_off = std::max(slope_off, std::abs(apart - before));
    before = apart;
  }
  double least = std::abs(under.c[0]), steepest = 0.0;
  for (int k = 0; k <= 2 * n; ++k) {
    least = std::min(least, std::abs(under.c[k]));
    if (k > 0) steepest = std::max(steepest, std::abs(under.c[k] - under.c[k - 1]));
  }
  const double rounding = 1e-13 * largest, per = 1.0 / least;
  off = (off + rounding) * per;
  slope_off = (degree * (slope_off + rounding) + off * 2 * n * steepest) * per;
  if (std::isfinite(off) && std::isfinite(slope_off)) parabola.off = off, parabola.slope_off = slope_off;
  return parabola;
}

/// Where depths are equal whose distance grows or shrinks all the time and is `at_from` and `at_to`, of other
/// signs, at the ends: by false position, where an end that stays counts half as much.
double only_crossing(const PlaceDepth& a, const PlaceDepth& b, double from, double at_from, double to,
                     double at_to) {
  for (int step = 0; step < 60; ++step) {
    const double time = std::clamp(from + (to - from) * (at_from / (at_from - at_to)), from, to);
    const double at = a.at(time) - b.at(time);
    if (at == 0.0) return time;
    if ((at > 0.0) == (at_to > 0.0)) {
      if (!(to - time > least_step)) return time;
      to = time, at_to = at, at_from *= 0.5;
    } else {
      if (!(time - from > least_step)) return time;
      from = time, at_from = at, at_to *= 0.5;
    }
  }
  return 0.5 * from + 0.5 * to;
}

}  // namespace

bool PlacePeel::is_for(std::span<const PlaceInterval> intervals,
                       const std::vector<TriangleStretch>& triangles) {
  return std::all_of(intervals.begin(), intervals.end(), [&](const PlaceInterval& i) {
    return triangles[i.source].plain && !triangles[i.source].opaque;
  });
}

void PlacePeel::add(std::span<PlaceInterval> intervals, const std::vector<TriangleStretch>& triangles,
                    const Eigen::Vector3d& ray, const LightOverTime& light, const std::stop_token& stop,
                    PlaceCounters& counters, LightSum& sum) {
  triangles_ = &triangles;
  ray_ = &ray;
  light_ = &light;
  counters_ = &counters;
  layers_.clear();
  depths_.clear();
  active_.clear();
  cut_off_.clear();
  first_ = last_ = none;
  // The order of sources is that of the mesh, whatever the tile.
  std::sort(intervals.begin(), intervals.end(), [](const PlaceInterval& a, const PlaceInterval& b) {
    return std::tie(a.begin, a.source, a.end) < std::tie(b.begin, b.source, b.end);
  });
  const auto later = [&](std::uint32_t a, std::uint32_t b) {
    return std::tie(layers_[a].begin, layers_[a].source) > std::tie(layers_[b].begin, layers_[b].source);
  };
  for (std::size_t next = 0; next < intervals.size() || !cut_off_.empty();) {
    throw_if_stopped(stop);
    const std::uint32_t known = static_cast<std::uint32_t>(layers_.size());
    if (!cut_off_.empty() &&
        (next == intervals.size() || layers_[cut_off_.front()].begin <= intervals[next].begin)) {
      std::pop_heap(cut_off_.begin(), cut_off_.end(), later);
      const std::uint32_t layer = cut_off_.back();
      cut_off_.pop_back();
      insert(layer);
    } else {
      insert(layer_of(intervals[next++]));
    }
    if (!cut_off_.empty() && cut_off_.back() >= known)
      std::push_heap(cut_off_.begin(), cut_off_.end(), later);
  }
  spans_.assign(1, {1.0, 1.0});
  for (std::uint32_t i = first_; i != none; i = layers_[i].next)
    if (!take(i, sum)) break;
}

std::uint32_t PlacePeel::layer_of(const PlaceInterval& interval) {
  const TriangleStretch& triangle = (*triangles_)[interval.source];
  double above[3 * most_path_degree + 1], below[2 * most_path_degree + 1];
  const int degree = triangle.depth(*ray_, above, below);
  const auto share = [&](double time) { return std::clamp(triangle.local(time), 0.0, 1.0); };
  const double from = share(interval.begin), to = std::max(from, share(interval.end));
  Parabola of = degree == 1   ? parabola_of<1>(above, below, from, to)
                : degree == 2 ? parabola_of<2>(above, below, from, to)
                              : parabola_of<3>(above, below, from, to);
  // Never outside of these depths, where rounding may put a quotient of what is nearly 0.
  for (double* z : {&of.z_begin, &of.z_middle, &of.z_end}) {
    const double within = std::min(double{interval.farthest}, std::max(double{interval.nearest}, *z));
    if (within != *z) of.off = of.slope_off = std::numeric_limits<double>::infinity();
    *z = within;
  }
  const double turn = 2.0 * of.z_middle - 0.5 * (of.z_begin + of.z_end);
  double low = std::min({of.z_begin, turn, of.z_end}) - of.off,
         high = std::max({of.z_begin, turn, of.z_end}) + of.off;
  // A float's rounding.
  low -= 1e-6 * std::abs(low);
  high += 1e-6 * std::abs(high);
  layers_.push_back({interval.begin, interval.end, std::max(interval.nearest, static_cast<float>(low)),
                     std::min(interval.farthest, static_cast<float>(high)), interval.begin,
                     1.0 / (interval.end - interval.begin), of.z_begin,
                     4.0 * of.z_middle - 3.0 * of.z_begin - of.z_end,
                     2.0 * (of.z_begin + of.z_end) - 4.0 * of.z_middle, of.off, of.slope_off, interval.end,
                     interval.source});
  return static_cast<std::uint32_t>(layers_.size() - 1);
}

const PlaceDepth& PlacePeel::depth(std::uint32_t layer) {
  Layer& of = layers_[layer];
  if (of.depth == none) {
    of.depth = static_cast<std::uint32_t>(depths_.size());
    depths_.emplace_back((*triangles_)[of.source], *ray_, of.nearest, of.farthest);
  }
  return depths_[of.depth];
}

PlacePeel::Side PlacePeel::side(std::uint32_t one, std::uint32_t other, double& until) {
  const Layer &a = layers_[one], &b = layers_[other];
  if (a.farthest < b.nearest) return Side::before;
  if (b.farthest < a.nearest) return Side::behind;
  const double begin = a.begin, end = std::min(a.end, b.end), off = a.off + b.off;
  const double over_a = (end - begin) * a.per_time, over_b = (end - begin) * b.per_time;
  const double at_begin = a.at(begin) - b.at(begin), at_end = a.at(end) - b.at(end);
  // The middle coefficient of the difference in Bernstein form.
  const double turn = 0.5 * ((at_begin + at_end) - (a.bend * over_a * over_a - b.bend * over_b * over_b));
  if (std::min({at_begin, turn, at_end}) > off) return Side::behind;
  if (std::max({at_begin, turn, at_end}) < -off) return Side::before;
  // Where their distance grows or shrinks all the time there is one crossing or none.
  const double slopes_off = a.slope_off * over_a + b.slope_off * over_b;
  const bool steady = std::min(turn - at_begin, at_end - turn) > 0.5 * slopes_off ||
                      std::max(turn - at_begin, at_end - turn) < -0.5 * slopes_off;
  // Equal where both begin or end is the edge of two triangles, where it is their outline: no crossing.
  const double equal = 1e-11 * std::abs(a.z_begin);
  if (steady &&
      ((a.since == b.since && begin == a.since && std::abs(at_begin) <= equal && std::abs(at_end) > off) ||
       (a.until == b.until && end == a.until && std::abs(at_end) <= equal && std::abs(at_begin) > off)))
    return at_begin + at_end > 0.0 ? Side::behind : Side::before;
  // In one order, whichever came first.
  const std::uint32_t low = a.source < b.source ? one : other, high = low == one ? other : one;
  (void)depth(low);
  const PlaceDepth &of_high = depth(high), &of_low = depth(low);
  if (steady) {
    const double sign = low == one ? 1.0 : -1.0, first = of_low.at(begin) - of_high.at(begin),
                 last = of_low.at(end) - of_high.at(end);
    if (std::abs(first) > equal && std::abs(last) > equal && (first > 0.0) != (last > 0.0)) {
      until = std::min(until, only_crossing(of_low, of_high, begin, first, end, last));
      if (until > begin + least_step) return sign * first > 0.0 ? Side::behind : Side::before;
      return sign * last > 0.0 ? Side::behind : Side::before;
    }
    return sign * (first + last) > 0.0 ? Side::behind : Side::before;
  }
  crossings_.clear();
  PlaceDepth::add_crossings(of_low, of_high, begin, end, crossings_);
  double passes = end;
  for (const double time : crossings_)
    if (time > begin + least_step) passes = std::min(passes, time);
  until = std::min(until, passes);
  const double middle = 0.5 * begin + 0.5 * passes, z_low = of_low.at(middle), z_high = of_high.at(middle);
  return (z_low <= z_high) == (low == one) ? Side::before : Side::behind;
}

/// Puts it among those that are there, and what comes of it after it has passed through one of them last into
/// cut_off_.
void PlacePeel::insert(std::uint32_t layer) {
  const double begin = layers_[layer].begin, end = layers_[layer].end;
  double until = end;
  std::size_t kept = 0, before = 0;
  bool found = false;
  for (const std::uint32_t other : active_) {
    if (layers_[other].end <= begin) continue;
    active_[kept] = other;
    double passes = end;
    const Side at = side(layer, other, passes);
    // Where the other ends is no crossing.
    if (passes < std::min(end, layers_[other].end)) until = std::min(until, passes);
    if (at == Side::before && !found) found = true, before = kept;
    ++kept;
  }
  active_.resize(kept);
  if (!found) before = kept;
  if (until < end) {
    Layer rest = layers_[layer];
    rest.begin = until;
    layers_[layer].end = until;
    cut_off_.push_back(static_cast<std::uint32_t>(layers_.size()));
    layers_.push_back(rest);
    ++counters_->crossings;
  }
  // In front of the first that it is before.
  if (before < kept) {
    const std::uint32_t behind = active_[before];
    layers_[layer].next = behind;
    layers_[layer].previous = layers_[behind].previous;
    (layers_[behind].previous == none ? first_ : layers_[layers_[behind].previous].next) = layer;
    layers_[behind].previous = layer;
  } else {
    layers_[layer].previous = last_;
    layers_[layer].next = none;
    (last_ == none ? first_ : layers_[last_].next) = layer;
    last_ = layer;
  }
  active_.insert(active_.begin() + static_cast<std::ptrdiff_t>(before), layer);
}

/// ∫ z ds over these shares of light.
double PlacePeel::depth_over(std::uint32_t layer, double first, double last) {
  const Layer& of = layers_[layer];
  if (!light_->even() || !(of.off <= nearly_parabola * of.z_begin)) {
    const PlaceDepth& exact = depth(layer);
    return smooth_integral(*light_, first, last, [&](double time) { return exact.at(time); });
  }
  const double span = (last - first) * of.per_time, middle = 0.5 * first + 0.5 * last;
  return (last - first) * (of.at(middle) + of.bend * (span * span) * (1.0 / 12.0));
}

/// Adds what is seen of the layer, and leaves in spans_ the light that it leaves. False: none.
bool PlacePeel::take(std::uint32_t layer, LightSum& sum) {
  const Layer& of = layers_[layer];
  const double from = light_->share(of.begin), to = light_->share(of.end);
  if (!(from < to)) return true;
  const float(&rgba)[4] = (*triangles_)[of.source].rgba[0];
  const double through = 1.0 - double{rgba[3]};
  next_spans_.clear();
  bool lit = false;
  double begin = 0.0, weight = 0.0, depths = 0.0;
  const auto put = [&](double end, double left) {
    lit = lit || left > 0.0;
    if (!next_spans_.empty() && next_spans_.back().left == left)
      next_spans_.back().end = end;
    else
      next_spans_.push_back({end, left});
  };
  for (const Span& span : spans_) {
    const double first = std::max(begin, from), last = std::min(span.end, to);
    const bool whole = !(begin < first);
    begin = span.end;
    if (!(first < last)) {
      put(span.end, span.left);
      continue;
    }
    if (!whole) put(first, span.left);
    if (span.left > 0.0) {
      ++counters_->pieces;
      weight += span.left * (last - first);
      depths += span.left * depth_over(layer, first, last);
    }
    const double left = span.left * through;
    put(last, left < double{opaque_transmittance} ? 0.0 : left);
    if (last < span.end) put(span.end, span.left);
  }
  spans_.swap(next_spans_);
  for (int c = 0; c < 4; ++c) sum.v[c] += weight * double{rgba[c]};
  sum.v[4] += double{rgba[3]} * depths;
  return lit;
}

}  // namespace swept
