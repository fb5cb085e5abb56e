// One still image of model section 1, the textbook way: every disc meets every ray near it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "splat/image.h"
#include "splat/kernel/kernel_set.h"
#include "splat/scene.h"

namespace swept::reference {

/// Pixels [x_begin, x_end) × [y_begin, y_end) of the whole film.
struct PixelBox {
  int x_begin = 0, y_begin = 0, x_end = 0, y_end = 0;

  [[nodiscard]] bool empty() const { return x_begin >= x_end || y_begin >= y_end; }
};

/// A kernel at one instant, with all that does not depend on the ray. Camera space.
struct Disc {
  Eigen::Vector3d center, normal;  ///< normal n = a₁ × a₂, not unit
  Eigen::Vector3d dual_u, dual_v;  ///< a₂ × n / |n|² and n × a₁ / |n|²
  Eigen::Vector3d facing, outside;
  double plane = 0.0;  ///< n · center
  double weight = 0.0, tolerance = 0.0;
  Eigen::Vector4d color;  ///< premultiplied RGBA
  PixelBox box;           ///< contains every pixel whose ray meets the disc; empty: none does
};

/// What a ray sees of a disc.
struct Fragment {
  double depth = 0.0;
  double weight = 0.0;         ///< ρ
  const Disc* disc = nullptr;  ///< never null
  int side = 0;                ///< that is seen: 1 front, −1 back, 0 not known
};

/// What a ray sees of several fragments, or of a mesh.
struct Surface {
  Eigen::Vector4d color;  ///< normalised, premultiplied by opacity
  double depth, coverage;
};

class MeshAt;

/// Sums over instants, and over the surfaces of each.
struct PixelSum {
  Eigen::Vector4d color = Eigen::Vector4d::Zero();  ///< background included
  double alpha = 0.0;                               ///< background left out
  double alpha_depth = 0.0;
};

/// A viewing ray: from + depth · direction, camera space.
struct Ray {
  Eigen::Vector3d from, direction;
};
/// The one through a place of the film, in pixels from its corner.
[[nodiscard]] Ray ray_at(const Projection& projection, double film_x, double film_y);
/// The one through the centre of pixel (x, y).
[[nodiscard]] inline Ray ray_through(const Projection& projection, int x, int y) {
  return ray_at(projection, x + 0.5, y + 0.5);
}

/// The kernel at shutter time `tau`, its box within `window`; the box is empty if the kernel does not exist
/// at that time, has no area, or is nearer than `near` throughout.
[[nodiscard]] Disc place(const MovingKernel& kernel, double tau, const Projection& projection, double near,
                         const PixelBox& window);

[[nodiscard]] std::optional<Fragment> meet(const Disc& disc, const Ray& ray, double near, double delta);

/// Sorts the fragments of one pixel into an order that depends on their content alone, groups them into
/// surfaces, and appends these and `others` to `seen`, the first in front.
void find_surfaces(std::span<Fragment> fragments, const ImageModel& model, std::span<Surface> others,
                   std::vector<Surface>& seen);

/// The same, and adds what is seen of them and of `others` over the background. Returns how many surfaces
/// were seen.
std::size_t shade(std::span<Fragment> fragments, const ImageModel& model, const Eigen::Vector4d& background,
                  PixelSum& sum, std::span<Surface> others = {});

/// Adds still images up. Runs in the caller's task arena; the number of threads changes no bit of the sums.
class FrameSum {
 public:
  FrameSum(const Film& film, const ImageModel& model, const Eigen::Vector4f& background);

  void add(const KernelSet& set, double tau, std::span<const MeshAt> meshes = {});
  /// Of the instants added, at least one.
  [[nodiscard]] Image mean() const;

  [[nodiscard]] std::uint64_t instants() const { return instants_; }
  [[nodiscard]] std::uint64_t fragments() const { return fragments_; }
  [[nodiscard]] std::uint64_t surfaces() const { return surfaces_; }

 private:
  struct Counts {
    std::uint64_t fragments = 0, surfaces = 0;
  };

  void place_all(const KernelSet& set, double tau);
  void bin_by_band();
  [[nodiscard]] Counts render_band(const KernelSet& set, std::span<const MeshAt> meshes, std::size_t band);
  [[nodiscard]] std::size_t band_of(int y) const;
  [[nodiscard]] std::size_t band_count() const;

  Film film_;
  ImageModel model_;
  Eigen::Vector4d background_;
  PixelBox window_;
  std::vector<PixelSum> sums_;             ///< one per pixel of the window
  std::vector<Disc> discs_;                ///< one per kernel, of the instant being added
  std::vector<std::size_t> band_begin_;    ///< where a band's entries of band_discs_ begin, and their end
  std::vector<std::uint32_t> band_discs_;  ///< indices into discs_, band by band
  std::uint64_t instants_ = 0, fragments_ = 0, surfaces_ = 0;
};

}  // namespace swept::reference
