// Kernels to fragments.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "splat/camera.h"
#include "splat/export.h"
#include "splat/interval/fragments.h"
#include "splat/kernel/moving_kernel.h"
#include "splat/kernel/ray_kernel.h"
#include "splat/kernel/screen_bounds.h"
#include "splat/kernel/turning_kernel.h"

namespace SWEPT_API swept {

/// A rectangle of pixels of the whole film.
struct Window {
  int x = 0, y = 0, width = 0, height = 0;

  /// Around the pixels' centres.
  [[nodiscard]] PixelBox centers() const { return {x + 0.5, x + width - 0.5, y + 0.5, y + height - 0.5}; }
  [[nodiscard]] bool empty() const { return width <= 0 || height <= 0; }
  [[nodiscard]] bool contains(int px, int py) const {
    return px >= x && px < x + width && py >= y && py < y + height;
  }
  /// The least that has both; an empty one has nothing.
  [[nodiscard]] Window joined(const Window& other) const {
    if (empty() || other.empty()) return empty() ? other : *this;
    const int left = std::min(x, other.x), top = std::min(y, other.y);
    return {left, top, std::max(x + width, other.x + other.width) - left,
            std::max(y + height, other.y + other.height) - top};
  }
  /// Cut across its longer side; of more than one pixel.
  [[nodiscard]] std::pair<Window, Window> halves() const {
    Window first = *this, second = *this;
    if (height >= width) {
      first.height /= 2;
      second.y += first.height;
      second.height -= first.height;
    } else {
      first.width /= 2;
      second.x += first.width;
      second.width -= first.width;
    }
    return {first, second};
  }
};

struct RasterModel {
  Projection projection;
  double near = 0.0;
  double delta = 3.0;
  std::uint32_t backs = 0;  ///< from a kernel's Shade to that of its back, where the two are told apart
  double row_delay = 0.0;  ///< shutter time by which each row of the film is exposed later than the one above
  bool simd = true;        ///< false: the plain loops, same bits
};

/// Of each kernel, by its index; and if any is oriented, after them all again for their backs.
[[nodiscard]] std::vector<Shade> shades_of(std::span<const MovingKernel> kernels);

/// Of each of these shades, how it changes; empty if none does.
[[nodiscard]] std::vector<ShadeChange> changes_of(std::span<const MovingKernel> kernels,
                                                  const std::vector<Shade>& shades);

/// Appends a fragment as the sweep takes it: times in ticks, y and z where it begins then, the rest rounded
/// to float. Not one that would last for no tick or weigh nothing, nor what is beyond the range of sums.
/// There must be room: FragmentArrays::ensure().
void append(const RayFragment<double>& fragment, std::uint32_t pixel, std::uint32_t kernel,
            FragmentArrays& fragments);

/// Appends the kernel's fragments in `window`. `octagon` is its bounds_of(). Every pixel's result depends
/// on its place on the film alone, not on the window.
void rasterize(const MovingKernel& kernel, const DiscTurn* turn, std::uint32_t kernel_index,
               const Octagon& octagon, const RasterModel& model, const Window& window,
               FragmentArrays& fragments);

/// The part of `window` with all pixels that rasterize() visits.
[[nodiscard]] Window part_within(const Octagon& octagon, const Window& window);

/// How many pixels of `window` rasterize() visits: an upper bound of the fragments it appends.
[[nodiscard]] std::size_t visited_pixels(const Octagon& octagon, const Window& window);

}  // namespace swept
