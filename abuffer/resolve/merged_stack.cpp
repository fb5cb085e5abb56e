#include "abuffer/resolve/merged_stack.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "abuffer/resolve/coverage_range.h"
#include "abuffer/resolve/ranking.h"
#include "abuffer/resolve/time_rule.h"

namespace swept {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// Of the light, how much all surfaces together may gain and lose at once within a piece. Of a step by j the
/// line leaves the variance j²/12 at most, and of a product of two that step together as much (sweep.cpp); if
/// steps of all surfaces go together, that is J²/24 for their sum J.
constexpr double most_jumps = 0.2;
/// And how much of the exposure that may be off by in one piece.
constexpr double jump_error = 0x1p-15;

/// Of what is between two gaps, how much may be resolved from event to event.
constexpr std::size_t most_apart = 16;

constexpr double root_of_third = 0.57735026918962573;

}  // namespace

void MergedStack::start(std::size_t places) {
  ranking_.clear();
  ranked_.assign(places, 0);
  part_.start(places);
  part_stack_.start(places, true);
}

Ticks MergedStack::from(std::uint32_t slot) const { return std::max(begin_, active_->members.t_begin(slot)); }
Ticks MergedStack::to(std::uint32_t slot) const { return std::min(end_, active_->members.t_end(slot)); }

Ticks MergedStack::build(const ActiveSet& active, Ticks begin, Ticks end, bool by_depth,
                         SweepCounters& counters) {
  active_ = &active;
  counters_ = &counters;
  begin_ = begin;
  end_ = end;
  by_depth_ = by_depth;
  light_ = {};
  light_.limit = -infinity;
  samples_.clear();
  instants_known_ = one_covers_ = false;
  const Members all = active.members.view();
  for (std::vector<float>* scratch :
       {&mean_, &swing_, &variation_, &jump_, &depth_, &depth_swing_, &z_from_, &z_to_, &at_begin_, &at_end_})
    if (scratch->size() < all.padded) scratch->resize(2 * all.padded);
  const PresenceRange range =
      math_.presences_over(all, begin, end,
                           {mean_.data(), swing_.data(), variation_.data(), jump_.data(), depth_.data(),
                            depth_swing_.data(), z_from_.data(), z_to_.data()});
  counters.evaluations += all.count;
  if (range.max_rate != rate_) {
    rate_ = range.max_rate;
    longest_ = longest_piece(rate_, longest_span, model_.delta());
  }
  const double duration = share_of(end - begin);
  if (duration > double{longest_}) return begin + longest();
  if (!(range.reach <= 1.0f)) return begin;
  margin_ = 2.0f * range.max_tolerance;

  rank();
  Ticks until = end;
  for (std::size_t first = 0, last = 0; first < ranking_.size() && !opaque(); first = last) {
    // Up to where nothing is within reach, wherever it is in the piece.
    float farthest = -infinity, reach = 0.0f;
    for (last = first; last < ranking_.size(); ++last) {
      const std::uint32_t slot = ranking_[last].slot;
      if (last > first && ranking_[last].z - farthest > reach) break;
      farthest = std::max({farthest, z_from_[slot], z_to_[slot]});
      reach = std::max(reach, active.members.field(member_tolerance)[slot]);
    }
    const Light before = light_;
    const Ticks together = resolve_together(first, last);
    if (together == end) continue;
    if (last - first <= most_apart) {
      light_ = before;
      samples_.resize(before.samples);
      resolve_apart(first, last);
      light_.limit = std::max(light_.limit, farthest);
    } else {
      until = std::min(until, together);
    }
  }
  if (until < end) return until;
  light_.limit += range.max_tolerance;
  if (light_.jumps > most_jumps || light_.jumps * light_.jumps * duration > 24.0 * jump_error)
    return begin + (end - begin) / 2;
  return end;
}

/// Puts ranking_ into the order of nearest depth, then of place.
void MergedStack::rank() {
  const auto nearest = [&](std::uint32_t slot) { return std::min(z_from_[slot], z_to_[slot]); };
  (void)renew(*active_, nearest, ranking_, ranked_);
  const auto nearer = [](const RankedMember& a, const RankedMember& b) {
    return a.z != b.z ? a.z < b.z : a.place < b.place;
  };
  // What is out of order is moved up one by one, unless it is much.
  std::size_t moves = 8 * ranking_.size();
  for (std::size_t i = 1; i < ranking_.size(); ++i) {
    if (!nearer(ranking_[i], ranking_[i - 1])) continue;
    const RankedMember moved = ranking_[i];
    std::size_t k = i;
    for (; k > 0 && nearer(moved, ranking_[k - 1]); --k) ranking_[k] = ranking_[k - 1];
    ranking_[k] = moved;
    if (i - k > moves) return std::sort(ranking_.begin(), ranking_.end(), nearer);
    moves -= i - k;
  }
}

/// Resolves ranking_[first, last) surface by surface, each over the whole piece. Returns `end_`, or the
/// sooner time until which they may keep their members.
Ticks MergedStack::resolve_together(std::size_t first, std::size_t last) {
  Ticks until = end_;
  rest_.clear();
  for (std::size_t i = first; i < last; ++i) rest_.push_back(ranking_[i].slot);
  while (!rest_.empty() && !opaque()) {
    until = split(rest_.front(), until);
    if (!add_surface()) until = std::min(until, begin_ + (end_ - begin_) / 2);
    rest_.swap(behind_);
  }
  return until;
}

/// Of rest_ puts into surface_ what is of one surface with its first, the leader, and into behind_ what lies
/// behind, in order. Returns `until` or the sooner time until which that holds all along.
Ticks MergedStack::split(std::uint32_t leader, Ticks until) {
  const float* const slopes = active_->members.field(member_z_rate);
  const float* const tolerances = active_->members.field(member_tolerance);
  surface_.clear();
  behind_.clear();
  surface_.push_back(leader);
  const Ticks born = from(leader), dies = to(leader);
  if (born > begin_) until = std::min(until, born);
  if (dies < end_) until = std::min(until, dies);
  const float z = z_from_[leader], slope = slopes[leader], tolerance = tolerances[leader];
  const bool sides_differ = active_->shows_both_sides();
  const Side side = active_->side(leader);
  // As if it were there all the time.
  const float at_begin = z - slope * static_cast<float>(share_of(born - begin_));
  const float at_end = z_to_[leader] + slope * static_cast<float>(share_of(end_ - dies));
  const float farthest = std::max(at_begin, at_end) + tolerance;
  for (std::size_t i = 1; i < rest_.size(); ++i) {
    const std::uint32_t k = rest_[i];
    if (std::min(z_from_[k], z_to_[k]) > farthest) {
      behind_.insert(behind_.end(), rest_.begin() + static_cast<std::ptrdiff_t>(i), rest_.end());
      break;
    }
    const Ticks begins = from(k), ends = to(k);
    const float after_from = z_from_[k] - (z + slope * static_cast<float>(share_of(begins - born)));
    const float after_to = z_to_[k] - (z + slope * static_cast<float>(share_of(ends - born)));
    const bool other = sides_differ && both_sides(side, active_->side(k));
    bool nearer = after_from < 0.0f || after_to < 0.0f;
    // Of equally near ones it matters which leads.
    if (!nearer && (after_from == 0.0f || after_to == 0.0f))
      nearer = tolerances[k] != tolerance || active_->side(k) != side;
    const bool within = after_from <= tolerance && after_to <= tolerance;
    const bool beyond = after_from >= tolerance && after_to >= tolerance;
    if (nearer || (!within && !beyond && !other)) {
      // A crossing, unless it is nearer from its beginning on, or up to its end.
      Ticks sooner = begin_ + (end_ - begin_) / 2;
      if (nearer && begins > begin_)
        sooner = begins;
      else if (nearer && ends < end_ && begins <= begin_)
        sooner = std::min(sooner, ends);
      until = std::min(until, sooner);
    }
    (within && !other ? surface_ : behind_).push_back(k);
  }
  return until;
}

/// Sums up surface_ and puts it behind what is there. False: where its coverage is clamped cannot be told.
bool MergedStack::add_surface() {
  const Members all = active_->members.view();
  const float* const peaks = all.field(member_peak);
  SurfaceSum mean, swing;
  float variation = 0.0f, sum_of_peaks = 0.0f, jumps = 0.0f;
  using Color = float __attribute__((vector_size(16)));
  Color color = {}, color_swing = {};
  for (const std::uint32_t k : surface_) {
    Color rgba;
    std::memcpy(&rgba, &active_->colors[k], sizeof rgba);
    mean.weight += mean_[k];
    swing.weight += swing_[k];
    color += mean_[k] * rgba;
    color_swing += swing_[k] * rgba;
    mean.depth += depth_[k];
    swing.depth += depth_swing_[k];
    variation += variation_[k];
    sum_of_peaks += peaks[k];
    jumps += jump_[k];
    light_.limit = std::max({light_.limit, z_from_[k], z_to_[k]});
  }
  std::memcpy(mean.rgba, &color, sizeof color);
  std::memcpy(swing.rgba, &color_swing, sizeof color_swing);
  if (!settled(mean.weight, variation, sum_of_peaks, jumps)) return false;
  light_.jumps += double{jumps} / double{std::max(model_.edge_weight(), mean.weight)};

  double from = 0.0, to = 0.0, weight = 0.0;
  if (by_depth_)
    for (const std::uint32_t k : surface_) {
      const double of_member = std::max(double{mean_[k]}, 1e-30);
      weight += of_member;
      from += of_member * double{z_from_[k]};
      to += of_member * double{z_to_[k]};
    }
  // Weights below the normal numbers weigh nothing.
  if (!(mean.weight >= std::numeric_limits<float>::min())) return true;
  const double middle = double{mean.depth} / double{mean.weight};
  for (int point = 0; point < 2; ++point) {
    // Where a member is there for a part of the piece only, its line may be below zero at one of the points.
    // It has to stay that, for sums and products to be right in the mean.
    const SurfaceSum sum = at_point(mean, swing, point == 0 ? -1.0f : 1.0f);
    const float factor = 1.0f / std::max(sum.weight, model_.edge_weight());
    const double left = light_.left[point];
    const float alpha = std::min(sum.rgba[3] * factor, 1.0f);
    const float of_color = model_.per_pixel() ? 1.0f : factor;
    for (int c = 0; c < 3; ++c) light_.color[point][c] += left * double{sum.rgba[c] * of_color};
    if (model_.per_pixel()) light_.opacity[point] += left * double{sum.rgba[3]};
    // A quotient of lines where there is next to nothing is no depth.
    const double z = sum.weight > 0.25f * mean.weight ? double{sum.depth / sum.weight} : middle;
    light_.depth[point] += left * (double{alpha} * z);
    if (by_depth_) {
      Sample sample{{from / weight, to / weight}, {0.0, 0.0, 0.0, left * double{alpha}}};
      (point == 0 ? sample.span.to : sample.span.from) = 0.5 * (from + to) / weight;
      for (int c = 0; c < 3; ++c) sample.rgba[c] = left * double{sum.rgba[c] * factor};
      samples_.push_back(sample);
      light_.samples = samples_.size();
    }
    light_.left[point] *= 1.0 - double{alpha};
  }
  return true;
}

/// Whether the mean weight of surface_ tells how much of it is clamped. As SurfaceStack::measure() does.
bool MergedStack::settled(float weight, float variation, float peaks, float jumps) {
  const float edge = model_.edge_weight();
  const bool first = light_.left[0] == 1.0 && light_.left[1] == 1.0;
  CoverageRange range = CoverageRange::of_members(weight, variation, peaks);
  if (range.covers(edge) && first) one_covers_ = true;
  if (range.covers(edge) || range.linear(edge)) return true;
  const double duration = share_of(end_ - begin_);
  if (3.0 * double{variation} * duration <= CoverageRange::most_spread(edge)) return true;
  const Members all = active_->members.view();
  if (!instants_known_) {
    (void)math_.sum_over(all, begin_, begin_, at_begin_.data());
    (void)math_.sum_over(all, end_, end_, at_end_.data());
    instants_known_ = true;
  }
  float at_begin = 0.0f, at_end = 0.0f;
  for (const std::uint32_t k : surface_) {
    if (from(k) == begin_) at_begin += at_begin_[k];
    if (to(k) == end_) at_end += at_end_[k];
  }
  // The steps are on top of what a parabola can tell.
  range = CoverageRange::of_parabola(at_begin, weight, at_end);
  range = {range.low - jumps, range.high + jumps};
  if (range.covers(edge) && first) one_covers_ = true;
  return range.settled(edge, duration);
}

/// Resolves ranking_[first, last) from event to event, and puts it behind what is there as one.
void MergedStack::resolve_apart(std::size_t first, std::size_t last) {
  const Members all = active_->members.view();
  events_.assign({begin_, end_});
  to_come_.clear();
  for (std::size_t i = first; i < last; ++i) {
    const std::uint32_t k = ranking_[i].slot;
    events_.push_back(from(k));
    events_.push_back(to(k));
    to_come_.push_back(k);
  }
  std::sort(events_.begin(), events_.end());
  const auto place = [&](std::uint32_t k) { return active_->place_of_slot[k]; };
  std::sort(to_come_.begin(), to_come_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return from(a) != from(b) ? from(a) < from(b) : place(a) < place(b);
  });
  mean_look_ = swing_look_ = {};
  double alpha_before = -1.0;
  const auto step_to = [&](double alpha) {
    if (alpha_before >= 0.0) light_.jumps += std::abs(alpha - alpha_before);
  };
  std::size_t next = 0;
  for (std::size_t e = 0; e + 1 < events_.size(); ++e) {
    Ticks now = events_[e];
    const Ticks until = events_[e + 1];
    if (now == until) continue;
    for (std::size_t i = part_.members.size(); i-- > 0;)
      if (part_.members.t_end(i) <= now) part_.remove(i);
    for (; next < to_come_.size() && from(to_come_[next]) <= now; ++next) {
      const std::uint32_t k = to_come_[next];
      Member member;
      for (std::size_t f = 0; f < member_fields; ++f) member[f] = all.data[f * all.stride + k];
      part_.push(place(k), member);
    }
    if (part_.members.size() == 0) {
      step_to(0.0);
      alpha_before = 0.0;
      continue;
    }
    while (now < until) {
      const Ticks piece_end = part_stack_.build(part_, now, until, *counters_);
      StackLook looks[2];
      part_stack_.look(looks);
      look_behind(looks, now, piece_end);
      const double mean = 0.5 * (looks[0].alpha + looks[1].alpha);
      const double half = 0.5 / root_of_third * (looks[1].alpha - looks[0].alpha);
      step_to(mean - half);
      alpha_before = mean + half;
      now = piece_end;
    }
  }
  while (part_.members.size() > 0) part_.pop();

  for (int point = 0; point < 2; ++point) {
    const double sign = point == 0 ? -1.0 : 1.0, left = light_.left[point];
    const auto value = [&](double StackLook::*of) { return mean_look_.*of + sign * swing_look_.*of; };
    const double alpha = std::min(value(&StackLook::alpha), 1.0);
    double color[3];
    for (int c = 0; c < 3; ++c) color[c] = left * (mean_look_.color[c] + sign * swing_look_.color[c]);
    for (int c = 0; c < 3; ++c) light_.color[point][c] += color[c];
    light_.depth[point] += left * value(&StackLook::depth);
    light_.opacity[point] += left * value(&StackLook::opacity);
    if (by_depth_ && alpha > 0.0) {
      const double z = value(&StackLook::depth) / alpha;
      samples_.push_back({{z, z}, {color[0], color[1], color[2], left * alpha}});
      light_.samples = samples_.size();
    }
    light_.left[point] *= 1.0 - alpha;
  }
}

/// Adds what is seen over [begin, end] to the line over the whole piece.
void MergedStack::look_behind(const StackLook (&looks)[2], Ticks begin, Ticks end) {
  const double per_piece = 1.0 / static_cast<double>(end_ - begin_);
  const double share = static_cast<double>(end - begin) * per_piece;
  const double middle =
      0.5 * (static_cast<double>(begin - begin_) - static_cast<double>(end_ - end)) * per_piece;
  for (int point = 0; point < 2; ++point) {
    const StackLook& look = looks[point];
    const double weight = 0.5 * share;
    const double moment =
        6.0 * root_of_third * weight * (middle + (point == 0 ? -0.5 : 0.5) * root_of_third * share);
    for (int c = 0; c < 3; ++c) {
      mean_look_.color[c] += weight * look.color[c];
      swing_look_.color[c] += moment * look.color[c];
    }
    for (double StackLook::*of : {&StackLook::alpha, &StackLook::depth, &StackLook::opacity}) {
      mean_look_.*of += weight * look.*of;
      swing_look_.*of += moment * look.*of;
    }
  }
}

void MergedStack::add_to(PixelSum& pixel) const {
  const double duration = 0.5 * share_of(end_ - begin_);
  for (int point = 0; point < 2; ++point) {
    for (int c = 0; c < 3; ++c) pixel.rgba[c] += duration * light_.color[point][c];
    pixel.rgba[3] += duration * (1.0 - light_.left[point]);
    pixel.depth += duration * light_.depth[point];
    pixel.opacity += duration * light_.opacity[point];
  }
  if (pixel.by_depth == nullptr) return;
  for (const Sample& sample : samples_) {
    double rgba[4];
    for (int c = 0; c < 4; ++c) rgba[c] = duration * sample.rgba[c];
    pixel.by_depth->add(sample.span.from, sample.span.to, rgba);
  }
}

}  // namespace swept
