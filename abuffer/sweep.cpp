#include "abuffer/sweep.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "abuffer/interval_math.h"

namespace swept {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

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
  fragments_ = &fragments;
  shades_ = shades.data();
  indices_ = indices;
  counters_ = &counters;
  start(count);
  float time = event_time(begins_.front());
  while (next_end_ < count) {
    pass_events(time);
    if (next_end_ == count) break;
    const float next = next_event(time);
    if (active_.size() == 0 && !hidden_.empty()) {
      reveal(time);
      continue;
    }
    time = active_.size() == 0 ? next : resolve_until(time, next, pixel);
  }
}

void PixelSweep::start(std::size_t count) {
  begins_.resize(count);
  ends_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    begins_[i] = event_key(fragments_->t_begin[indices_[i]], i);
    ends_[i] = event_key(fragments_->t_end[indices_[i]], i);
  }
  std::sort(begins_.begin(), begins_.end());
  std::sort(ends_.begin(), ends_.end());
  next_begin_ = next_end_ = 0;
  state_.assign(count, State::waiting);
  slot_.resize(count);
  place_.clear();
  active_.clear();
  hidden_.clear();
  hidden_min_z_ = front_limit_ = infinity;
}

void PixelSweep::activate(std::uint32_t place) {
  state_[place] = State::active;
  slot_[place] = static_cast<std::uint32_t>(active_.size());
  place_.push_back(place);
  const std::uint32_t f = indices_[place];
  active_.push(*fragments_, f, shades_[fragments_->kernel[f]]);
}

void PixelSweep::deactivate(std::uint32_t place) {
  const std::uint32_t slot = slot_[place];
  active_.remove(slot);
  place_[slot] = place_.back();
  slot_[place_[slot]] = slot;
  place_.pop_back();
}

/// What ends at or before `time` goes, what begins at or before it comes.
void PixelSweep::pass_events(float time) {
  for (; next_end_ < ends_.size() && event_time(ends_[next_end_]) <= time; ++next_end_) {
    const std::uint32_t place = event_place(ends_[next_end_]);
    if (state_[place] == State::active) deactivate(place);
    state_[place] = State::gone;
  }
  for (; next_begin_ < begins_.size() && event_time(begins_[next_begin_]) <= time; ++next_begin_) {
    const std::uint32_t place = event_place(begins_[next_begin_]);
    if (state_[place] != State::waiting) continue;
    if (lies_behind(place))
      hide(place);
    else
      activate(place);
  }
}

/// The first time after `after` at which something that is not hidden begins or ends. Hides on the way.
float PixelSweep::next_event(float after) {
  float next = infinity;
  for (; next_begin_ < begins_.size(); ++next_begin_) {
    const std::uint32_t place = event_place(begins_[next_begin_]);
    if (!lies_behind(place)) {
      next = event_time(begins_[next_begin_]);
      break;
    }
    // Not beyond what is active: there is nothing there to be behind of.
    if (event_time(begins_[next_begin_]) > after && active_.size() == 0) {
      next = event_time(begins_[next_begin_]);
      break;
    }
    hide(place);
  }
  for (; next_end_ < ends_.size() && event_time(ends_[next_end_]) < next; ++next_end_) {
    const std::uint32_t place = event_place(ends_[next_end_]);
    if (state_[place] == State::active) return event_time(ends_[next_end_]);
    state_[place] = State::gone;
  }
  return next;
}

bool PixelSweep::lies_behind(std::uint32_t place) const {
  if (front_limit_ == infinity) return false;
  const std::uint32_t f = indices_[place];
  const float z = fragments_->z[f];
  const float z_end = z + fragments_->z_rate[f] * (fragments_->t_end[f] - fragments_->t_begin[f]);
  return std::min(z, z_end) > front_limit_ + front_margin_;
}

void PixelSweep::hide(std::uint32_t place) {
  const std::uint32_t f = indices_[place];
  const float z_end =
      fragments_->z[f] + fragments_->z_rate[f] * (fragments_->t_end[f] - fragments_->t_begin[f]);
  hidden_min_z_ = std::min({hidden_min_z_, fragments_->z[f], z_end});
  hidden_.push_back(place);
  state_[place] = State::hidden;
  ++counters_->hidden;
}

/// After an opaque piece: puts aside the active members it did not use, where they stay behind for good.
void PixelSweep::hide_what_is_behind() {
  for (std::size_t i = active_.size(); i-- > 0;) {
    const std::uint32_t place = place_[i];
    if (!lies_behind(place)) continue;
    deactivate(place);
    hide(place);
  }
}

/// Takes back what was put aside, as of `time`.
void PixelSweep::reveal(float time) {
  ++counters_->revealed;
  front_limit_ = infinity;
  for (const std::uint32_t place : hidden_) {
    const std::uint32_t f = indices_[place];
    if (fragments_->t_end[f] <= time)
      state_[place] = State::gone;
    else if (fragments_->t_begin[f] <= time)
      activate(place);
    else
      state_[place] = State::waiting;
  }
  hidden_.clear();
  hidden_min_z_ = infinity;
  // Events passed over since `time` are to come again.
  const auto after = [&](const std::vector<std::uint64_t>& events) {
    const auto first = std::upper_bound(events.begin(), events.end(), time,
                                        [](float t, std::uint64_t key) { return t < event_time(key); });
    return static_cast<std::size_t>(first - events.begin());
  };
  next_begin_ = after(begins_);
  next_end_ = after(ends_);
}

/// Resolves [begin, end], or up to the returned time if what is hidden has to be looked at from there.
float PixelSweep::resolve_until(float begin, float end, PixelSum& pixel) {
  while (begin < end) {
    // Each pass may find that it has to end sooner; what it finds then holds for the shorter piece as well.
    float piece_end = end;
    for (;;) {
      const float sooner = build_surfaces(begin, piece_end);
      if (!(sooner < piece_end)) break;
      piece_end = sooner;
    }
    const bool opaque = transmittance_ <= opaque_transmittance;
    if (!hidden_.empty() && !(opaque && piece_limit_ < hidden_min_z_)) {
      reveal(begin);
      return begin;
    }
    composite(begin, piece_end, pixel);
    ++counters_->intervals;
    front_limit_ = opaque ? piece_limit_ : infinity;
    front_margin_ = piece_margin_;
    if (opaque && used_ < active_.size()) hide_what_is_behind();
    begin = piece_end;
  }
  return end;
}

/// Surfaces front to back, until no light is left. Returns `end`, or the sooner time to which the caller has
/// to shorten the piece.
float PixelSweep::build_surfaces(float begin, float end) {
  const Members all = active_.view();
  const std::size_t count = all.count;
  for (std::vector<float>* scratch : {&mean_, &z_begin_, &z_end_})
    if (scratch->size() < all.padded) scratch->resize(2 * all.padded);
  surfaces_.clear();
  transmittance_ = 1.0f;

  const DepthRange range = depths_over(all, begin, end, z_begin_.data(), z_end_.data());
  piece_margin_ = range.max_tolerance;
  // A little less than the limit, so that rounding does not ask for the same again.
  if (count > 1 && range.max_rate * (end - begin) > longest_span) {
    const float cut = shorten(begin, end, 0.99f * longest_span / (range.max_rate * (end - begin)));
    if (cut < end) return cut;
  }
  // A member's height above the lower envelope of all is convex in time, so it is largest at an end.
  if (range.max_begin - range.min_begin <= range.min_tolerance &&
      range.max_end - range.min_end <= range.min_tolerance) {
    surfaces_.push_back({all, {}});
    piece_limit_ = std::max(range.max_begin, range.max_end) + range.max_tolerance;
    used_ = count;
    return measure(surfaces_[0], begin, end);
  }

  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);
  piece_limit_ = -infinity;
  used_ = 0;
  while (used_ < count && transmittance_ > opaque_transmittance) {
    float sooner = end;
    const std::size_t last = gather_nearest(used_, begin, sooner);
    if (sooner < end) return sooner;
    if (parts_.size() == surfaces_.size()) parts_.emplace_back();
    Part& part = parts_[surfaces_.size()];
    part.members.clear();
    for (std::size_t i = used_; i < last; ++i) {
      part.members.push(active_, order_[i]);
      piece_limit_ = std::max({piece_limit_, z_begin_[order_[i]], z_end_[order_[i]]});
    }
    used_ = last;
    surfaces_.push_back({part.members.view(), {}});
    sooner = measure(surfaces_.back(), begin, end);
    if (sooner < end) return sooner;
  }
  piece_limit_ += range.max_tolerance;
  return end;
}

/// Moves the members of the surface that is nearest just after `begin` to the front of order_[first, …) and
/// returns their end. Shortens `end` to the time until which they are its members.
std::size_t PixelSweep::gather_nearest(std::size_t first, float begin, float& end) {
  const std::size_t count = order_.size();
  const auto rate_of = [&](std::uint32_t k) { return active_.get(member_z_rate, k); };
  const auto tolerance_of = [&](std::uint32_t k) { return active_.get(member_tolerance, k); };
  // Among equals the one that will be nearest, then the one that reaches farthest.
  const auto nearer = [&](std::uint32_t a, std::uint32_t b) {
    if (z_begin_[a] != z_begin_[b]) return z_begin_[a] < z_begin_[b];
    if (rate_of(a) != rate_of(b)) return rate_of(a) < rate_of(b);
    return tolerance_of(a) > tolerance_of(b);
  };
  std::uint32_t nearest = order_[first];
  for (std::size_t i = first + 1; i < count; ++i)
    if (nearer(order_[i], nearest)) nearest = order_[i];

  const float tolerance = tolerance_of(nearest), limit = z_begin_[nearest] + tolerance;
  std::size_t last = first;
  for (std::size_t i = first; i < count; ++i) {
    const std::uint32_t k = order_[i];
    if (z_begin_[k] < limit || (z_begin_[k] == limit && rate_of(k) <= rate_of(nearest)))
      std::swap(order_[i], order_[last++]);
  }

  // If no member is out of reach of the lower envelope at either end, none leaves between; and what lies
  // beyond reach of one and the same member at both ends stays behind.
  std::uint32_t nearest_at_end = order_[first];
  float smallest = infinity, largest = 0.0f;
  for (std::size_t i = first; i < last; ++i) {
    const std::uint32_t k = order_[i];
    if (z_end_[k] < z_end_[nearest_at_end]) nearest_at_end = k;
    smallest = std::min(smallest, tolerance_of(k));
    largest = std::max(largest, tolerance_of(k));
  }
  bool holds = true;
  for (std::size_t i = first; i < last && holds; ++i)
    holds = z_begin_[order_[i]] - z_begin_[nearest] <= smallest &&
            z_end_[order_[i]] - z_end_[nearest_at_end] <= smallest;
  const auto beyond = [&](std::uint32_t k, std::uint32_t of) {
    return z_begin_[k] - z_begin_[of] > largest && z_end_[k] - z_end_[of] > largest;
  };
  for (std::size_t i = last; i < count && holds; ++i)
    holds = beyond(order_[i], nearest) || beyond(order_[i], nearest_at_end);
  if (holds) return last;

  // Otherwise until the nearest is overtaken, or something comes within its tolerance or leaves it.
  float wait = end - begin;
  for (std::size_t i = first; i < count; ++i) {
    const std::uint32_t k = order_[i];
    if (k == nearest) continue;
    const float above = z_begin_[k] - z_begin_[nearest];
    const float rate = rate_of(k) - rate_of(nearest);
    if (i < last && rate > 0.0f)
      wait = std::min(wait, (tolerance - above) / rate);
    else if (rate < 0.0f)
      wait = std::min(wait, (i < last ? above : above - tolerance) / -rate);
  }
  wait = std::max(wait, shortest_interval);
  if (begin + wait < end) {
    end = begin + wait;
    ++counters_->crossings;
  }
  return last;
}

/// Cuts [begin, end] to a fraction, if that is not too short a piece. Returns its end.
float PixelSweep::shorten(float begin, float end, float fraction) {
  const float cut = begin + std::max((end - begin) * fraction, shortest_interval);
  if (!(cut < end)) return end;
  ++counters_->subdivided;
  return cut;
}

/// Sums the last surface over [begin, end] and takes its light. Returns `end`, or the sooner time to which
/// the piece has to be shortened for the sums' ratio to stand for the ratio's integral. `alone`: nothing lies
/// behind.
float PixelSweep::measure(Surface& surface, float begin, float end) {
  surface.sum = sum_over(surface.members, begin, end, mean_.data());
  const float scale = model_.scale(surface.sum.surface);
  transmittance_ *= 1.0f - std::min(1.0f, surface.sum.surface.rgba[3] * scale);

  const float edge = model_.edge_weight(), weight = surface.sum.surface.weight;
  const float least = weight - surface.sum.variation;
  const float most = std::min(weight + 2.0f * surface.sum.variation, surface.sum.peaks);
  const bool clamp_is_near = !model_.hard() && least < edge && most > edge;
  if (!clamp_is_near) return end;
  if (surface.sum.widest > longest_span) {
    const float cut = shorten(begin, end, 0.99f * longest_span / surface.sum.widest);
    if (cut < end) return cut;
  }

  const float at_begin = sum_over(surface.members, begin, begin, mean_.data()).surface.weight;
  const float at_end = sum_over(surface.members, end, end, mean_.data()).surface.weight;
  // The parabola with these ends and this mean has its extremum where Σρ has its own, if it has one within.
  const float slope = 6.0f * weight - 4.0f * at_begin - 2.0f * at_end;
  const float curvature = 3.0f * (at_begin + at_end - 2.0f * weight);
  const float vertex = -0.5f * slope / curvature;
  const float extremum = vertex > 0.0f && vertex < 1.0f ? at_begin + 0.5f * slope * vertex : at_begin;
  const float low = std::min({at_begin, extremum, at_end}), high = std::max({at_begin, extremum, at_end});
  if (low >= edge || high <= edge) return end;
  // The mean of the clamped differs from the clamped mean by at most a quarter of the range, whatever its
  // shape.
  if ((high - low) * (end - begin) <= 4.0f * edge * coverage_error) return end;
  // Where a straight line between the ends crosses the clamp, or in the middle if they lie on one side of it.
  const bool crosses = (at_begin < edge) != (at_end < edge);
  return shorten(begin, end,
                 crosses ? std::clamp((edge - at_begin) / (at_end - at_begin), 0.1f, 0.9f) : 0.5f);
}

void PixelSweep::composite(float begin, float end, PixelSum& pixel) {
  const float duration = end - begin;
  float transmittance = 1.0f;
  if (surfaces_.size() == 1) {
    const SurfaceSum& sum = surfaces_[0].sum.surface;
    add_surface(sum, model_.scale(sum), duration, transmittance, pixel);
    counters_->evaluations += surfaces_[0].members.count;
    return;
  }
  // The light that one surface lets through and what the next one covers change together, and the product of
  // their means is not the mean of their product. Two Gauss points integrate it to fourth order.
  constexpr float gauss_point = 0.211324865f;  // (1 − 1/√3)/2
  for (const float place : {gauss_point, 1.0f - gauss_point}) {
    const float time = begin + place * duration;
    transmittance = 1.0f;
    for (const Surface& surface : surfaces_) {
      const SurfaceSum sum = sum_over(surface.members, time, time, mean_.data()).surface;
      add_surface(sum, model_.scale(sum), 0.5f * duration, transmittance, pixel);
      counters_->evaluations += surface.members.count;
    }
  }
}

}  // namespace swept
