// What is seen of the surfaces that a stack has found: their sums over a piece, and those over one another.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "abuffer/resolve/coverage_range.h"
#include "abuffer/resolve/surfaces.h"
#include "abuffer/resolve/time_rule.h"

namespace swept {
namespace {

constexpr float per_root_three = 0.57735026919f;

using Color = float __attribute__((vector_size(16)));

}  // namespace

SurfaceStack::LightOver SurfaceStack::light_over(std::size_t slot, Ticks begin, Ticks end) const {
  const auto half = static_cast<float>(0.5 * share_of(end - begin));
  const float since = static_cast<float>(share_of(begin - active_->members.t_begin(slot))) + half;
  LightOver light;
  for (std::size_t c = 0; c < 4; ++c) {
    const float rate = active_->rates[slot][c];
    light.mean[c] = active_->colors[slot][c] + since * rate;
    light.swing[c] = per_root_three * half * rate;
  }
  return light;
}

void SurfaceStack::add_up(Surface& surface, Ticks begin, Ticks end) const {
  const Members all = active_->members.view();
  const float *peaks = all.field(member_peak), *rates = all.field(member_rate);
  const std::array<float, 4>* const colors = active_->colors.data();
  // Sums stay in registers and are written once, each as it will be read: a vector that is read back from
  // floats just written has to wait for them.
  Color color = {}, color_swing = {};
  float weight = 0.0f, weight_swing = 0.0f, depth = 0.0f, depth_swing = 0.0f;
  float variation = 0.0f, sum_of_peaks = 0.0f, fastest = 0.0f;
  const std::uint32_t* const order = order_.data();
  const float *const means = mean_.data(), *const swings = swing_.data();
  const bool changing = !active_->rates.empty();
  for (std::size_t i = surface.first, last = surface.last; i < last; ++i) {
    const std::uint32_t k = order[i];
    Color rgba;
    std::memcpy(&rgba, &colors[k], sizeof rgba);
    weight += means[k];
    weight_swing += swings[k];
    if (!changing) {
      color += means[k] * rgba;
      color_swing += swings[k] * rgba;
    } else {
      // The mean of ρ times what is linear is that of both means and of both swings; ρ's own bend is left out
      // of the product's swing.
      const LightOver light = light_over(k, begin, end);
      Color of_light, light_swing;
      std::memcpy(&of_light, &light.mean, sizeof of_light);
      std::memcpy(&light_swing, &light.swing, sizeof light_swing);
      color += means[k] * of_light + swings[k] * light_swing;
      color_swing += swings[k] * of_light + means[k] * light_swing;
    }
    depth += depth_[k];
    depth_swing += depth_swing_[k];
    variation += variation_[k];
    sum_of_peaks += peaks[k];
    fastest = std::max(fastest, rates[k]);
  }
  surface.mean.weight = weight;
  std::memcpy(surface.mean.rgba, &color, sizeof color);
  surface.mean.depth = depth;
  surface.swing.weight = weight_swing;
  std::memcpy(surface.swing.rgba, &color_swing, sizeof color_swing);
  surface.swing.depth = depth_swing;
  surface.variation = variation;
  surface.peaks = sum_of_peaks;
  surface.widest = fastest * static_cast<float>(share_of(end - begin));
}

/// Sums a surface over [begin, end]. Returns `end`, or the sooner time to which the piece has to be shortened
/// for its mean weight to tell how much of it is clamped.
Ticks SurfaceStack::measure(Surface& surface, Ticks begin, Ticks end) {
  add_up(surface, begin, end);
  const float edge = model_.edge_weight(), weight = surface.mean.weight;
  CoverageRange range = CoverageRange::of_members(weight, surface.variation, surface.peaks);
  surface.linear = !model_.hard() && range.linear(edge);
  surface.covers = model_.hard() || range.covers(edge);
  if (surface.linear || surface.covers) return end;
  if (surface.widest > longest_span) {
    const Ticks cut = shorten(begin, end, 0.99f * longest_span / surface.widest);
    if (cut < end) return cut;
  }

  if (!instants_known_) {
    const Members all = active_->members.view();
    (void)math_.sum_over(all, begin, begin, at_begin_.data());
    (void)math_.sum_over(all, end, end, at_end_.data());
    instants_known_ = true;
  }
  float at_begin = 0.0f, at_end = 0.0f;
  for (std::size_t i = surface.first; i < surface.last; ++i) {
    at_begin += at_begin_[order_[i]];
    at_end += at_end_[order_[i]];
  }
  range = CoverageRange::of_parabola(at_begin, weight, at_end);
  surface.linear = range.linear(edge);
  surface.covers = range.covers(edge);
  if (range.settled(edge, share_of(end - begin))) return end;
  // Where a straight line between the ends crosses the clamp, or in the middle if they lie on one side of it.
  const bool crosses = (at_begin < edge) != (at_end < edge);
  return shorten(begin, end,
                 crosses ? std::clamp((edge - at_begin) / (at_end - at_begin), 0.1f, 0.9f) : 0.5f);
}

void SurfaceStack::composite(Ticks begin, Ticks end, PixelSum& pixel, SweepCounters& counters) {
  ++counters.intervals;
  const double duration = share_of(end - begin);
  if (surfaces_.empty()) {
    alone_.composite(duration, pixel);
    return;
  }
  if (surfaces_.size() == 1 && surfaces_.front().linear) {
    float transmittance = 1.0f;
    const DepthSpan span = pixel.by_depth != nullptr ? span_of(surfaces_.front()) : DepthSpan{};
    model_.add(surfaces_.front().mean, duration, transmittance, pixel, &span);
    return;
  }
  // Of several surfaces the light that one lets through and what the next one covers change together, and the
  // product of their means is not the mean of their product.
  // Chosen once: branches within the loop take a third of its time.
  const auto add = model_.per_pixel()
                       ? (pixel.by_depth != nullptr ? &SurfaceStack::add_both_points<true, true>
                                                    : &SurfaceStack::add_both_points<true, false>)
                       : (pixel.by_depth != nullptr ? &SurfaceStack::add_both_points<false, true>
                                                    : &SurfaceStack::add_both_points<false, false>);
  (this->*add)(0.5 * duration, pixel);
}

/// What SurfaceModel::add() does for each surface at either of Gauss's points, a share `duration` of the
/// exposure each: both at once, for neither has to wait for the other.
template <bool per_pixel, bool by_depth>
void SurfaceStack::add_both_points(double duration, PixelSum& pixel) const {
  using Doubles = double __attribute__((vector_size(32)));
  Doubles light[2] = {};
  double depth[2] = {}, opacity[2] = {}, transmittance[2] = {duration, duration};
  for (const Surface& surface : surfaces_) {
    const DepthSpan span = by_depth ? span_of(surface) : DepthSpan{};
    Color mean, swing;
    std::memcpy(&mean, surface.mean.rgba, sizeof mean);
    std::memcpy(&swing, surface.swing.rgba, sizeof swing);
    for (int point = 0; point < 2; ++point) {
      const float sign = point == 0 ? -1.0f : 1.0f;
      SurfaceSum sum;
      sum.weight = surface.mean.weight + sign * surface.swing.weight;
      const float factor = model_.scale(sum);
      if (factor == 0.0f) continue;
      const Color gathered = mean + sign * swing, rgba = gathered * factor;
      const float alpha = rgba[3] < 1.0f ? rgba[3] : 1.0f;
      const Color of_color = per_pixel ? gathered : rgba;
      const Color seen = {of_color[0], of_color[1], of_color[2], alpha};
      light[point] += transmittance[point] * __builtin_convertvector(seen, Doubles);
      if constexpr (per_pixel) opacity[point] += transmittance[point] * double{gathered[3]};
      if constexpr (by_depth) {
        const double middle = 0.5 * (span.from + span.to);
        double given[4] = {0.0, 0.0, 0.0, transmittance[point] * double{alpha}};
        for (int c = 0; c < 3; ++c) given[c] = transmittance[point] * double{rgba[c]};
        pixel.by_depth->add(point == 0 ? span.from : middle, point == 0 ? middle : span.to, given);
      }
      const float z = (surface.mean.depth + sign * surface.swing.depth) / sum.weight;
      depth[point] += transmittance[point] * (double{alpha} * double{z});
      transmittance[point] *= 1.0 - double{alpha};
    }
  }
  for (int c = 0; c < 4; ++c) pixel.rgba[c] += light[0][c] + light[1][c];
  pixel.depth += depth[0] + depth[1];
  pixel.opacity += opacity[0] + opacity[1];
}

void SurfaceStack::look(StackLook (&looks)[2]) const {
  for (int point = 0; point < 2; ++point) {
    StackLook& look = looks[point] = {};
    double left = 1.0;
    for (const Surface& surface : surfaces_) {
      const SurfaceSum sum = at_point(surface.mean, surface.swing, point == 0 ? -1.0f : 1.0f);
      const float factor = model_.scale(sum);
      if (factor == 0.0f) continue;
      const double alpha = double{std::min(sum.rgba[3] * factor, 1.0f)};
      const float of_color = model_.per_pixel() ? 1.0f : factor;
      for (int c = 0; c < 3; ++c) look.color[c] += left * double{sum.rgba[c] * of_color};
      if (model_.per_pixel()) look.opacity += left * double{sum.rgba[3]};
      look.depth += left * (alpha * double{sum.depth / sum.weight});
      left *= 1.0 - alpha;
    }
    look.alpha = 1.0 - left;
  }
}

void SurfaceStack::hand_over(Ticks begin, Ticks end, PieceSink& sink, SweepCounters& counters) {
  ++counters.intervals;
  const Members all = active_->members.view();
  handed_members_.resize(order_.size());
  handed_.clear();
  for (const Surface& surface : surfaces_) {
    for (std::size_t i = surface.first; i < surface.last; ++i) {
      const std::uint32_t k = order_[i];
      const double since = share_of(begin - active_->members.t_begin(k)), rate = all.field(member_rate)[k],
                   z_rate = all.field(member_z_rate)[k];
      SurfaceMember& member = handed_members_[i];
      member = {all.field(member_y)[k] + rate * since,
                rate,
                all.field(member_peak)[k],
                all.field(member_z)[k] + z_rate * since,
                z_rate,
                {},
                {}};
      for (std::size_t c = 0; c < 4; ++c) {
        member.rgba_rate[c] = active_->rates.empty() ? 0.0 : double{active_->rates[k][c]};
        member.rgba[c] = double{active_->colors[k][c]} + since * member.rgba_rate[c];
      }
    }
    handed_.emplace_back().members =
        std::span(handed_members_).subspan(surface.first, surface.last - surface.first);
  }
  sink.piece(begin, end, handed_);
}

/// Its members' mean depth as the piece begins and as it ends.
DepthSpan SurfaceStack::span_of(const Surface& surface) const {
  double weight = 0.0, from = 0.0, to = 0.0;
  for (std::size_t i = surface.first; i < surface.last; ++i) {
    const std::uint32_t k = order_[i];
    // Where none weighs anything, any of them will do.
    const double of_member = std::max(double{mean_[k]}, 1e-30);
    weight += of_member;
    from += of_member * double{z_begin_[k]};
    to += of_member * double{z_end_[k]};
  }
  return {from / weight, to / weight};
}

}  // namespace swept
