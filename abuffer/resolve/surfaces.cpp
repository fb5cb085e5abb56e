#include "abuffer/resolve/surfaces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "abuffer/resolve/ranking.h"
#include "abuffer/resolve/time_rule.h"

namespace swept {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// How much of its opacity a fragment may gain or lose in one piece. A product of n that all change by so
/// much is of degree n, and what Gauss's two points miss of it is of the fourth power.
constexpr float most_fading = 0.125f;

}  // namespace

void SurfaceStack::start(std::size_t places, bool apart) {
  apart_ = apart;
  ranking_.clear();
  ranked_.assign(places, 0);
}

Ticks ActiveSet::tolerances_last(Ticks begin, Ticks end) const {
  // Of few each is much of the picture, and they are soon resolved.
  const float most_change = static_cast<float>(std::min<std::size_t>(tolerances.size(), 64)) / 4096.0f;
  const auto from = static_cast<float>(share_of(begin));
  const auto capped = [&](float fastest) {
    const auto longest = static_cast<Ticks>(static_cast<double>(shutter_close) *
                                            std::min(1.0, most_change / std::max(double{fastest}, 1e-9)));
    return std::min(end, begin + std::max(longest, shortest_interval));
  };
  const auto at_least = [&](const Tolerance& t) {
    return std::max(t.at_zero + from * t.rate, 1e-3f * std::abs(t.rate));
  };
  // Mostly none is too fast even for the smallest, which is told without a quotient each.
  float most_rate = 0.0f, least = infinity;
  for (const Tolerance& t : tolerances) {
    most_rate = std::max(most_rate, std::abs(t.rate));
    if (t.rate != 0.0f) least = std::min(least, at_least(t));
  }
  if (capped(most_rate / least) == end) return end;
  float fastest = 0.0f;
  for (const Tolerance& t : tolerances) fastest = std::max(fastest, std::abs(t.rate) / at_least(t));
  return capped(fastest);
}

void ActiveSet::set_tolerances(Ticks begin, Ticks end) {
  const auto middle = static_cast<float>(share_of(begin + (end - begin) / 2));
  for (std::size_t slot = 0; slot < tolerances.size(); ++slot)
    members.set(member_tolerance, slot,
                std::max(0.0f, tolerances[slot].at_zero + middle * tolerances[slot].rate));
}

Ticks SurfaceStack::build(const ActiveSet& active, Ticks begin, Ticks end, SweepCounters& counters) {
  active_ = &active;
  counters_ = &counters;
  in_order_ = false;
  const Members all = active.members.view();
  for (std::vector<float>* scratch :
       {&z_begin_, &z_end_, &from_, &to_, &slope_, &tolerance_, &behind_to_, &mean_, &swing_, &variation_,
        &depth_, &depth_swing_, &at_begin_, &at_end_})
    if (scratch->size() < all.padded + 1) scratch->resize(2 * all.padded + 1);
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
  const Members all = active_->members.view();
  const std::size_t count = all.count;
  surfaces_.clear();
  transmittance_ = 1.0f;
  instants_known_ = false;

  const DepthRange range = math_.depths_over(all, begin, end, z_begin_.data(), z_end_.data());
  margin_ = 2.0f * range.max_tolerance;
  float longest = longest_piece(range.max_rate, longest_span, model_.delta());
  for (const std::array<float, 4>& rate : active_->rates)
    if (std::abs(rate[3]) * longest > most_fading) longest = most_fading / std::abs(rate[3]);
  const auto duration = static_cast<float>(share_of(end - begin));
  if (duration > longest) {
    const Ticks cut = shorten(begin, end, longest / duration);
    if (cut < end) return cut;
  }
  // A member's height above the lower envelope of all is convex in time, so it is largest at an end.
  if (!active_->shows_both_sides() && range.max_begin - range.min_begin <= range.min_tolerance &&
      range.max_end - range.min_end <= range.min_tolerance) {
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0u);
    in_order_ = false;
    weigh(begin, end);
    limit_ = std::max(range.max_begin, range.max_end) + range.max_tolerance;
    const Ticks sooner = measure(next_surface(0, count), begin, end);
    take_light();
    return sooner;
  }

  if (!in_order_) rank();
  float nearest_behind = behind_to_[count] = infinity;
  for (std::size_t i = count; i-- > 0;) {
    const float to = to_[i] = z_end_[order_[i]];
    behind_to_[i] = nearest_behind = std::min(nearest_behind, to);
  }
  weigh(begin, end);
  if (range.max_tolerance == 0.0f && !apart_ && stand_alone(begin, end)) return end;
  limit_ = -infinity;
  Ticks until = end;
  for (std::size_t first = 0; first < count && transmittance_ > opaque_transmittance;) {
    const std::size_t last = gather_nearest(first, begin, until);
    Surface& surface = next_surface(first, last);
    // What is behind may change sooner, but this surface's own shortening comes first: where it begins to
    // cover, nothing behind is seen.
    const Ticks sooner = measure(surface, begin, end);
    if (sooner < end) return std::min(sooner, until);
    take_light();
    for (; first < last; ++first) limit_ = std::max({limit_, from_[first], to_[first]});
  }
  limit_ += range.max_tolerance;
  return until;
}

/// Whether every member is a surface by itself, all the time, and some light gets past them all; then they
/// are alone_'s layers.
bool SurfaceStack::stand_alone(Ticks begin, Ticks end) {
  const Members all = active_->members.view();
  const float *peaks = all.field(member_peak), *slopes = all.field(member_z_rate);
  const float edge = model_.edge_weight();
  if (model_.per_pixel()) return false;
  alone_.layers.clear();
  float light = 1.0f;
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const std::uint32_t k = order_[i];
    // Equal ones are one surface.
    if (i > 0 && z_begin_[k] == z_begin_[order_[i - 1]] && slopes[k] == slopes[order_[i - 1]]) return false;
    const bool thin = !model_.hard() && peaks[k] <= edge;
    const bool covers =
        model_.hard() ? mean_[k] >= std::numeric_limits<float>::min() : mean_[k] - variation_[k] >= edge;
    if (!thin && !covers) return false;
    AloneLayer layer;
    for (std::size_t c = 0; c < 4; ++c) {
      layer.mean[c] = thin ? mean_[k] / edge * active_->colors[k][c] : active_->colors[k][c];
      layer.swing[c] = thin ? swing_[k] / edge * active_->colors[k][c] : 0.0f;
    }
    if (!active_->rates.empty()) {
      const LightOver of_piece = light_over(k, begin, end);
      for (std::size_t c = 0; c < 4; ++c) {
        layer.mean[c] =
            thin ? (mean_[k] * of_piece.mean[c] + swing_[k] * of_piece.swing[c]) / edge : of_piece.mean[c];
        layer.swing[c] =
            thin ? (swing_[k] * of_piece.mean[c] + mean_[k] * of_piece.swing[c]) / edge : of_piece.swing[c];
      }
    }
    layer.z_begin = z_begin_[k];
    layer.z_end = z_end_[k];
    light *= 1.0f - layer.mean[3];
    alone_.layers.push_back(layer);
  }
  return light > opaque_transmittance;
}

/// Its sums are add_up()'s to fill in.
SurfaceStack::Surface& SurfaceStack::next_surface(std::size_t first, std::size_t last) {
  Surface& surface = surfaces_.emplace_back();
  surface.first = first;
  surface.last = last;
  return surface;
}

/// What the last surface leaves of it.
void SurfaceStack::take_light() {
  const SurfaceSum& sum = surfaces_.back().mean;
  transmittance_ *= 1.0f - std::min(1.0f, sum.rgba[3] * model_.scale(sum));
}

/// Puts order_ into the order of depth as the piece begins; among equals the one that will be nearest, then
/// by side, then the one that reaches farthest, then by place. From one piece to the next few change places.
void SurfaceStack::rank() {
  const float* const rates = active_->members.field(member_z_rate);
  const float* const tolerances = active_->members.field(member_tolerance);
  const std::size_t kept = renew(
      *active_, [&](std::uint32_t slot) { return z_begin_[slot]; }, ranking_, ranked_);
  const auto nearer = [&](const RankedMember& a, const RankedMember& b) {
    if (a.z != b.z) return a.z < b.z;
    if (rates[a.slot] != rates[b.slot]) return rates[a.slot] < rates[b.slot];
    if (const int s = rank_of(active_->side(a.slot)), t = rank_of(active_->side(b.slot)); s != t)
      return s < t;
    if (tolerances[a.slot] != tolerances[b.slot]) return tolerances[a.slot] > tolerances[b.slot];
    return a.place < b.place;
  };
  if (ranking_.size() - kept > 12) {
    std::sort(ranking_.begin(), ranking_.end(), nearer);
  } else {
    for (std::size_t i = 1; i < ranking_.size(); ++i) {
      if (ranking_[i].z > ranking_[i - 1].z) continue;
      const RankedMember moved = ranking_[i];
      std::size_t k = i;
      for (; k > 0 && nearer(moved, ranking_[k - 1]); --k) ranking_[k] = ranking_[k - 1];
      ranking_[k] = moved;
    }
  }
  order_.resize(ranking_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const std::uint32_t slot = order_[i] = ranking_[i].slot;
    from_[i] = ranking_[i].z;
    slope_[i] = rates[slot];
    tolerance_[i] = tolerances[slot];
  }
  slowest_ = *std::min_element(rates, rates + active_->members.size());
  in_order_ = true;
}

/// Each member's ρ over the piece: its mean, its swing about it, and how far it may fall below it.
void SurfaceStack::weigh(Ticks begin, Ticks end) {
  const Members all = active_->members.view();
  (void)math_.sum_over(all, begin, end, mean_.data());
  counters_->evaluations += all.count;
  math_.swings_over(
      all, begin, end, mean_.data(),
      {z_begin_.data(), z_end_.data(), swing_.data(), variation_.data(), depth_.data(), depth_swing_.data()});
}

/// Returns the end of the surface that is nearest just after `begin` and whose members are order_[first, …).
/// Shortens `end` to the time until which they are its members.
std::size_t SurfaceStack::gather_nearest(std::size_t first, Ticks begin, Ticks& end) {
  const std::size_t count = order_.size();
  const float limit = from_[first] + tolerance_[first];

  std::size_t reached = first;
  while (reached < count &&
         (from_[reached] < limit || (from_[reached] == limit && slope_[reached] <= slope_[first])))
    ++reached;
  // One by itself, and nothing comes near it.
  if (reached == first + 1 && (reached == count || (from_[reached] - from_[first] > tolerance_[first] &&
                                                    behind_to_[reached] - to_[first] > tolerance_[first])))
    return reached;
  const std::size_t last = active_->shows_both_sides() ? part_sides(first, reached) : reached;

  // If no member is out of reach of the lower envelope at either end, none leaves between; and what lies
  // beyond reach of one and the same member at both ends stays behind.
  std::size_t nearest_at_end = first;
  float smallest = infinity, largest = 0.0f, farthest_end = -infinity;
  for (std::size_t i = first; i < last; ++i) {
    if (to_[i] < to_[nearest_at_end]) nearest_at_end = i;
    smallest = std::min(smallest, tolerance_[i]);
    largest = std::max(largest, tolerance_[i]);
    farthest_end = std::max(farthest_end, to_[i]);
  }
  // Nor does it matter which of the members leads, if all of them have the same for their other side.
  const bool leads_alike = last == reached ? !both_among(first, reached) : alike(first, last);
  const bool none_leaves =
      from_[last - 1] - from_[first] <= smallest && farthest_end - to_[nearest_at_end] <= smallest;
  const auto all_beyond = [&](std::size_t of) {
    // Of those on the other side it is enough that they are not nearer.
    for (std::size_t i = last; i < reached; ++i)
      if (from_[i] < from_[of] || to_[i] < to_[of]) return false;
    return reached == count ||
           (from_[reached] - from_[of] > largest && behind_to_[reached] - to_[of] > largest);
  };
  if (leads_alike && none_leaves && (all_beyond(first) || all_beyond(nearest_at_end))) return last;

  // Otherwise until the nearest is overtaken, or something comes within its tolerance or leaves it.
  const double duration = share_of(end - begin);
  const double wait = wait_for_change(first, last, reached, duration);
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

/// Whether order_[first, last) shows fronts and backs.
bool SurfaceStack::both_among(std::size_t first, std::size_t last) const {
  if (!active_->shows_both_sides()) return false;
  std::uint32_t sides = 0;
  for (std::size_t i = first; i < last; ++i) sides |= static_cast<std::uint32_t>(active_->side(order_[i]));
  return both_sides(sides);
}

/// Whether all of order_[first, last) show the same, or are all of unknown side.
bool SurfaceStack::alike(std::size_t first, std::size_t last) const {
  for (std::size_t i = first + 1; i < last; ++i)
    if (active_->side(order_[i]) != active_->side(order_[first])) return false;
  return true;
}

/// Of order_[first, last) puts what shows the other side than its first behind the rest, both in their order,
/// and returns where it begins.
std::size_t SurfaceStack::part_sides(std::size_t first, std::size_t last) {
  const Side nearest = active_->side(order_[first]);
  const auto same = [&](std::size_t i) { return !both_sides(active_->side(order_[i]), nearest); };
  std::size_t kept = first;
  while (kept < last && same(kept)) ++kept;
  if (kept == last) return last;
  others_.clear();
  for (std::size_t i = kept; i < last; ++i) {
    if (!same(i)) {
      others_.push_back({order_[i], from_[i], to_[i], slope_[i], tolerance_[i]});
      continue;
    }
    order_[kept] = order_[i];
    from_[kept] = from_[i];
    to_[kept] = to_[i];
    slope_[kept] = slope_[i];
    tolerance_[kept] = tolerance_[i];
    ++kept;
  }
  for (std::size_t i = kept; i < last; ++i) {
    const Placed& other = others_[i - kept];
    order_[i] = other.slot;
    from_[i] = other.from;
    to_[i] = other.to;
    slope_[i] = other.slope;
    tolerance_[i] = other.tolerance;
  }
  for (std::size_t i = last; i-- > first;) behind_to_[i] = std::min(behind_to_[i + 1], to_[i]);
  in_order_ = false;
  return kept;
}

/// After how long the surface order_[first, last) has other members, or `duration`. Up to `reached` lies what
/// is within its reach and shows the other side.
double SurfaceStack::wait_for_change(std::size_t first, std::size_t last, std::size_t reached,
                                     double duration) const {
  const float tolerance = tolerance_[first];
  double wait = duration;
  for (std::size_t i = first + 1; i < order_.size(); ++i) {
    const float above = from_[i] - from_[first];
    // From here on nothing is fast enough.
    if (i >= reached && double{above - tolerance} > (double{slope_[first]} - slowest_) * wait) break;
    const float rate = slope_[i] - slope_[first];
    if (i < last && rate > 0.0f)
      wait = std::min(wait, double{tolerance - above} / rate);
    else if (rate < 0.0f)
      wait = std::min(wait, double{i < reached ? above : above - tolerance} / -rate);
  }
  return wait;
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

}  // namespace swept
