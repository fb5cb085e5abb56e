#include "abuffer/sweep.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "abuffer/interval_math.h"

namespace swept {
namespace {

/// The shortest piece of the shutter that a change of surfaces or a subdivision may cut off. What happens
/// within it is worth at most as much of the image.
constexpr float shortest_interval = 0x1p-20f;

/// How far a kernel may move along its line, in units of y, in one piece where several kernels share a
/// surface. The ratio of integrals differs from the integral of ratios in second order of this.
constexpr float longest_span = 0.5f;

/// How much of a pixel's alpha the clamp of soft coverage may be off in one piece.
constexpr float coverage_error = 0x1p-15f;

/// Positive floats order as their bits do.
std::uint64_t event_key(float time, std::size_t place) {
  return static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(time)) << 32 | place;
}
float event_time(std::uint64_t key) { return std::bit_cast<float>(static_cast<std::uint32_t>(key >> 32)); }
std::uint32_t event_place(std::uint64_t key) { return static_cast<std::uint32_t>(key); }

}  // namespace

void PixelSweep::resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades,
                         const std::uint32_t* indices, std::size_t count, PixelSum& pixel,
                         SweepCounters& counters) {
  begins_.resize(count);
  ends_.resize(count);
  slot_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    begins_[i] = event_key(fragments.t_begin[indices[i]], i);
    ends_[i] = event_key(fragments.t_end[indices[i]], i);
  }
  std::sort(begins_.begin(), begins_.end());
  std::sort(ends_.begin(), ends_.end());
  active_.clear();
  place_.clear();

  std::size_t next_begin = 0, next_end = 0;
  float time = event_time(begins_.empty() ? 0 : begins_.front());
  while (next_end < count) {
    while (next_end < count && event_time(ends_[next_end]) <= time) {
      const std::uint32_t gone = slot_[event_place(ends_[next_end++])];
      active_[gone] = active_.back();
      place_[gone] = place_.back();
      slot_[place_[gone]] = gone;
      active_.pop_back();
      place_.pop_back();
    }
    while (next_begin < count && event_time(begins_[next_begin]) <= time) {
      const std::uint32_t place = event_place(begins_[next_begin++]);
      const std::uint32_t f = indices[place];
      slot_[place] = static_cast<std::uint32_t>(active_.size());
      place_.push_back(place);
      active_.push_back({f, fragments.t_begin[f], fragments.y[f], fragments.rate[f], fragments.peak[f],
                         fragments.z[f], fragments.z_rate[f], &shades[fragments.kernel[f]]});
    }
    if (next_end == count) break;
    float next = event_time(ends_[next_end]);
    if (next_begin < count) next = std::min(next, event_time(begins_[next_begin]));
    if (!active_.empty()) resolve_interval(time, next, pixel, counters);
    time = next;
  }
}

void PixelSweep::resolve_interval(float begin, float end, PixelSum& pixel, SweepCounters& counters) {
  const std::size_t count = active_.size();
  for (std::vector<float>* field : {&y_, &span_, &peak_, &mean_, &z_begin_, &z_end_}) field->resize(count);
  while (begin < end) {
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0u);
    // Each pass may find that it has to end sooner; what it finds then holds for the shorter piece as well.
    float piece_end = end;
    for (;;) {
      const float sooner = build_surfaces(begin, piece_end, counters);
      if (!(sooner < piece_end)) break;
      piece_end = sooner;
    }
    float transmittance = 1.0f;
    for (const Surface& surface : surfaces_) {
      add_surface(surface.sum, surface.scale, piece_end - begin, transmittance, pixel);
      counters.evaluations += surface.last - surface.first;
    }
    ++counters.intervals;
    begin = piece_end;
  }
}

/// Surfaces front to back, until no light is left. Returns `end`, or the sooner time to which the caller has
/// to shorten the piece.
float PixelSweep::build_surfaces(float begin, float end, SweepCounters& counters) {
  surfaces_.clear();
  float transmittance = 1.0f;
  for (std::size_t first = 0; first < order_.size() && transmittance > opaque_transmittance;) {
    float sooner = end;
    const std::size_t last = gather_nearest(first, begin, sooner, counters);
    if (sooner < end) return sooner;
    Surface surface{first, last, {}, 0.0f};
    sooner = measure(surface, begin, end, counters);
    if (sooner < end) return sooner;
    transmittance *= 1.0f - std::min(1.0f, surface.sum.rgba[3] * surface.scale);
    surfaces_.push_back(surface);
    first = last;
  }
  return end;
}

/// Moves the members of the surface that is nearest just after `begin` to the front of order_[first, …) and
/// returns their end. Shortens `end` to the time until which they are its members.
std::size_t PixelSweep::gather_nearest(std::size_t first, float begin, float& end, SweepCounters& counters) {
  const std::size_t count = order_.size();
  const float duration = end - begin;
  for (std::size_t i = first; i < count; ++i) {
    const Active& a = active_[order_[i]];
    z_begin_[order_[i]] = a.z + a.z_rate * (begin - a.t_begin);
    z_end_[order_[i]] = a.z + a.z_rate * (end - a.t_begin);
  }
  const auto sooner = [&](std::uint32_t a, std::uint32_t b) {
    return z_begin_[a] != z_begin_[b] ? z_begin_[a] < z_begin_[b] : active_[a].z_rate < active_[b].z_rate;
  };
  std::uint32_t nearest = order_[first];
  for (std::size_t i = first + 1; i < count; ++i)
    if (sooner(order_[i], nearest)) nearest = order_[i];

  const float tolerance = active_[nearest].shade->depth_tolerance;
  const float limit = z_begin_[nearest] + tolerance;
  const auto member = std::stable_partition(order_.begin() + first, order_.end(), [&](std::uint32_t i) {
    return z_begin_[i] < limit || (z_begin_[i] == limit && active_[i].z_rate <= active_[nearest].z_rate);
  });
  const std::size_t last = static_cast<std::size_t>(member - order_.begin());

  // A member's height above the lower envelope is convex in time, so it is largest at an end: if no member is
  // out of reach there, none leaves between. What lies beyond reach of one and the same member at both ends
  // stays behind.
  std::uint32_t nearest_at_end = order_[first];
  float smallest = std::numeric_limits<float>::infinity(), largest = 0.0f;
  for (std::size_t i = first; i < last; ++i) {
    const std::uint32_t k = order_[i];
    if (z_end_[k] < z_end_[nearest_at_end]) nearest_at_end = k;
    smallest = std::min(smallest, active_[k].shade->depth_tolerance);
    largest = std::max(largest, active_[k].shade->depth_tolerance);
  }
  bool holds = true;
  for (std::size_t i = first; i < last && holds; ++i)
    holds = z_begin_[order_[i]] - z_begin_[nearest] <= smallest &&
            z_end_[order_[i]] - z_end_[nearest_at_end] <= smallest;
  const auto beyond = [&](std::uint32_t i, std::uint32_t of) {
    return z_begin_[i] - z_begin_[of] > largest && z_end_[i] - z_end_[of] > largest;
  };
  for (std::size_t i = last; i < count && holds; ++i)
    holds = beyond(order_[i], nearest) || beyond(order_[i], nearest_at_end);
  if (holds) return last;

  // Otherwise until the nearest is overtaken, or something comes within its tolerance or leaves it.
  float wait = duration;
  for (std::size_t i = first; i < count; ++i) {
    const std::uint32_t k = order_[i];
    if (k == nearest) continue;
    const float above = z_begin_[k] - z_begin_[nearest];
    const float rate = active_[k].z_rate - active_[nearest].z_rate;
    if (i < last && rate > 0.0f)
      wait = std::min(wait, (tolerance - above) / rate);
    else if (rate < 0.0f)
      wait = std::min(wait, (i < last ? above : above - tolerance) / -rate);
  }
  wait = std::max(wait, shortest_interval);
  if (begin + wait < end) {
    end = begin + wait;
    ++counters.crossings;
  }
  return last;
}

/// peak_ … mean_ [0, last − first) for the members' means over [begin, end].
void PixelSweep::means_of(std::size_t first, std::size_t last, float begin, float end) {
  for (std::size_t i = first; i < last; ++i) {
    const Active& a = active_[order_[i]];
    y_[i - first] = a.y + a.rate * (begin - a.t_begin);
    span_[i - first] = a.rate * (end - begin);
    peak_[i - first] = a.peak;
  }
  weighted_means(y_.data(), span_.data(), peak_.data(), mean_.data(), last - first);
}

float PixelSweep::sum_at(std::size_t first, std::size_t last, float time) {
  means_of(first, last, time, time);
  return std::accumulate(mean_.begin(), mean_.begin() + (last - first), 0.0f);
}

/// Sums over [begin, end]. Returns `end`, or the sooner time to which the piece has to be shortened for the
/// sums' ratio to stand for the ratio's integral.
float PixelSweep::measure(Surface& surface, float begin, float end, SweepCounters& counters) {
  const std::size_t first = surface.first, last = surface.last;
  means_of(first, last, begin, end);
  SurfaceSum& sum = surface.sum;
  float widest = 0.0f;
  for (std::size_t i = first; i < last; ++i) {
    const Active& a = active_[order_[i]];
    const float mean = mean_[i - first];
    sum.weight += mean;
    for (int c = 0; c < 4; ++c) sum.rgba[c] += mean * a.shade->rgba[c];
    sum.depth += mean * (a.z + a.z_rate * (0.5f * (begin + end) - a.t_begin));
    widest = std::max(widest, span_[i - first]);
  }
  surface.scale = model_.scale(sum);

  const auto shorten = [&](float fraction) {
    const float cut = begin + std::max((end - begin) * fraction, shortest_interval);
    if (!(cut < end)) return end;
    ++counters.subdivided;
    return cut;
  };
  const float edge = model_.edge_weight();
  const bool clamp_is_near = !model_.hard() && sum.weight > 0.25f * edge && sum.weight < 4.0f * edge;
  if ((last - first > 1 || clamp_is_near) && widest > longest_span) return shorten(longest_span / widest);
  if (!clamp_is_near) return end;

  const float at_begin = sum_at(first, last, begin), at_end = sum_at(first, last, end);
  const float low = std::min({at_begin, at_end, sum.weight}), high = std::max({at_begin, at_end, sum.weight});
  if (low >= edge || high <= edge) return end;
  if ((high - low) * (end - begin) <= 8.0f * edge * coverage_error) return end;
  // Where a straight line between the ends crosses the clamp, or in the middle if they lie on one side of it.
  const bool crosses = (at_begin < edge) != (at_end < edge);
  return shorten(crosses ? std::clamp((edge - at_begin) / (at_end - at_begin), 0.1f, 0.9f) : 0.5f);
}

}  // namespace swept
