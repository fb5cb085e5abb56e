// Fragments of one window of the film, as structure of arrays.
//
// A fragment is an interval in (time, depth) with a Gaussian weight. Nothing after this file knows that it
// came from a surfel.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "splat/export.h"
#include "splat/interval/side.h"
#include "splat/interval/ticks.h"

namespace SWEPT_API swept {

/// What all fragments of one kernel share that show the same side: linear, premultiplied RGBA, the depth
/// tolerance and the side.
struct Shade {
  float rgba[4];
  float depth_tolerance;  ///< camera-space units, at t_mid
  Side side = Side::unknown;
  float tolerance_rate = 0.0f, t_mid = 0.0f;  ///< change of depth_tolerance per unit of τ; shutter time

  [[nodiscard]] float tolerance_at(float time) const {
    return std::max(0.0f, depth_tolerance + (time - t_mid) * tolerance_rate);
  }
};

/// How a Shade's colour changes over the exposure: evenly, `rate` per unit of τ. At `t_mid` it is the
/// Shade's.
struct ShadeChange {
  float rate[4] = {0.0f, 0.0f, 0.0f, 0.0f};
  float t_mid = 0.0f;

  [[nodiscard]] bool any() const {
    return rate[0] != 0.0f || rate[1] != 0.0f || rate[2] != 0.0f || rate[3] != 0.0f;
  }
};

/// Fragments by column; entries from `count` on mean nothing. The arrays grow, never shrink, and are reused
/// from window to window, so that there is no allocation per fragment.
struct FragmentArrays {
  std::vector<std::uint32_t> pixel;   ///< row-major index within the window
  std::vector<std::uint32_t> kernel;  ///< index of its Shade
  std::vector<Ticks> t_begin, t_end;  ///< t_begin < t_end
  std::vector<float> y, rate;  ///< ρ(τ) = peak · exp(−(y + rate·(τ − t_begin))²), τ ∈ [0, 1]
  std::vector<float> peak;
  std::vector<float> z, z_rate;  ///< depth at t_begin, camera-space units, and its change per unit of τ
  std::size_t count = 0;

  /// Makes room for `more` fragments beyond count.
  void ensure(std::size_t more) {
    if (count + more <= pixel.size()) return;
    const std::size_t size = std::max(count + more, 2 * pixel.size());
    pixel.resize(size);
    kernel.resize(size);
    for (std::vector<Ticks>* field : {&t_begin, &t_end}) field->resize(size);
    for (std::vector<float>* field : {&y, &rate, &peak, &z, &z_rate}) field->resize(size);
  }
};

/// A fragment that covers the whole shutter and changes nothing within it.
[[nodiscard]] inline bool is_still(const FragmentArrays& f, std::size_t i) {
  return f.rate[i] == 0.0f && f.z_rate[i] == 0.0f && f.t_begin[i] == 0 && f.t_end[i] == shutter_close;
}

}  // namespace swept
