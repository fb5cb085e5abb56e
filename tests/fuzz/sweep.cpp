// Fuzzes the sweep on a handful of fragments of one pixel: coincident, crossing, brief, fast, transparent.
// The result is finite, and lies within what the still images of the same instants allow.
//
// Whatever pieces the sweep cuts the exposure into, each gets a mean of the still images within it: the ratio
// of integrals is the instants' colours weighted by Σρ, and min(1, mean Σρ) lies between its extremes; behind
// other surfaces the sweep takes instants as they are. So between two events, where no fragment begins, ends,
// crosses another or leaves its reach, the result lies between the least and the greatest instant, but for
// roundings. Where the signal does not change between events this is exact. A piece across events in which
// fragments begin or end may be off by what most_jumps of the sweep says, and only there is that allowed.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "abuffer/reference/reference_frame.h"
#include "abuffer/resolve/sweep.h"
#include "abuffer/sources/rasterize.h"
#include "tests/fuzz/check.h"

namespace swept {
namespace {

using Color = Eigen::Array4d;

constexpr double unit_roundoff = 0x1p-24;

/// One fragment as a ray leaves it, before it is rounded.
struct Exact {
  double t_begin, t_end, y_begin, y_end, z_begin, z_end, peak;
};

struct Pixel {
  ImageModel model;
  FragmentArrays fragments;
  std::vector<Shade> shades;

  /// As rasterize() keeps it, or not.
  void add(const Exact& f, const Shade& shade) {
    const double duration = f.t_end - f.t_begin;
    fragments.ensure(1);
    append({f.t_begin, f.t_end, f.peak, f.y_begin, (f.y_end - f.y_begin) / duration, f.z_begin,
            (f.z_end - f.z_begin) / duration},
           0, static_cast<std::uint32_t>(shades.size()), fragments);
    if (fragments.count > shades.size()) shades.push_back(shade);
  }

  [[nodiscard]] double t_begin(std::size_t i) const { return share_of(fragments.t_begin[i]); }
  [[nodiscard]] double t_end(std::size_t i) const { return share_of(fragments.t_end[i]); }
  [[nodiscard]] double y_at(std::size_t i, double t) const {
    return fragments.y[i] + double{fragments.rate[i]} * (t - t_begin(i));
  }
  [[nodiscard]] double z_at(std::size_t i, double t) const {
    return fragments.z[i] + double{fragments.z_rate[i]} * (t - t_begin(i));
  }
  [[nodiscard]] double tolerance(std::size_t i) const { return shades[i].depth_tolerance; }
  /// What depths are off by at the most, rounded and evaluated in float, and the sums and differences of two.
  [[nodiscard]] double depth_error(std::size_t i, std::size_t j) const {
    const auto largest = [&](std::size_t k) {
      return std::max(std::abs(z_at(k, t_begin(k))), std::abs(z_at(k, t_end(k))));
    };
    return 8 * unit_roundoff * (largest(i) + largest(j) + tolerance(i));
  }
};

/// Begins, ends, and where one fragment overtakes another, comes within its reach, or may do so if rounded.
std::vector<double> events_of(const Pixel& pixel) {
  std::vector<double> events;
  const FragmentArrays& f = pixel.fragments;
  for (std::size_t i = 0; i < f.count; ++i) {
    events.insert(events.end(), {pixel.t_begin(i), pixel.t_end(i)});
    for (std::size_t j = 0; j < f.count; ++j) {
      const double rate = double{f.z_rate[j]} - f.z_rate[i], e = pixel.depth_error(i, j);
      if (i == j || rate == 0.0) continue;
      const double above = pixel.z_at(j, 0.0) - pixel.z_at(i, 0.0);
      for (const double level : {-e, e, pixel.tolerance(i) - e, pixel.tolerance(i) + e}) {
        const double t = (level - above) / rate;
        if (std::max(pixel.t_begin(i), pixel.t_begin(j)) < t && t < std::min(pixel.t_end(i), pixel.t_end(j)))
          events.push_back(t);
      }
    }
  }
  std::sort(events.begin(), events.end());
  return events;
}

/// Least and greatest colour that a stretch of time may have.
struct Hull {
  Color low = Color::Constant(std::numeric_limits<double>::infinity()), high = -low;

  void include(const Color& color) {
    low = low.min(color);
    high = high.max(color);
  }
};

/// The still image at time `t`, by the reference.
struct Instant {
  Color color;
  bool lone = false;  ///< a single surface
  double coverage = 0.0;
};

Instant instant_at(const Pixel& pixel, const std::vector<std::size_t>& active, double t) {
  std::vector<reference::Disc> discs(active.size());
  std::vector<reference::Fragment> fragments;
  Instant instant;
  double weight = 0.0;
  for (std::size_t k = 0; k < active.size(); ++k) {
    const Shade& shade = pixel.shades[active[k]];
    discs[k].tolerance = shade.depth_tolerance;
    discs[k].color = Eigen::Vector4f(shade.rgba).cast<double>();
    const double y = pixel.y_at(active[k], t);
    fragments.push_back({pixel.z_at(active[k], t), pixel.fragments.peak[active[k]] * std::exp(-y * y),
                         &discs[k],
                         shade.side == Side::front  ? 1
                         : shade.side == Side::back ? -1
                                                    : 0});
    weight += fragments.back().weight;
  }
  reference::PixelSum sum;
  instant.lone = reference::shade(fragments, pixel.model, Eigen::Vector4d::Zero(), sum) == 1;
  for (const reference::Fragment& f : fragments)
    instant.lone = instant.lone && f.side * fragments.front().side >= 0 &&
                   f.depth <= fragments.front().depth + fragments.front().disc->tolerance;
  instant.color = sum.color.array();
  instant.coverage =
      pixel.model.coverage == Coverage::hard ? 1.0 : std::min(1.0, weight / pixel.model.edge_weight);
  return instant;
}

/// Whether rounding decides what is in front of what, or what weighs anything.
bool ambiguous(const Pixel& pixel, const std::vector<std::size_t>& active, double begin, double end) {
  const double middle = 0.5 * (begin + end);
  for (const std::size_t i : active) {
    const double y = std::max(std::abs(pixel.y_at(i, begin)), std::abs(pixel.y_at(i, end)));
    // Fast ones whose times are rounded by more than it takes to cross the pixel.
    if (y > 7.1 || pixel.fragments.peak[i] * std::exp(-y * y) < 0x1p-100) return true;
    for (const std::size_t j : active) {
      const double above = pixel.z_at(j, middle) - pixel.z_at(i, middle), e = pixel.depth_error(i, j);
      if (i != j && (std::abs(above) <= e || std::abs(above - pixel.tolerance(i)) <= e)) return true;
    }
  }
  return false;
}

/// Between two events.
Hull hull_between(const Pixel& pixel, double begin, double end) {
  Hull hull;
  std::vector<std::size_t> active;
  const FragmentArrays& f = pixel.fragments;
  for (std::size_t i = 0; i < f.count; ++i)
    if (pixel.t_begin(i) <= begin && end <= pixel.t_end(i)) active.push_back(i);
  if (active.empty()) {
    hull.include(Color::Zero());
    return hull;
  }
  hull.include(Color::Zero());
  hull.include(Color::Ones());
  if (ambiguous(pixel, active, begin, end)) return hull;

  // A weight's relative change is at most `slope` per unit of time, that of a surface's colour and of its
  // coverage as well. `error` is that of a weight: y's roundings times the slope of its square, exp's, and
  // the product's.
  const auto n = static_cast<double>(active.size());
  double slope = 0.0, error = 0.0;
  for (const std::size_t i : active) {
    const double y = std::max(std::abs(pixel.y_at(i, begin)), std::abs(pixel.y_at(i, end)));
    const double moved = f.rate[i] * (pixel.t_end(i) - pixel.t_begin(i));
    slope = std::max(slope, 2.0 * y * f.rate[i]);
    error = std::max(error, (2.0 * y * 4.0 * (std::abs(f.y[i]) + moved) + 8.0) * unit_roundoff);
  }
  const double duration = end - begin;
  const int steps = static_cast<int>(std::clamp(32.0 * n * slope * duration, 1.0, 64.0));
  hull = {};
  Hull color, coverage;
  for (int k = 0; k <= steps; ++k) {
    const Instant instant = instant_at(pixel, active, begin + duration * k / steps);
    hull.include(instant.color);
    if (!instant.lone || !(instant.coverage > 0.0)) continue;
    color.include(instant.color / instant.coverage);
    coverage.include(Color::Constant(instant.coverage));
  }
  if ((color.low <= color.high).all()) {
    hull.include(color.low * coverage.low);
    hull.include(color.high * coverage.high);
  }
  // Colour and coverage of up to n surfaces; half a step to the next instant. Sums of n floats and their
  // quotient.
  const double slack = 2.0 * n * (0.5 * slope * duration / steps + 2.0 * error) + (n + 16.0) * unit_roundoff;
  hull.low = (hull.low - slack).max(0.0);
  hull.high = (hull.high + slack).min(1.0 + (n + 16.0) * unit_roundoff);
  return hull;
}

/// How far off a piece may be that some of these fragments begin and end in: by the square of what share of
/// the weight they take with them, over 12. What is smooth about the weight multiplies that share as well.
double joined_error(const Pixel& pixel) {
  const FragmentArrays& f = pixel.fragments;
  const auto weight = [&](std::size_t i, double t) {
    const double y = pixel.y_at(i, t);
    return f.peak[i] * std::exp(-y * y);
  };
  double jumps = 0.0;
  for (std::size_t i = 0; i < f.count; ++i)
    for (const double t : {pixel.t_begin(i), pixel.t_end(i)}) {
      double others = 0.0;
      for (std::size_t j = 0; j < f.count; ++j)
        if (j != i && pixel.t_begin(j) <= t && t <= pixel.t_end(j)) others += weight(j, t);
      if (0.0 < t && t < 1.0) jumps += others > 0.0 ? weight(i, t) / others : 1.0;
    }
  jumps = std::min(jumps, 0.2);
  return jumps * (jumps + 0.1) / 12.0;
}

PixelSum sweep(const Pixel& pixel, const std::vector<std::uint32_t>& order, SweepCounters& counters) {
  PixelSum sum;
  PixelSweep(SurfaceModel(pixel.model))
      .resolve(pixel.fragments, pixel.shades, order.data(), order.size(), sum, counters);
  return sum;
}

void check_order(const Pixel& pixel, const std::vector<std::uint32_t>& order, const Hull& hull) {
  SweepCounters counters;
  const PixelSum sum = sweep(pixel, order, counters);
  const double joined = counters.merged > 0 ? joined_error(pixel) : 0.0;
  const auto n = static_cast<double>(pixel.fragments.count);
  for (int c = 0; c < 4; ++c) {
    SWEPT_HOLDS(std::isfinite(sum.rgba[c]));
    SWEPT_HOLDS(sum.rgba[c] >= 0.0 && sum.rgba[c] <= 1.0 + (n + 16.0) * unit_roundoff);
    SWEPT_HOLDS(sum.rgba[c] >= hull.low[c] - joined && sum.rgba[c] <= hull.high[c] + joined);
  }
  SWEPT_HOLDS(std::isfinite(sum.depth));
}

void check(const Pixel& pixel, const Pixel& mirrored) {
  if (pixel.fragments.count == 0) return;
  const std::vector<double> events = events_of(pixel);
  Hull total{Color::Zero(), Color::Zero()};
  for (std::size_t i = 0; i + 1 < events.size(); ++i) {
    const double duration = events[i + 1] - events[i];
    if (!(duration > 0.0)) continue;
    const Hull hull = hull_between(pixel, events[i], events[i + 1]);
    total.low += duration * hull.low;
    total.high += duration * hull.high;
  }
  // The sweep's times are ticks, and its shortest pieces 2⁻²⁰, of what follows an event.
  const double late = static_cast<double>(events.size()) * (0x1p-20 + 2 * share_of(1));
  total.low -= late;
  total.high += late;

  std::vector<std::uint32_t> order(pixel.fragments.count);
  std::iota(order.begin(), order.end(), 0u);
  check_order(pixel, order, total);
  std::reverse(order.begin(), order.end());
  check_order(pixel, order, total);
  if (mirrored.fragments.count == pixel.fragments.count) check_order(mirrored, order, total);
}

}  // namespace
}  // namespace swept

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swept;
  fuzz::Bytes bytes(data, size);
  Pixel pixel;
  pixel.model.coverage = bytes.flag() ? Coverage::hard : Coverage::soft;
  pixel.model.edge_weight = std::max(bytes.unit(), 0x1p-15);
  pixel.model.delta = std::max(50.0 * bytes.unit(), 1e-3);
  Pixel mirrored = pixel;
  const double reach = std::sqrt(pixel.model.delta);
  for (int i = 0; i < 10 && !bytes.empty(); ++i) {
    const double a = bytes.unit(), b = bytes.unit(), y0 = bytes.unit(), y1 = bytes.unit();
    Exact f;
    f.t_begin = std::min(a, b);
    f.t_end = std::max(a, b);
    // Brief ones begin or end between ticks.
    if (bytes.below(4) == 0) f.t_end = f.t_begin + (f.t_end - f.t_begin) * 0x1p-28;
    f.y_begin = reach * (2.0 * std::min(y0, y1) - 1.0);
    f.y_end = reach * (2.0 * std::max(y0, y1) - 1.0);
    f.z_begin = std::max(std::abs(bytes.real()), 1e-3);
    f.z_end = bytes.flag() ? f.z_begin : std::max(std::abs(bytes.real()), 1e-3);
    const int of_peak = bytes.byte();
    f.peak = of_peak % 4 == 0 ? std::min(std::abs(bytes.real()), 1.0) : bytes.unit();
    Shade shade;
    shade.side = static_cast<Side>(of_peak / 4 % 3);
    const double opacity = bytes.flag() ? 1.0 : bytes.unit();
    for (float& channel : shade.rgba) channel = static_cast<float>(opacity * bytes.unit());
    shade.rgba[3] = static_cast<float>(opacity);
    shade.depth_tolerance = std::min(std::abs(bytes.real_float()), 1e30f);
    if (!(f.t_begin < f.t_end)) continue;
    pixel.add(f, shade);
    // Exact: times are whole ticks.
    if (share_of(ticks_of(f.t_begin)) == f.t_begin && share_of(ticks_of(f.t_end)) == f.t_end)
      mirrored.add({1.0 - f.t_end, 1.0 - f.t_begin, -f.y_end, -f.y_begin, f.z_end, f.z_begin, f.peak}, shade);
  }
  check(pixel, mirrored);
  return 0;
}
