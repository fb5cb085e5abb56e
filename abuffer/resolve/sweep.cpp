#include "abuffer/resolve/sweep.h"

#include <algorithm>

namespace swept {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

std::uint64_t event_key(Ticks time, std::size_t place) {
  return static_cast<std::uint64_t>(time) << 32 | place;
}
Ticks event_time(std::uint64_t key) { return static_cast<Ticks>(key >> 32); }
std::uint32_t event_place(std::uint64_t key) { return static_cast<std::uint32_t>(key); }

}  // namespace

void PixelSweep::resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades,
                         const std::uint32_t* indices, std::size_t count, PixelSum& pixel,
                         SweepCounters& counters) {
  counters_ = &counters;
  start(fragments, shades.data(), indices, count);
  Ticks time = event_time(begins_.front());
  while (next_end_ < count) {
    pass_events(time);
    if (next_end_ == count) break;
    const Ticks next = next_event();
    if (active_.size() == 0 && !hidden_.empty()) {
      reveal(time);
      continue;
    }
    time = active_.size() == 0 ? next : resolve_until(time, next, pixel);
  }
  surfaces_.model().finish(pixel);
}

void PixelSweep::start(const FragmentArrays& fragments, const Shade* shades, const std::uint32_t* indices,
                       std::size_t count) {
  local_.resize(count);
  begins_.resize(count);
  ends_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t f = indices[i];
    const Ticks begin = fragments.t_begin[f], end = fragments.t_end[f];
    const float z = fragments.z[f], duration = static_cast<float>(share_of(end - begin));
    local_[i] = {member_of(fragments, f, shades[fragments.kernel[f]]), end,
                 std::min(z, z + fragments.z_rate[f] * duration)};
    begins_[i] = event_key(begin, i);
    ends_[i] = event_key(end, i);
  }
  sort_events(begins_);
  sort_events(ends_);
  next_begin_ = next_end_ = 0;
  state_.assign(count, State::waiting);
  slot_.resize(count);
  place_.clear();
  active_.clear();
  hidden_.clear();
  hidden_min_z_ = front_limit_ = infinity;
}

/// By as many buckets of time as there are events, and within each: times are spread out more often than not.
void PixelSweep::sort_events(std::vector<std::uint64_t>& events) {
  const auto count = static_cast<std::uint32_t>(events.size());
  const auto bucket_of = [&](std::uint64_t key) {
    const std::uint64_t bucket = (static_cast<std::uint64_t>(event_time(key)) * count) / shutter_close;
    return std::min(static_cast<std::uint32_t>(bucket), count - 1);
  };
  buckets_.assign(count + 1, 0);
  for (const std::uint64_t key : events) ++buckets_[bucket_of(key) + 1];
  for (std::uint32_t b = 0; b < count; ++b) buckets_[b + 1] += buckets_[b];
  by_bucket_.resize(count);
  for (const std::uint64_t key : events) by_bucket_[buckets_[bucket_of(key)]++] = key;
  // Now buckets_[b] is where bucket b ends.
  std::uint32_t first = 0;
  for (std::uint32_t b = 0; b < count; ++b) {
    if (buckets_[b] - first > 1) std::sort(by_bucket_.begin() + first, by_bucket_.begin() + buckets_[b]);
    first = buckets_[b];
  }
  events.swap(by_bucket_);
}

void PixelSweep::activate(std::uint32_t place) {
  state_[place] = State::active;
  slot_[place] = static_cast<std::uint32_t>(active_.size());
  place_.push_back(place);
  active_.push(local_[place].member);
}

void PixelSweep::deactivate(std::uint32_t place) {
  const std::uint32_t slot = slot_[place];
  active_.remove(slot);
  place_[slot] = place_.back();
  slot_[place_[slot]] = slot;
  place_.pop_back();
}

/// What ends at or before `time` goes, what begins at or before it comes.
void PixelSweep::pass_events(Ticks time) {
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

/// The first time to come at which something that is not hidden begins or ends. Hides on the way.
Ticks PixelSweep::next_event() {
  Ticks next = std::numeric_limits<Ticks>::max();
  for (; next_begin_ < begins_.size(); ++next_begin_) {
    const std::uint32_t place = event_place(begins_[next_begin_]);
    // Where nothing is active there is nothing to be behind of.
    if (active_.size() == 0 || !lies_behind(place)) {
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
  return front_limit_ != infinity && local_[place].least_depth > front_limit_ + front_margin_;
}

void PixelSweep::hide(std::uint32_t place) {
  hidden_min_z_ = std::min(hidden_min_z_, local_[place].least_depth);
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
void PixelSweep::reveal(Ticks time) {
  ++counters_->revealed;
  front_limit_ = infinity;
  for (const std::uint32_t place : hidden_) {
    if (local_[place].t_end <= time)
      state_[place] = State::gone;
    else if (local_[place].t_begin() <= time)
      activate(place);
    else
      state_[place] = State::waiting;
  }
  hidden_.clear();
  hidden_min_z_ = infinity;
  // Events passed over since `time` are to come again.
  const auto after = [&](const std::vector<std::uint64_t>& events) {
    const auto first = std::upper_bound(events.begin(), events.end(), time,
                                        [](Ticks t, std::uint64_t key) { return t < event_time(key); });
    return static_cast<std::size_t>(first - events.begin());
  };
  next_begin_ = after(begins_);
  next_end_ = after(ends_);
}

/// Resolves [begin, end], or up to the returned time if what is hidden has to be looked at from there.
Ticks PixelSweep::resolve_until(Ticks begin, Ticks end, PixelSum& pixel) {
  while (begin < end) {
    const Ticks piece_end = surfaces_.build(active_, begin, end, *counters_);
    const bool opaque = surfaces_.opaque();
    if (!hidden_.empty() && !(opaque && surfaces_.limit() < hidden_min_z_)) {
      reveal(begin);
      return begin;
    }
    surfaces_.composite(begin, piece_end, pixel, *counters_);
    front_limit_ = opaque ? surfaces_.limit() : infinity;
    front_margin_ = surfaces_.margin();
    if (opaque && surfaces_.used() < active_.size()) hide_what_is_behind();
    begin = piece_end;
  }
  return end;
}

}  // namespace swept
