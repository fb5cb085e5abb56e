// A moving kernel on a parabola, seen along one viewing ray: the straight line that it is for this ray.
//
// Source: our own; model section 2 for what is linear. The disc's coordinates (u, v) along a ray are linear
// in the disc's centre, so on a parabola they and the depth are parabolas in time. A disc that is small
// beside the way of its segment covers a pixel for a small part of the time, in which the parabola is as good
// as straight: what is left of it falls with the square of that part, while a chord of the segment is off by
// all of it. So each ray has the line that fits the parabola best over the time in which it sees the disc.
#pragma once

#include <algorithm>
#include <cmath>

#include "splat/kernel/ray_kernel.h"

namespace swept {

/// What is to be added to u, v and z, times s² − h²/3 (MovingKernel::bend).
template <class T>
struct RayBend {
  T u, v, z;
};

/// The mean of x² over [−1, 1] weighed by exp(−(a x)²): 1/3 where nothing falls off, 1/(2a²) where all does.
/// Within 1 % up to a² = 3, where the kernel is cut.
template <class T>
[[nodiscard]] T mean_square(T a_squared) {
  return T(1) / (T(3) + a_squared * (T(0.8) + T(0.14) * a_squared));
}

/// As intersect_tube(), of a kernel that `bend` bends; `mean` are the coordinates of the same kernel without
/// that. The fragment is that of the line which fits the path in the middle of the time in which the ray sees
/// the disc, and has the path's mean in it. Its segment may turn by little (PathCutter): a ray sees the disc
/// once.
template <class T>
[[nodiscard]] bool intersect_bent_tube(const RayCoordinates<T>& mean, const RayBend<T>& bend, T segment_begin,
                                       T segment_end, T near, T delta, T weight, RayFragment<T>& fragment) {
  const T t_mid = T(0.5) * (segment_begin + segment_end), half = T(0.5) * (segment_end - segment_begin);
  // Touches the path at `at`, or has its mean where s² has `spread` about that.
  const auto line = [&](T at, T spread) -> RayCoordinates<T> {
    const T moved = spread - half * half / T(3) - at * at, twice = T(2) * at;
    return {mean.u + moved * bend.u,  mean.v + moved * bend.v,  mean.z + moved * bend.z,
            mean.du + twice * bend.u, mean.dv + twice * bend.v, mean.dz + twice * bend.z};
  };
  // When the disc's centre is nearest to the ray: by tangents, each from where the last one is nearest.
  RayCoordinates<T> tangent = mean;
  T nearest = T(0);
  for (int k = 0; k < 3; ++k) {
    const T squared = tangent.du * tangent.du + tangent.dv * tangent.dv;
    const T to = -(tangent.u * tangent.du + tangent.v * tangent.dv) / squared;
    // What is not a number stays in the middle.
    nearest = to > -half ? std::min(to, half) : to <= -half ? -half : T(0);
    tangent = line(nearest, T(0));
  }
  const T passing = T(1) / length_of(tangent.du, tangent.dv);
  T begin = std::max(-half, nearest - passing), end = std::min(half, nearest + passing);
  T reach = T(0.5) * (end - begin);
  const RayCoordinates<T> first = line(T(0.5) * (begin + end), reach * reach / T(3));
  if (!intersect_tube(first, segment_begin, segment_end, near, delta, weight, fragment)) return false;
  begin = fragment.t_begin - t_mid;
  end = fragment.t_end - t_mid;
  reach = T(0.5) * (end - begin);
  // Of the Gaussian only as much as lies to both sides.
  const T both =
      std::max(T(0), std::min(-fragment.y_begin, fragment.y_begin + fragment.rate * (end - begin)));
  return intersect_tube(line(T(0.5) * (begin + end), reach * reach * mean_square(both * both)), segment_begin,
                        segment_end, near, delta, weight, fragment);
}

}  // namespace swept
