#include "abuffer/sources/rasterize.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "abuffer/simd/tube_math.h"
#include "splat/kernel/bent_kernel.h"

namespace swept {
namespace {

/// Pixels [first, last) of a row or a column.
struct PixelRange {
  int first = 0, last = 0;
};

/// The pixels of [first, first + count) whose centres are in [low, high].
PixelRange centers_within(double low, double high, int first, int count) {
  // Clamped before the conversion: bounds may lie far beyond the range of an int.
  const auto pixel = [&](double at) {
    return static_cast<int>(std::clamp(at, double(first), double(first + count)));
  };
  return {pixel(std::ceil(low - 0.5)), pixel(std::floor(high - 0.5) + 1.0)};
}

/// Of row `y`, those in the octagon and the window.
PixelRange row_of(const Octagon& octagon, const Window& window, int y) {
  double x_min, x_max;
  if (!octagon.span(y + 0.5, y + 0.5, x_min, x_max)) return {};
  return centers_within(x_min, x_max, window.x, window.width);
}

PixelRange rows_of(const PixelBox& box, const Window& window) {
  return centers_within(box.y_min, box.y_max, window.y, window.height);
}

PixelRange columns_of(const PixelBox& box, const Window& window) {
  return centers_within(box.x_min, box.x_max, window.x, window.width);
}

/// The kernel in the shutter time of a row that is exposed so much later. False: it is not there then.
bool delay(MovingKernel& kernel, double later) {
  const double middle = double{kernel.t_mid()}, half = kernel.half_time();
  kernel.t_begin = static_cast<float>(std::clamp(kernel.t_begin - later, 0.0, 1.0));
  kernel.t_end = static_cast<float>(std::clamp(kernel.t_end - later, 0.0, 1.0));
  kernel.keep_part(kernel.t_mid() + later - middle, half);
  return kernel.t_begin < kernel.t_end;
}

/// None for one that is not bent.
std::optional<KernelPlane<double>> bending_of(MovingKernel kernel, bool parallel) {
  if (!kernel.bent()) return std::nullopt;
  kernel.velocity = kernel.bend;
  return KernelPlane<double>(kernel, parallel);
}

RayBend<double> bend_along(const KernelPlane<double>& bending, double x, double y) {
  const RayCoordinates<double> at = bending.along(x, y);
  return {at.du, at.dv, at.dz};
}

/// A kernel on its way, as a ray meets it.
struct SeenKernel {
  const KernelPlane<double>& plane;
  const std::optional<KernelPlane<double>>& bending;
  const std::optional<TurningPlane>& turning;
  const MovingKernel& kernel;
};

/// Rays that see one kernel, until there are enough to be looked along at once.
class RayBatch {
 public:
  explicit RayBatch(const TubeMath& math) : math_(math) {}

  [[nodiscard]] bool full() const { return count_ == TubeBlock::most; }

  void add(double x, double y, std::uint32_t pixel, std::uint32_t shade) {
    x_[count_] = x;
    y_[count_] = y;
    pixel_[count_] = pixel;
    shade_[count_] = shade;
    ++count_;
  }

  /// Appends what the rays find, in their order, and forgets them.
  void append_to(FragmentArrays& out, const SeenKernel& seen, const RasterModel& model) {
    if (count_ == 0) return;
    out.ensure(count_);
    if (seen.turning)
      append_turning(out, *seen.turning, seen.kernel, model);
    else if (seen.bending)
      append_bent(out, seen.plane, *seen.bending, seen.kernel, model);
    else
      append_straight(out, seen.plane, seen.kernel, model);
    count_ = 0;
  }

 private:
  void append_straight(FragmentArrays& out, const KernelPlane<double>& plane, const MovingKernel& kernel,
                       const RasterModel& model) {
    look_along(plane);
    const TubeHits hits =
        math_.intersect(tubes_, count_, {kernel.t_begin, kernel.t_end, model.near, model.delta});
    append_hits(
        out, hits, model.delta, kernel.weight, [](RayFragment<double>&) { return true; },
        [&](std::size_t i, RayFragment<double>& fragment) {
          return intersect_tube<double>(plane.along(x_[i], y_[i]), kernel.t_begin, kernel.t_end, model.near,
                                        model.delta, kernel.weight, fragment);
        });
  }

  void append_bent(FragmentArrays& out, const KernelPlane<double>& plane, const KernelPlane<double>& bending,
                   const MovingKernel& kernel, const RasterModel& model) {
    look_along(plane);
    look_along_bend(bending);
    const TubeHits hits =
        math_.intersect_bent(tubes_, bends_, count_, {kernel.t_begin, kernel.t_end, model.near, model.delta});
    append_hits(
        out, hits, model.delta, kernel.weight, [](RayFragment<double>&) { return true; },
        [&](std::size_t i, RayFragment<double>& fragment) {
          return intersect_bent_tube<double>(plane.along(x_[i], y_[i]), bend_along(bending, x_[i], y_[i]),
                                             kernel.t_begin, kernel.t_end, model.near, model.delta,
                                             kernel.weight, fragment);
        });
  }

  void append_turning(FragmentArrays& out, const TurningPlane& turning, const MovingKernel& kernel,
                      const RasterModel& model) {
    look_along(turning);
    const TubeHits hits =
        math_.intersect_bent(tubes_, bends_, count_, {kernel.t_begin, kernel.t_end, model.near, model.delta});
    append_hits(
        out, hits, model.delta, 1.0, [&](RayFragment<double>& fragment) { return turning.weigh(fragment); },
        [&](std::size_t i, RayFragment<double>& fragment) {
          return turning.intersect(x_[i], y_[i], model.near, model.delta, fragment);
        });
  }

  /// Of the rays that meet the kernel, finished by finish(fragment); those that are odd by one(i, fragment).
  template <class Finish, class One>
  void append_hits(FragmentArrays& out, const TubeHits& hits, double delta, double weight,
                   const Finish& finish, const One& one) const {
    for (std::uint64_t left = hits.met | hits.odd; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      RayFragment<double> fragment;
      if ((hits.odd >> i & 1) == 0) {
        fragment = {tubes_.t_begin[i], tubes_.t_end[i], weight * std::exp(-delta * tubes_.nearest_squared[i]),
                    tubes_.y_begin[i], tubes_.rate[i],  tubes_.z_begin[i],
                    tubes_.dz[i]};
        if (!finish(fragment)) continue;
      } else if (!one(i, fragment)) {
        continue;
      }
      append(fragment, pixel_[i], shade_[i], out);
    }
  }

  /// Up to whole vectors.
  std::size_t padded() {
    const std::size_t size = (count_ + widest - 1) / widest * widest;
    for (std::size_t i = count_; i < size; ++i) {
      x_[i] = x_[count_ - 1];
      y_[i] = y_[count_ - 1];
    }
    return size;
  }

  void put(std::size_t i, const RayCoordinates<double>& ray) {
    tubes_.u[i] = ray.u;
    tubes_.v[i] = ray.v;
    tubes_.z[i] = ray.z;
    tubes_.du[i] = ray.du;
    tubes_.dv[i] = ray.dv;
    tubes_.dz[i] = ray.dz;
  }
  void put(std::size_t i, const RayBend<double>& bend) {
    bends_.u[i] = bend.u;
    bends_.v[i] = bend.v;
    bends_.z[i] = bend.z;
  }

  // Flattened: what of along() does not depend on the ray leaves the loop, and the loop becomes vectors.
  [[gnu::flatten]] void look_along(const KernelPlane<double>& plane) {
    const std::size_t size = padded();
    for (std::size_t i = 0; i < size; ++i) put(i, plane.along(x_[i], y_[i]));
  }
  [[gnu::flatten]] void look_along_bend(const KernelPlane<double>& bending) {
    const std::size_t size = padded();
    for (std::size_t i = 0; i < size; ++i) put(i, bend_along(bending, x_[i], y_[i]));
  }
  [[gnu::flatten]] void look_along(const TurningPlane& turning) {
    const std::size_t size = padded();
    for (std::size_t i = 0; i < size; ++i) {
      const TurningPlane::Seen seen = turning.along(x_[i], y_[i]);
      put(i, seen.mean);
      put(i, seen.bend);
    }
  }

  static constexpr std::size_t widest = 8;

  const TubeMath& math_;
  std::size_t count_ = 0;
  double x_[TubeBlock::most], y_[TubeBlock::most];
  std::uint32_t pixel_[TubeBlock::most], shade_[TubeBlock::most];
  TubeBlock tubes_;
  TubeBends bends_;
};

}  // namespace

std::vector<Shade> shades_of(std::span<const MovingKernel> kernels) {
  const bool any_oriented = std::any_of(kernels.begin(), kernels.end(),
                                        [](const MovingKernel& k) { return !k.outside.isZero(0.0f); });
  std::vector<Shade> shades;
  shades.reserve((any_oriented ? 2 : 1) * kernels.size());
  for (const MovingKernel& k : kernels)
    shades.push_back({{k.color[0], k.color[1], k.color[2], k.color[3]},
                      k.depth_tolerance,
                      k.outside.isZero(0.0f) ? Side::unknown : Side::front,
                      k.tolerance_rate,
                      k.t_mid()});
  if (!any_oriented) return shades;
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    shades.push_back(shades[k]);
    shades.back().side = Side::back;
  }
  return shades;
}

std::vector<ShadeChange> changes_of(std::span<const MovingKernel> kernels, const std::vector<Shade>& shades) {
  std::vector<ShadeChange> changes;
  if (std::none_of(kernels.begin(), kernels.end(), [](const MovingKernel& k) { return k.changes_color(); }))
    return changes;
  changes.reserve(shades.size());
  for (std::size_t s = 0; s < shades.size(); ++s) {
    const MovingKernel& k = kernels[s % kernels.size()];
    changes.push_back({{k.color_rate[0], k.color_rate[1], k.color_rate[2], k.color_rate[3]}, k.t_mid()});
  }
  return changes;
}

void append(const RayFragment<double>& f, std::uint32_t pixel, std::uint32_t kernel, FragmentArrays& out) {
  const Ticks t_begin = ticks_of(f.t_begin), t_end = ticks_of(f.t_end);
  const float peak = static_cast<float>(f.peak);
  if (!(t_begin < t_end) || !(peak > 0.0f)) return;
  // Where line and depth are at the time as it is kept.
  const double later = share_of(t_begin) - f.t_begin;
  const double y = f.y_begin + f.rate * later, z = f.z_begin + f.z_rate * later;
  // Beyond what floats can add up. Nothing meant is that far away or that fast.
  constexpr double largest = 1e30;
  if (!(std::max({std::abs(z), std::abs(f.z_rate), std::abs(y), f.rate}) <= largest)) return;
  const std::size_t i = out.count++;
  out.pixel[i] = pixel;
  out.kernel[i] = kernel;
  out.t_begin[i] = t_begin;
  out.t_end[i] = t_end;
  out.y[i] = static_cast<float>(y);
  out.rate[i] = static_cast<float>(f.rate);
  out.peak[i] = peak;
  out.z[i] = static_cast<float>(z);
  out.z_rate[i] = static_cast<float>(f.z_rate);
}

void rasterize(const MovingKernel& of_all_rows, const DiscTurn* turn, std::uint32_t kernel_index,
               const Octagon& octagon, const RasterModel& model, const Window& window,
               FragmentArrays& fragments) {
  MovingKernel kernel = of_all_rows;
  const bool parallel = model.projection.orthographic;
  KernelPlane<double> plane(kernel, parallel);
  // What bends a path does not depend on the row: parts of a parabola are bent alike.
  const std::optional<KernelPlane<double>> bending = bending_of(kernel, parallel);
  std::optional<TurningPlane> turning;
  if (turn != nullptr) turning.emplace(kernel, *turn, 0.0, parallel);
  const SeenKernel seen{plane, bending, turning, kernel};
  const double per_pixel = 1.0 / model.projection.focal_px;
  // Of a one-sided disc the back is not seen.
  const bool oriented = plane.oriented() && model.backs != 0;
  const std::uint32_t back_index = kernel_index + model.backs;
  RayBatch rays(model.simd ? tube_maths().fastest() : tube_maths().plain());
  const PixelRange rows = rows_of(octagon.box(), window);
  for (int y = rows.first; y < rows.last; ++y) {
    const PixelRange row = row_of(octagon, window, y);
    if (row.first >= row.last) continue;
    if (model.row_delay != 0.0) {
      rays.append_to(fragments, seen, model);
      kernel = of_all_rows;
      if (!delay(kernel, model.row_delay * y)) continue;
      plane = KernelPlane<double>(kernel, parallel);
      if (turn != nullptr) turning.emplace(kernel, *turn, model.row_delay * y, parallel);
    }
    const double ray_y = (y + 0.5 - model.projection.center_y) * per_pixel;
    const std::uint32_t row_start = static_cast<std::uint32_t>((y - window.y) * window.width - window.x);
    for (int x = row.first; x < row.last; ++x) {
      const double ray_x = (x + 0.5 - model.projection.center_x) * per_pixel;
      if (!plane.faces(ray_x, ray_y)) continue;
      if (rays.full()) rays.append_to(fragments, seen, model);
      rays.add(ray_x, ray_y, row_start + static_cast<std::uint32_t>(x),
               oriented && plane.shows_back(ray_x, ray_y) ? back_index : kernel_index);
    }
  }
  rays.append_to(fragments, seen, model);
}

Window part_within(const Octagon& octagon, const Window& window) {
  const PixelBox box = octagon.box();
  const PixelRange rows = rows_of(box, window), columns = columns_of(box, window);
  return {columns.first, rows.first, columns.last - columns.first, rows.last - rows.first};
}

std::size_t visited_pixels(const Octagon& octagon, const Window& window) {
  const PixelRange rows = rows_of(octagon.box(), window);
  std::size_t pixels = 0;
  for (int y = rows.first; y < rows.last; ++y) {
    const PixelRange row = row_of(octagon, window, y);
    if (row.first < row.last) pixels += static_cast<std::size_t>(row.last - row.first);
  }
  return pixels;
}

}  // namespace swept
