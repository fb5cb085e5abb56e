#include "abuffer/resolve/sweep.h"

#include <algorithm>
#include <limits>

#include "abuffer/resolve/lone.h"
#include "abuffer/resolve/time_rule.h"

namespace swept {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr Ticks never = std::numeric_limits<Ticks>::max();

/// Of a step by j at the share x of the piece, the line that stands for Σρ leaves the variance j² x(1−x) (1 −
/// 3x(1−x)), which is j²/12 at most. So a colour is off by at most a twelfth of the square of few_jumps, and
/// by as much less as steps are far from the worst x or go to both sides; and it is off by no more than as
/// large a share of the range of the members' colours, so that of like colours more may begin and end. But
/// not so much that a line is no likeness of the weight.
constexpr float most_jumps = 0.6f;
bool few_enough(const FrontSum& front) {
  const float jumps = front.jumps, weight = front.mean.weight;
  if (jumps <= few_jumps * weight) return true;
  constexpr float half_of_square = 0.5f * few_jumps * few_jumps;
  return jumps <= most_jumps * weight && jumps * jumps * front.range <= half_of_square * weight * weight;
}

/// Fewer members are soon resolved from event to event.
constexpr std::size_t least_to_merge = 32;
/// How many fragments a merged stack takes in where nothing is known better.
constexpr std::size_t first_merged = 3;
/// For how many stacks at the most none is tried to be merged after that has failed.
constexpr int longest_pause = 255;

std::uint64_t event_key(Ticks time, std::size_t place) {
  return static_cast<std::uint64_t>(time) << 32 | place;
}
Ticks event_time(std::uint64_t key) { return static_cast<Ticks>(key >> 32); }
std::uint32_t event_place(std::uint64_t key) { return static_cast<std::uint32_t>(key); }

}  // namespace

void PixelSweep::resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades,
                         const std::uint32_t* indices, std::size_t count, PixelSum& pixel,
                         SweepCounters& counters, const ChangingShades& changes) {
  counters_ = &counters;
  changes_ = changes;
  start(fragments, shades.data(), indices, count);
  for (Ticks time = 0;;) {
    admit(time + 1);
    if (active_.members.size() > 0) {
      time = advance(time, pixel);
      let_go(time);
      continue;
    }
    // Where nothing is active there is nothing to be behind of.
    step_ = 0;
    front_limit_ = infinity;
    if (hidden_last_end_ <= time) forget_hidden();
    if (!hidden_.empty()) {
      reveal(time);
    } else {
      if (next_ == begins_.size()) break;
      time = next_begin();
    }
  }
  model_.finish(pixel);
}

void PixelSweep::resolve_into(PieceSink& sink, const FragmentArrays& fragments,
                              const std::vector<Shade>& shades, const std::uint32_t* indices,
                              std::size_t count, SweepCounters& counters, const ChangingShades& changes) {
  PixelSum unused;
  sink_ = &sink;
  resolve(fragments, shades, indices, count, unused, counters, changes);
  sink_ = nullptr;
}

void PixelSweep::start(const FragmentArrays& fragments, const Shade* shades, const std::uint32_t* indices,
                       std::size_t count) {
  fragments_ = &fragments;
  shades_ = shades;
  indices_ = indices;
  begins_.resize(count);
  reach_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t f = indices[i];
    const Ticks begin = fragments.t_begin[f], end = fragments.t_end[f];
    begins_[i] = event_key(begin, i);
    const float z = fragments.z[f];
    reach_[i] = {std::min(z, z + fragments.z_rate[f] * static_cast<float>(share_of(end - begin))), end};
  }
  sort_begins();
  next_ = 0;
  step_ = 0;
  active_.start(count);
  hidden_.clear();
  is_hidden_.assign(count, 0);
  front_limit_ = infinity;
  forget_hidden();
  surfaces_.start(count, sink_ != nullptr);
  merged_.start(count);
  merged_step_ = 0;
  pause_ = pauses_ = 0;
}

void PixelSweep::activate(std::uint32_t place, std::uint32_t f) {
  const std::uint32_t shade = fragments_->kernel[f];
  Member member = member_of(*fragments_, f, shades_[shade]);
  if (changes_.tolerances) {
    const Shade& of = shades_[shade];
    const auto at_open = static_cast<float>(changes_.later - of.t_mid);
    active_.tolerances.push_back({of.depth_tolerance + at_open * of.tolerance_rate, of.tolerance_rate});
  }
  if (changes_.of == nullptr) return active_.push(place, member);
  const ShadeChange& change = changes_.of[shade];
  const auto since = static_cast<float>(share_of(fragments_->t_begin[f]) + changes_.later - change.t_mid);
  for (std::size_t c = 0; c < 4; ++c) member[member_red + c] += since * change.rate[c];
  active_.push(place, member, change.rate);
}

/// By as many buckets of time as there are events, and within each: times are spread out more often than not.
void PixelSweep::sort_begins() {
  const auto count = static_cast<std::uint32_t>(begins_.size());
  const auto bucket_of = [&](std::uint64_t key) {
    const std::uint64_t bucket = (static_cast<std::uint64_t>(event_time(key)) * count) / shutter_close;
    return std::min(static_cast<std::uint32_t>(bucket), count - 1);
  };
  buckets_.assign(count + 1, 0);
  for (const std::uint64_t key : begins_) ++buckets_[bucket_of(key) + 1];
  for (std::uint32_t b = 0; b < count; ++b) buckets_[b + 1] += buckets_[b];
  by_bucket_.resize(count);
  for (const std::uint64_t key : begins_) by_bucket_[buckets_[bucket_of(key)]++] = key;
  // Now buckets_[b] is where bucket b ends. Keys of equal times are in order already.
  std::uint32_t first = 0;
  for (std::uint32_t b = 0; b < count; ++b) {
    if (buckets_[b] - first > 1) std::sort(by_bucket_.begin() + first, by_bucket_.begin() + buckets_[b]);
    first = buckets_[b];
  }
  begins_.swap(by_bucket_);
}

Ticks PixelSweep::next_begin() const { return next_ < begins_.size() ? event_time(begins_[next_]) : never; }

/// The first time to come at which something that is not hidden begins or ends. Hides on the way.
Ticks PixelSweep::next_event() {
  for (; next_ < begins_.size(); ++next_) {
    const std::uint32_t place = event_place(begins_[next_]);
    if (is_hidden_[place]) continue;
    if (!lies_behind(place)) break;
    hide(place);
  }
  Ticks next = next_begin();
  const float* const ends = active_.members.field(member_t_end);
  for (std::size_t i = 0; i < active_.members.size(); ++i)
    next = std::min(next, std::bit_cast<Ticks>(ends[i]));
  return next;
}

/// Makes active what begins before that time, or hides it.
void PixelSweep::admit(Ticks before) {
  for (; next_ < begins_.size() && event_time(begins_[next_]) < before; ++next_) {
    const std::uint32_t place = event_place(begins_[next_]);
    if (is_hidden_[place]) continue;
    if (lies_behind(place))
      hide(place);
    else
      activate(place, indices_[place]);
  }
}

/// Takes back what admit() let in too soon: what begins at or after that time.
void PixelSweep::withdraw(Ticks from) {
  while (active_.members.size() > 0 && active_.members.t_begin(active_.members.size() - 1) >= from)
    active_.pop();
  while (next_ > 0 && event_time(begins_[next_ - 1]) >= from) --next_;
}

/// What ends at or before that time goes.
void PixelSweep::let_go(Ticks time) {
  for (std::size_t i = active_.members.size(); i-- > 0;)
    if (active_.members.t_end(i) <= time) active_.remove(i);
}

bool PixelSweep::lies_behind(std::uint32_t place) const {
  return front_limit_ != infinity && reach_[place].least_depth > front_limit_;
}

void PixelSweep::hide(std::uint32_t place) {
  hidden_min_z_ = std::min(hidden_min_z_, reach_[place].least_depth);
  hidden_last_end_ = std::max(hidden_last_end_, reach_[place].end);
  hidden_.push_back(place);
  is_hidden_[place] = 1;
  ++counters_->hidden;
}

/// After an opaque piece that ends at `time`: puts aside what stays behind its surfaces for good.
void PixelSweep::hide_what_is_behind(float limit, Ticks time) {
  front_limit_ = limit;
  const float* const z = active_.members.field(member_z);
  for (std::size_t i = active_.members.size(); i-- > 0;) {
    if (!(z[i] > limit) || active_.members.t_end(i) <= time) continue;
    const std::uint32_t place = active_.place_of_slot[i];
    if (!lies_behind(place)) continue;
    active_.remove(i);
    hide(place);
  }
}

/// Takes back what was put aside, as of `time`.
void PixelSweep::reveal(Ticks time) {
  ++counters_->revealed;
  front_limit_ = infinity;
  withdraw(time + 1);
  // What began since the piece before this one is hidden, or it would have been an event: some has ended
  // again.
  while (next_ < begins_.size() && event_time(begins_[next_]) <= time) ++next_;
  const std::uint64_t to_come = next_ < begins_.size() ? begins_[next_] : ~std::uint64_t{0};
  for (const std::uint32_t place : hidden_) {
    const std::uint32_t f = indices_[place];
    is_hidden_[place] = 0;
    // What is still to come will be let in then.
    if (reach_[place].end > time && event_key(fragments_->t_begin[f], place) < to_come) activate(place, f);
  }
  forget_hidden();
}

/// What is hidden is no longer of interest.
void PixelSweep::forget_hidden() {
  hidden_.clear();
  hidden_min_z_ = infinity;
  hidden_last_end_ = 0;
}

/// Resolves one piece from `begin` on, up to the next event at least. Returns its end; `begin` itself if what
/// is hidden has to be looked at from there.
Ticks PixelSweep::advance(Ticks begin, PixelSum& pixel) {
  const Ticks latest = sink_ == nullptr ? shutter_close : sink_->end_after(begin);
  const Ticks event = std::min(next_event(), latest);
  if (active_.members.size() == 1 && step_ == 0 && hidden_.empty() && sink_ == nullptr) {
    ++counters_->intervals;
    ++counters_->evaluations;
    front_limit_ = infinity;
    add_lone(model_, active_.members, 0, begin, event, pixel,
             changes_.of == nullptr ? nullptr : active_.rates.front().data());
    return event;
  }
  Ticks end = step_ > 0 ? std::min(std::max(begin + step_, event), latest) : event;
  if (step_ > 0 && changes_.tolerances) end = active_.tolerances_last(begin, end);
  if (step_ > 0) admit(end);
  bool failed = false;
  while (step_ > 0) {
    counters_->evaluations += active_.members.size();
    if (changes_.tolerances) active_.set_tolerances(begin, end);
    Members members = active_.members.view();
    members.enough = model_.hard() ? std::numeric_limits<float>::min() : model_.edge_weight();
    FrontSum front = math_.front_over(members, begin, end);
    const Ticks longest = longest_step(front.fastest, front.range);
    Front kind = end - begin <= longest ? kind_of(front, end) : Front::too_long;
    if (sink_ != nullptr && !(front.limit < sink_->nearest())) kind = Front::other;
    if (kind == Front::covers || kind == Front::thin) {
      if (!hidden_.empty() && !(kind == Front::covers && front.opaque && front.limit < hidden_min_z_)) {
        reveal(begin);
        return begin;
      }
      add_front(front, kind, begin, end, pixel);
      ++counters_->intervals;
      if (end > event) ++counters_->merged;
      step_ = std::min(longest - longest / 8, (failed ? 1 : 2) * std::min(end - begin, shutter_close / 4));
      if (kind == Front::covers && front.opaque) {
        if (front.behind)
          hide_what_is_behind(front.limit + front.margin, end);
        else
          front_limit_ = front.limit + front.margin;
      } else {
        front_limit_ = infinity;
      }
      return end;
    }
    if (kind == Front::too_long)
      end = begin + longest;
    else if (kind == Front::other || end <= event)
      break;
    else if (kind == Front::unsettled)
      end = std::max(event, front.settled_until);
    else if (front.changes_at < end)
      // Where the nearest changes, others come into its reach or leave it, with all their weight.
      end = std::max(event, front.changes_at);
    else
      end = std::max(event, begin + (end - begin) / 2);
    failed = true;
    ++counters_->retried;
    withdraw(end);
  }
  withdraw(std::max(begin + 1, std::min(end, event)));
  return resolve_stack(begin, event, pixel);
}

/// How long a piece may be whose fastest kernel has that rate, and whose members differ that much.
Ticks PixelSweep::longest_step(float rate, float range) {
  const LikeMembers& like = like_members_of(range);
  if (rate != step_rate_ || &like != step_like_) {
    step_rate_ = rate;
    step_like_ = &like;
    // A quarter of what is allowed of colours that differ by more.
    const float piece = longest_piece(rate, like.reach * longest_front_span, model_.delta(),
                                      std::min(4.0f * like.range, 1.0f));
    longest_step_ = std::max(static_cast<Ticks>(piece * shutter_close), shortest_interval);
  }
  return longest_step_;
}

/// Whether the front is all that is seen over a piece, and its sums tell how much.
PixelSweep::Front PixelSweep::kind_of(FrontSum& front, Ticks end) const {
  if (front.settled_until < end) return Front::unsettled;
  if (front.mixed) return Front::other;
  // Nowhere clamped, so that its sums are its light.
  if (!model_.hard() && front.peaks <= model_.edge_weight()) return front.behind ? Front::other : Front::thin;
  const float weight = front.mean.weight;
  if (model_.hard() ? !(front.low > 0.0f) : front.low < model_.edge_weight())
    return weight < model_.edge_weight() ? Front::other : Front::too_varied;
  if (!few_enough(front)) return Front::too_varied;
  front.opaque = true;
  for (const float sign : {-1.0f, 1.0f}) {
    const SurfaceSum point = at_point(front.mean, front.swing, sign);
    // A line that falls that much is no likeness.
    if (!(point.weight > 0.25f * weight)) return Front::too_varied;
    if (1.0f - point.rgba[3] * model_.scale(point) > opaque_transmittance) front.opaque = false;
  }
  return front.behind && !front.opaque ? Front::other : Front::covers;
}

/// Where a front is as its piece begins and as it ends, by the line through its depths at Gauss's two points.
DepthSpan PixelSweep::span_of(const FrontSum& front) {
  const double mean = double{front.mean.depth} / double{front.mean.weight};
  const SurfaceSum before = at_point(front.mean, front.swing, -1.0f),
                   after = at_point(front.mean, front.swing, 1.0f);
  // A quotient of lines where there is next to nothing is no depth.
  const float least = 0.25f * front.mean.weight;
  if (!(before.weight > least && after.weight > least)) return {mean, mean};
  constexpr double half_of_root_three = 0.8660254037844386;
  const double change =
      half_of_root_three * (double{after.depth / after.weight} - before.depth / before.weight);
  return {mean - change, mean + change};
}

void PixelSweep::add_front(const FrontSum& front, Front kind, Ticks begin, Ticks end, PixelSum& pixel) const {
  if (sink_ != nullptr) {
    const MovingSurface line = MovingSurface::line(model_, front.mean, front.swing, span_of(front));
    sink_->piece(begin, end, {&line, 1});
    return;
  }
  const double duration = share_of(end - begin);
  float transmittance = 1.0f;
  DepthSpan whole{}, half{};
  if (pixel.by_depth != nullptr) whole = span_of(front);
  if (kind == Front::thin) {
    model_.add(front.mean, duration, transmittance, pixel, &whole);
    return;
  }
  for (const float sign : {-1.0f, 1.0f}) {
    transmittance = 1.0f;
    half = whole;
    (sign < 0.0f ? half.to : half.from) = 0.5 * (whole.from + whole.to);
    model_.add(at_point(front.mean, front.swing, sign), 0.5 * duration, transmittance, pixel, &half);
  }
}

/// Resolves a stack from `begin` to beyond the next event, and returns its end; `begin` itself if what is
/// hidden has to be looked at from there; or nothing where that cannot be done.
std::optional<Ticks> PixelSweep::resolve_merged(Ticks begin, Ticks event, PixelSum& pixel) {
  if (model_.hard() || sink_ != nullptr || changes_.of != nullptr || active_.members.size() < least_to_merge)
    return std::nullopt;
  if (pause_ > 0) {
    --pause_;
    return std::nullopt;
  }
  Ticks end = begin + merged_step_;
  if (merged_step_ == 0)
    end = next_ < begins_.size() ? event_time(begins_[std::min(next_ + first_merged, begins_.size() - 1)])
                                 : begin + 4 * std::min(event - begin, shutter_close / 16);
  end = std::min(end, shutter_close);
  bool failed = false;
  while (end > event) {
    admit(end);
    if (changes_.tolerances) {
      const Ticks same = std::max(active_.tolerances_last(begin, end), event);
      if (same < end) withdraw(end = same);
      if (end == event) break;
      active_.set_tolerances(begin, end);
    }
    const Ticks settled = merged_.build(active_, begin, end, pixel.by_depth != nullptr, *counters_);
    if (settled < end) {
      failed = true;
      ++counters_->retried;
      end = settled;
      withdraw(std::max(end, begin + 1));
      continue;
    }
    const bool opaque = merged_.opaque();
    if (!hidden_.empty() && !(opaque && merged_.limit() < hidden_min_z_)) {
      reveal(begin);
      return begin;
    }
    merged_.add_to(pixel);
    ++counters_->intervals;
    ++counters_->merged;
    pauses_ = 0;
    merged_step_ = std::min(merged_.longest() - merged_.longest() / 8,
                            (failed ? 1 : 2) * std::min(end - begin, shutter_close / 4));
    front_limit_ = infinity;
    if (opaque) hide_what_is_behind(merged_.limit() + merged_.margin(), end);
    step_ = merged_.one_covers() ? end - begin : 0;
    return end;
  }
  withdraw(std::max(begin + 1, std::min(end, event)));
  merged_step_ = 0;
  pause_ = pauses_ = std::min(2 * pauses_ + 1, longest_pause);
  return std::nullopt;
}

/// Resolves [begin, end], between two events, surface by surface; or up to the returned time if what is
/// hidden has to be looked at from there.
Ticks PixelSweep::resolve_stack(Ticks begin, Ticks end, PixelSum& pixel) {
  if (const std::optional<Ticks> merged = resolve_merged(begin, end, pixel)) return *merged;
  step_ = 0;
  while (begin < end) {
    Ticks piece_end = end;
    if (changes_.tolerances) {
      piece_end = active_.tolerances_last(begin, end);
      active_.set_tolerances(begin, piece_end);
    }
    piece_end = surfaces_.build(active_, begin, piece_end, *counters_);
    const bool opaque = surfaces_.opaque();
    if (!hidden_.empty() && !(opaque && surfaces_.limit() < hidden_min_z_)) {
      reveal(begin);
      return begin;
    }
    if (sink_ == nullptr)
      surfaces_.composite(begin, piece_end, pixel, *counters_);
    else
      surfaces_.hand_over(begin, piece_end, *sink_, *counters_);
    front_limit_ = infinity;
    if (opaque) hide_what_is_behind(surfaces_.limit() + surfaces_.margin(), piece_end);
    // The sums of a front know no colours that change.
    const bool known_by_sums =
        changes_.of == nullptr && (sink_ == nullptr || surfaces_.limit() < sink_->nearest());
    step_ = surfaces_.one_covers() && known_by_sums ? piece_end - begin : 0;
    begin = piece_end;
  }
  return end;
}

}  // namespace swept
