#include "abuffer/resolve/surfaces.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "abuffer/resolve/time_rule.h"
#include "splat/kernel/kernel_integral.h"

namespace swept {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// The shortest piece of the shutter that a change of surfaces or a subdivision may cut off. What happens
/// within it is worth at most as much of the image.
constexpr Ticks shortest_interval = shutter_close >> 20;

/// How far a kernel may move along its line, in units of y, in one piece where several kernels share a
/// surface: as far as the sums' series reaches.
constexpr float longest_span = 0.5f;

/// How much of a pixel's alpha the clamp of soft coverage may be off in one piece.
constexpr float coverage_error = 0x1p-15f;

}  // namespace

Ticks SurfaceStack::build(MemberSet& active, Ticks begin, Ticks end, SweepCounters& counters) {
  active_ = &active;
  counters_ = &counters;
  // Each attempt may find that it has to end sooner; what it finds then holds for the shorter piece as well.
  for (;;) {
    const Ticks sooner = attempt(begin, end);
    if (!(sooner < end)) return end;
    end = sooner;
  }
}

/// Surfaces front to back, until no light is left. Returns `end`, or the sooner time to which the caller has
/// to shorten the piece.
Ticks SurfaceStack::attempt(Ticks begin, Ticks end) {
  const Members all = active_->view();
  const std::size_t count = all.count;
  for (std::vector<float>* scratch : {&mean_, &at_ends_, &z_begin_, &z_end_})
    if (scratch->size() < all.padded) scratch->resize(2 * all.padded);
  surfaces_.clear();
  transmittance_ = 1.0f;
  points_ = 1;

  const DepthRange range = math_.depths_over(all, begin, end, z_begin_.data(), z_end_.data());
  margin_ = range.max_tolerance;
  if (count > 1) {
    const float duration = static_cast<float>(share_of(end - begin));
    const float span = range.max_rate * duration;
    points_ = points_for(span, duration, model_.delta());
    if (span > longest_span || points_ > most_points) {
      // A little less than the limit, so that rounding does not ask for the same again.
      float fraction = std::min(1.0f, 0.99f * longest_span / span);
      while (points_for(fraction * span, fraction * duration, model_.delta()) > most_points) fraction *= 0.8f;
      const Ticks cut = shorten(begin, end, fraction);
      if (cut < end) return cut;
      points_ = most_points;
    }
  }
  // A member's height above the lower envelope of all is convex in time, so it is largest at an end.
  if (range.max_begin - range.min_begin <= range.min_tolerance &&
      range.max_end - range.min_end <= range.min_tolerance) {
    surfaces_.push_back({all});
    limit_ = std::max(range.max_begin, range.max_end) + range.max_tolerance;
    used_ = count;
    return measure(surfaces_[0], begin, end);
  }

  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);
  limit_ = -infinity;
  used_ = 0;
  while (used_ < count && transmittance_ > opaque_transmittance) {
    Ticks sooner = end;
    const std::size_t last = gather_nearest(used_, begin, sooner);
    if (sooner < end) return sooner;
    if (parts_.size() == surfaces_.size()) parts_.emplace_back();
    MemberSet& part = parts_[surfaces_.size()];
    part.assign(*active_, std::span(order_).subspan(used_, last - used_));
    for (std::size_t i = used_; i < last; ++i)
      limit_ = std::max({limit_, z_begin_[order_[i]], z_end_[order_[i]]});
    used_ = last;
    surfaces_.push_back({part.view()});
    sooner = measure(surfaces_.back(), begin, end);
    if (sooner < end) return sooner;
  }
  limit_ += range.max_tolerance;
  return end;
}

/// Moves the members of the surface that is nearest just after `begin` to the front of order_[first, …) and
/// returns their end. Shortens `end` to the time until which they are its members.
std::size_t SurfaceStack::gather_nearest(std::size_t first, Ticks begin, Ticks& end) {
  const std::size_t count = order_.size();
  const float* const z_begin = z_begin_.data();
  const float* const z_end = z_end_.data();
  const float* const rates = active_->field(member_z_rate);
  const float* const tolerances = active_->field(member_tolerance);
  std::uint32_t* const order = order_.data();
  const auto rate_of = [&](std::uint32_t k) { return rates[k]; };
  const auto tolerance_of = [&](std::uint32_t k) { return tolerances[k]; };
  // Among equals the one that will be nearest, then the one that reaches farthest.
  const auto nearer = [&](std::uint32_t a, std::uint32_t b) {
    if (z_begin[a] != z_begin[b]) return z_begin[a] < z_begin[b];
    if (rate_of(a) != rate_of(b)) return rate_of(a) < rate_of(b);
    return tolerance_of(a) > tolerance_of(b);
  };
  std::uint32_t nearest = order[first];
  for (std::size_t i = first + 1; i < count; ++i)
    if (nearer(order[i], nearest)) nearest = order[i];

  const float tolerance = tolerance_of(nearest), limit = z_begin[nearest] + tolerance;
  std::size_t last = first;
  for (std::size_t i = first; i < count; ++i) {
    const std::uint32_t k = order[i];
    if (z_begin[k] < limit || (z_begin[k] == limit && rate_of(k) <= rate_of(nearest)))
      std::swap(order[i], order[last++]);
  }

  // If no member is out of reach of the lower envelope at either end, none leaves between; and what lies
  // beyond reach of one and the same member at both ends stays behind.
  std::uint32_t nearest_at_end = order[first];
  float smallest = infinity, largest = 0.0f;
  for (std::size_t i = first; i < last; ++i) {
    const std::uint32_t k = order[i];
    if (z_end[k] < z_end[nearest_at_end]) nearest_at_end = k;
    smallest = std::min(smallest, tolerance_of(k));
    largest = std::max(largest, tolerance_of(k));
  }
  bool holds = true;
  for (std::size_t i = first; i < last && holds; ++i)
    holds = z_begin[order[i]] - z_begin[nearest] <= smallest &&
            z_end[order[i]] - z_end[nearest_at_end] <= smallest;
  const auto beyond = [&](std::uint32_t k, std::uint32_t of) {
    return z_begin[k] - z_begin[of] > largest && z_end[k] - z_end[of] > largest;
  };
  for (std::size_t i = last; i < count && holds; ++i)
    holds = beyond(order[i], nearest) || beyond(order[i], nearest_at_end);
  if (holds) return last;

  // Otherwise until the nearest is overtaken, or something comes within its tolerance or leaves it.
  const double duration = share_of(end - begin);
  double wait = duration;
  for (std::size_t i = first; i < count; ++i) {
    const std::uint32_t k = order[i];
    if (k == nearest) continue;
    const float above = z_begin[k] - z_begin[nearest];
    const float rate = rate_of(k) - rate_of(nearest);
    if (i < last && rate > 0.0f)
      wait = std::min(wait, double{tolerance - above} / rate);
    else if (rate < 0.0f)
      wait = std::min(wait, double{i < last ? above : above - tolerance} / -rate);
  }
  if (!(wait < duration)) return last;
  // Rounded up, to where it has happened.
  const Ticks until = begin + static_cast<Ticks>(std::ceil(std::max(wait, 0.0) * shutter_close));
  if (until < begin + shortest_interval) ++counters_->shortest;
  const Ticks cut = std::max(until, begin + shortest_interval);
  if (cut < end) {
    end = cut;
    ++counters_->crossings;
  }
  return last;
}

/// Cuts [begin, end] to a fraction, if that is not too short a piece. Returns its end.
Ticks SurfaceStack::shorten(Ticks begin, Ticks end, float fraction) {
  const auto wanted = static_cast<Ticks>(double{fraction} * (end - begin));
  if (wanted < shortest_interval) ++counters_->shortest;
  const Ticks cut = begin + std::max(wanted, shortest_interval);
  if (!(cut < end)) return end;
  ++counters_->subdivided;
  return cut;
}

/// Sums a surface over [begin, end] and takes its light. Returns `end`, or the sooner time to which the piece
/// has to be shortened for its mean weight to tell how much of it is clamped.
Ticks SurfaceStack::measure(Surface& surface, Ticks begin, Ticks end) {
  surface.sum = math_.sum_over(surface.members, begin, end, mean_.data());
  const float scale = model_.scale(surface.sum.surface);
  transmittance_ *= 1.0f - std::min(1.0f, surface.sum.surface.rgba[3] * scale);

  const float edge = model_.edge_weight(), weight = surface.sum.surface.weight;
  const float least = weight - surface.sum.variation;
  const float most = std::min(weight + 2.0f * surface.sum.variation, surface.sum.peaks);
  surface.linear = !model_.hard() && most <= edge;
  const bool clamp_is_near = !model_.hard() && least < edge && most > edge;
  if (!clamp_is_near) return end;
  if (surface.sum.widest > longest_span) {
    const Ticks cut = shorten(begin, end, 0.99f * longest_span / surface.sum.widest);
    if (cut < end) return cut;
  }

  const float at_begin = math_.sum_over(surface.members, begin, begin, at_ends_.data()).surface.weight;
  const float at_end = math_.sum_over(surface.members, end, end, at_ends_.data()).surface.weight;
  // The parabola with these ends and this mean has its extremum where Σρ has its own, if it has one within.
  const float slope = 6.0f * weight - 4.0f * at_begin - 2.0f * at_end;
  const float curvature = 3.0f * (at_begin + at_end - 2.0f * weight);
  const float vertex = -0.5f * slope / curvature;
  const float extremum = vertex > 0.0f && vertex < 1.0f ? at_begin + 0.5f * slope * vertex : at_begin;
  const float low = std::min({at_begin, extremum, at_end}), high = std::max({at_begin, extremum, at_end});
  surface.linear = high <= edge;
  if (low >= edge || high <= edge) return end;
  // The mean of the clamped differs from the clamped mean by at most a quarter of the range, whatever its
  // shape.
  if (double{high - low} * share_of(end - begin) <= 4.0f * edge * coverage_error) return end;
  // Where a straight line between the ends crosses the clamp, or in the middle if they lie on one side of it.
  const bool crosses = (at_begin < edge) != (at_end < edge);
  return shorten(begin, end,
                 crosses ? std::clamp((edge - at_begin) / (at_end - at_begin), 0.1f, 0.9f) : 0.5f);
}

/// How far the mean of Σρz over [begin, end] lies from the members' means of ρ times their depths in the
/// middle, which are what measure() has added up, and mean_ still holds.
float SurfaceStack::depth_shift(const Members& members, Ticks begin, Ticks end) const {
  const auto duration = static_cast<float>(share_of(end - begin));
  float shift = 0.0f;
  const float *t = members.field(member_t_begin), *y = members.field(member_y),
              *rates = members.field(member_rate), *z_rate = members.field(member_z_rate);
  for (std::size_t k = 0; k < members.count; ++k) {
    const double rate = rates[k];
    const float moved = z_rate[k] * duration;
    if (moved == 0.0f || rate == 0.0) continue;
    const double since = share_of(begin - std::bit_cast<Ticks>(t[k]));
    const double y_begin = y[k] + rate * since;
    shift += mean_[k] * moved * static_cast<float>(gaussian_centroid(y_begin, y_begin + rate * duration));
  }
  return shift;
}

void SurfaceStack::composite(Ticks begin, Ticks end, PixelSum& pixel, SweepCounters& counters) {
  ++counters.intervals;
  const double duration = share_of(end - begin);
  const Surface& front = surfaces_.front();
  if (surfaces_.size() == 1 && (points_ == 1 || front.linear || front.members.count == 1)) {
    float transmittance = 1.0f;
    SurfaceSum sum = front.sum.surface;
    if (front.linear) sum.depth += depth_shift(front.members, begin, end);
    model_.add(sum, duration, transmittance, pixel);
    counters.evaluations += front.members.count;
    return;
  }
  // Of several surfaces the light that one lets through and what the next one covers change together, and the
  // product of their means is not the mean of their product.
  const GaussRule& rule = gauss_rule(points_);
  for (int i = 0; i < rule.points; ++i) {
    const Ticks time = begin + ticks_of(rule.place[i] * duration);
    float transmittance = 1.0f;
    for (const Surface& surface : surfaces_) {
      const SurfaceSum sum = math_.sum_over(surface.members, time, time, mean_.data()).surface;
      model_.add(sum, rule.weight[i] * duration, transmittance, pixel);
      counters.evaluations += surface.members.count;
    }
  }
}

}  // namespace swept
