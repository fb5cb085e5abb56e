#include "abuffer/resolve/place_peel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "splat/interval/fixed_bernstein.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

/// An interval that was cut goes on at least so much later.
constexpr double least_step = 0x1p-46;

template <int degree>
double half_way(const FixedBernstein<degree>& p) {
  double sum = 0.0;
  for (int k = 0; k <= degree; ++k) sum += binomial_of(degree, k) * p.c[k];
  return sum * (1.0 / (1 << degree));
}

struct Chord {
  double z_begin, z_middle, z_end, bow;
};

/// Of above/below of a triangle's stretch between these shares of it. What is no number is off by infinity.
template <int n>
Chord chord_of(const double* above, const double* below, double from, double to) {
  FixedBernstein<3 * n> over;
  FixedBernstein<2 * n> under;
  std::copy_n(above, 3 * n + 1, over.c);
  std::copy_n(below, 2 * n + 1, under.c);
  over = over.part(from, to);
  under = under.part(from, to);
  Chord chord{over.c[0] / under.c[0], half_way(over) / half_way(under), over.c[3 * n] / under.c[2 * n],
              std::numeric_limits<double>::infinity()};
  if (under.side() == 0) return chord;
  // above − line·below is 0 at the ends: u (1 − u) times a polynomial of two degrees less, which is no larger
  // than its coefficients.
  constexpr int degree = 3 * n;
  FixedBernstein<degree> apart{};
  add_product(raised_to<n>(FixedBernstein<1>{{chord.z_begin, chord.z_end}}), under, apart);
  double most = 0.0, largest = 0.0, least_under = std::abs(under.c[0]);
  for (const double v : over.c) largest = std::max(largest, std::abs(v));
  for (const double v : under.c) least_under = std::min(least_under, std::abs(v));
  for (int k = 1; k < degree; ++k)
    most = std::max(most, degree * (degree - 1.0) / (k * (degree - k)) * std::abs(over.c[k] - apart.c[k]));
  const double bow = (most + 1e-13 * largest) / least_under;
  if (std::isfinite(bow)) chord.bow = bow;
  return chord;
}

}  // namespace

bool PlacePeel::is_for(std::span<const PlaceInterval> intervals,
                       const std::vector<TriangleStretch>& triangles) {
  return std::all_of(intervals.begin(), intervals.end(),
                     [&](const PlaceInterval& i) { return !triangles[i.source].opaque; });
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
  make_layers(intervals);
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
      insert(static_cast<std::uint32_t>(next++));
    }
    if (!cut_off_.empty() && cut_off_.back() >= known)
      std::push_heap(cut_off_.begin(), cut_off_.end(), later);
  }
  left_.start();
  for (std::uint32_t i = first_; i != none; i = layers_[i].next) {
    throw_if_stopped(stop);
    if (!take(i, sum)) break;
  }
}

/// Those of straight paths together.
void PlacePeel::make_layers(std::span<const PlaceInterval> intervals) {
  for (std::size_t first = 0; first < intervals.size();) {
    int count = 0;
    for (; count < DepthChords::most && first + count < intervals.size(); ++count) {
      const PlaceInterval& interval = intervals[first + count];
      const TriangleStretch& triangle = (*triangles_)[interval.source];
      if (!triangle.on_lines()) break;
      chords_.since[count] = triangle.begin;
      chords_.until[count] = triangle.end;
      chords_.begin[count] = interval.begin;
      chords_.end[count] = interval.end;
      chords_.nearest[count] = double{interval.nearest};
      chords_.farthest[count] = double{interval.farthest};
      triangle.depth(*ray_, count, chords_);
    }
    if (count == 0) {
      make_layer(intervals[first++]);
      continue;
    }
    math_.chords(chords_);
    for (int i = 0; i < count; ++i)
      put_layer(intervals[first++], chords_.per_time[i], chords_.z_begin[i], chords_.z_middle[i],
                chords_.z_end[i], chords_.bow[i]);
  }
}

void PlacePeel::make_layer(const PlaceInterval& interval) {
  const TriangleStretch& triangle = (*triangles_)[interval.source];
  double above[3 * most_path_degree + 1], below[2 * most_path_degree + 1];
  const int degree = triangle.depth(*ray_, above, below);
  const auto share = [&](double time) { return std::clamp(triangle.local(time), 0.0, 1.0); };
  const double from = share(interval.begin), to = std::max(from, share(interval.end));
  Chord chord = degree == 1   ? chord_of<1>(above, below, from, to)
                : degree == 2 ? chord_of<2>(above, below, from, to)
                              : chord_of<3>(above, below, from, to);
  // Never outside of these depths, where rounding may put a quotient of what is nearly 0.
  for (double* z : {&chord.z_begin, &chord.z_middle, &chord.z_end}) {
    const double within = std::min(double{interval.farthest}, std::max(double{interval.nearest}, *z));
    if (within != *z) chord.bow = std::numeric_limits<double>::infinity();
    *z = within;
  }
  put_layer(interval, 1.0 / (interval.end - interval.begin), chord.z_begin, chord.z_middle, chord.z_end,
            chord.bow);
}

void PlacePeel::put_layer(const PlaceInterval& interval, double per_time, double z_begin, double z_middle,
                          double z_end, double bow) {
  const double low = std::min(z_begin, z_end) - 0.25 * bow, high = std::max(z_begin, z_end) + 0.25 * bow;
  // A float's rounding.
  const float nearest = std::max(interval.nearest, static_cast<float>(low - 1e-6 * std::abs(low))),
              farthest = std::min(interval.farthest, static_cast<float>(high + 1e-6 * std::abs(high)));
  layers_.push_back({interval.begin, interval.end, nearest, farthest, interval.source, none, none, none,
                     interval.begin, interval.end, per_time, z_begin, z_middle, z_end, bow});
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
  if (a.passed == other) return a.passed_to;
  if (a.farthest < b.nearest) return Side::before;
  if (b.farthest < a.nearest) return Side::behind;
  const double begin = a.begin, end = std::min(a.end, b.end), at_begin = a.line(begin) - b.line(begin),
               at_end = a.line(end) - b.line(end);
  const double off = 0.25 * (a.bow + b.bow);
  if (at_begin > off && at_end > off) return Side::behind;
  if (at_begin < -off && at_end < -off) return Side::before;
  // Triangles on either side of an edge, where it is the outline: at one depth where both begin or end, from
  // where their distance grows faster than lines may be off.
  const double equal = 1e-10 * std::abs(a.z_begin), apart = std::max(std::abs(at_begin), std::abs(at_end));
  const double bends = (end - begin) * (a.bow * a.per_time + b.bow * b.per_time);
  if ((std::abs(at_begin) <= equal && a.since == b.since && a.since == begin && apart > bends) ||
      (std::abs(at_end) <= equal && a.until == b.until && a.until == end && apart > bends))
    return at_begin + at_end > 0.0 ? Side::behind : Side::before;
  // In one order, whichever came first.
  const std::uint32_t low = a.source < b.source ? one : other, high = low == one ? other : one;
  (void)depth(low);
  const PlaceDepth &of_high = depth(high), &of_low = depth(low);
  crossings_.clear();
  PlaceDepth::add_crossings(of_low, of_high, begin, end, crossings_);
  double passes = end;
  times_passed_ = 0;
  for (const double time : crossings_)
    if (time > begin + least_step) passes = std::min(passes, time), ++times_passed_;
  until = std::min(until, passes);
  const auto at = [&](double time) {
    return (of_low.at(time) <= of_high.at(time)) == (low == one) ? Side::before : Side::behind;
  };
  // Looked at, as rounding may have a crossing of what begins at one depth.
  if (times_passed_ == 1) then_ = at(0.5 * passes + 0.5 * end);
  return at(0.5 * begin + 0.5 * passes);
}

/// Puts it among those that are there, and what comes of it after it has passed through one of them last into
/// cut_off_.
void PlacePeel::insert(std::uint32_t layer) {
  const double begin = layers_[layer].begin, end = layers_[layer].end;
  double until = end;
  std::size_t kept = 0, before = 0;
  bool found = false;
  std::uint32_t passed = none;
  Side passed_to = Side::before;
  for (const std::uint32_t other : active_) {
    if (layers_[other].end <= begin) continue;
    active_[kept] = other;
    double passes = end;
    const Side at = side(layer, other, passes);
    // Where the other ends is no crossing.
    if (passes < std::min(until, layers_[other].end)) {
      until = passes;
      passed = times_passed_ == 1 ? other : none;
      passed_to = then_;
    }
    if (at == Side::before && !found) found = true, before = kept;
    ++kept;
  }
  active_.resize(kept);
  if (!found) before = kept;
  if (until < end) {
    Layer rest = layers_[layer];
    rest.begin = until;
    rest.passed = passed;
    rest.passed_to = passed_to;
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

}  // namespace swept
