// Even sampling of parametric surfaces with discs that leave no holes.
//
// Points lie on the golden lattice (i/n, frac(i φ)). φ is badly approximable, so the lattice stays even
// however it is stretched along u or v; that is what makes the sphere's Fibonacci spiral work at every
// latitude, and here serves tubes, discs and strips of any proportion.
//
// In units of √A, A the area per point, a lattice of that family has a shortest vector of at most
// √(2/√3) = 1.075, and nowhere is the second nearest point farther. Discs of radius 1.25 √A thus cover
// every point of a flat surface at least twice, with room for curvature, and 4.9 times on average.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "datasets/shape.h"
#include "splat/surfel.h"

namespace swept::datasets {

/// Disc radius at the kernel's cut-off, in units of the square root of the area per point.
inline constexpr double kDiscRadius = 1.25;

/// One point of a surface over the unit square. tangent_u × tangent_v is outward, its length the area
/// that a unit of (u, v) covers, and a circle in (tangent_u, tangent_v) is as round as the lattice.
struct SurfaceSample {
  Eigen::Vector3d position;
  Eigen::Vector3d tangent_u, tangent_v;
  Eigen::Vector3d color;  ///< linear, before shading
};

/// Makes orthogonal derivatives (∂p/∂u, ∂p/∂v) equally long at the same area, which is allowed because the
/// lattice does not mind being stretched along them. Null vectors give null vectors.
void even_out(Eigen::Vector3d& tangent_u, Eigen::Vector3d& tangent_v);

/// SplitMix64 of (seed, stream, index), mapped to [0, 1).
[[nodiscard]] double random_unit(std::uint64_t seed, std::uint64_t stream, std::uint64_t index);

/// Shares `points` among patches in proportion to their areas, by largest remainder; sums to `points`.
[[nodiscard]] std::vector<std::size_t> apportion(std::size_t points, const std::vector<double>& areas);

/// Collects patches into a cloud. Shading and tint come from the request.
class CloudBuilder {
 public:
  enum class Sides { outer, both };  ///< whether the Lambert term takes the normal's sign into account

  explicit CloudBuilder(const Request& request);

  /// `chart(u, v)` gives a SurfaceSample for u, v in [0, 1). `n` of the cloud's points go to it.
  template <class Chart>
  void add_patch(std::size_t n, Sides sides, const Chart& chart) {
    const double turn = random_unit(seed_, 0, patches_++);
    for (std::size_t i = 0; i < n; ++i) {
      const double u = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
      const double along = turn + static_cast<double>(i) * 0.6180339887498949;
      add(chart(u, along - static_cast<double>(static_cast<std::size_t>(along))), n, sides);
    }
  }
  /// One free disc: the axes as they are, colour unshaded.
  void add_particle(const Eigen::Vector3d& position, const Eigen::Vector3d& axis_u,
                    const Eigen::Vector3d& axis_v, const Eigen::Vector3d& velocity,
                    const Eigen::Vector3d& color);

  [[nodiscard]] SurfelCloud take() { return std::move(cloud_); }

 private:
  void add(const SurfaceSample& sample, std::size_t n, Sides sides);

  SurfelCloud cloud_;
  std::uint64_t seed_;
  std::uint64_t patches_ = 0;
  Eigen::Array3d tint_;
  double ambient_;
  Eigen::Vector3d light_;
};

}  // namespace swept::datasets
