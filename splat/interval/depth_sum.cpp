#include "splat/interval/depth_sum.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace swept {
namespace {

std::uint32_t slab_of(float depth) { return std::bit_cast<std::uint32_t>(depth) >> 16; }
/// Its nearest depth.
float begin_of(std::uint32_t slab) { return std::bit_cast<float>(slab << 16); }

float as_depth(double depth) {
  constexpr double least = std::numeric_limits<float>::min(), most = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(depth, least, most));
}

}  // namespace

void DepthSum::add(double from, double to, const double (&rgba)[4]) {
  const float near = as_depth(std::min(from, to)), far = as_depth(std::max(from, to));
  const std::uint32_t first = slab_of(near), last = slab_of(far);
  if (first == last) return put(first, near, far, rgba, 1.0);
  const double thickness = double{far} - near;
  for (std::uint32_t slab = first; slab <= last; ++slab) {
    const float begin = std::max(near, begin_of(slab)), end = slab < last ? begin_of(slab + 1) : far;
    put(slab, begin, end, rgba, (double{end} - begin) / thickness);
  }
}

void DepthSum::put(std::uint32_t slab, float near, float far, const double (&rgba)[4], double share) {
  auto part = std::lower_bound(parts_.begin(), parts_.end(), slab,
                               [](const DepthPart& p, std::uint32_t wanted) { return p.slab < wanted; });
  if (part == parts_.end() || part->slab != slab)
    part = parts_.insert(part, {slab, near, far, {0.0f, 0.0f, 0.0f, 0.0f}});
  part->near = std::min(part->near, near);
  part->far = std::max(part->far, far);
  for (int c = 0; c < 4; ++c) part->rgba[c] += static_cast<float>(share * rgba[c]);
}

}  // namespace swept
