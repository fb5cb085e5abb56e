// Where rays meet a moving kernel: plain functions over plain arrays, one implementation per instruction set.
// All give the bits of intersect_tube() and intersect_bent_tube(), which are the definition. Source:
// splat/kernel/ray_kernel.h and bent_kernel.h.
#pragma once

#include <cstddef>
#include <cstdint>

namespace swept {

/// Many rays' coordinates (RayCoordinates), and what they find of the kernel (RayFragment).
struct TubeBlock {
  static constexpr std::size_t most = 64;  ///< rays; a multiple of every vector's lanes

  alignas(64) double u[most], v[most], z[most], du[most], dv[most], dz[most];
  alignas(64) double t_begin[most], t_end[most],
      nearest_squared[most], rate[most], y_begin[most], z_begin[most];
};

/// How a kernel bends along each of the rays (RayBend).
struct TubeBends {
  alignas(64) double u[TubeBlock::most], v[TubeBlock::most], z[TubeBlock::most];
};

/// What all rays of a block have in common.
struct TubeSegment {
  double begin, end;  ///< shutter time
  double near, delta;
};

/// Rays by their bits: what is in neither misses.
struct TubeHits {
  std::uint64_t met = 0;
  std::uint64_t odd = 0;  ///< so slow or so fast that the square of their speed is no number to go by
};

struct TubeMath {
  const char* name;

  /// Of the first `count` rays, 1 to TubeBlock::most. What is calculated of others, up to a whole vector, is
  /// not to be looked at.
  TubeHits (*intersect)(TubeBlock& block, std::size_t count, const TubeSegment& segment);
  /// The same of a kernel that bends; `dz` becomes that of the line which a ray has of it.
  TubeHits (*intersect_bent)(TubeBlock& block, const TubeBends& bends, std::size_t count,
                             const TubeSegment& segment);
};

/// Those this processor can run, the plain one first, the fastest last.
struct TubeMaths {
  const TubeMath* first;
  std::size_t count;

  [[nodiscard]] const TubeMath& plain() const { return *first; }
  [[nodiscard]] const TubeMath& fastest() const { return first[count - 1]; }
};
[[nodiscard]] TubeMaths tube_maths();

}  // namespace swept
