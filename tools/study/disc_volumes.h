// Moving discs in Embree's bounding volumes over space and time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "splat/kernel/kernel_set.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// Where a ray meets a disc.
struct Hit {
  float z;    ///< camera-space depth
  float rho;  ///< the kernel's value, > 0
  std::uint32_t kernel;
};

/// A ray through the eye and a pixel's centre, at one instant.
struct DiscRay {
  double x, y;  ///< direction (x, y, 1), tangents
  float time;   ///< shutter time, [0, 1)
};

class DiscVolumes {
 public:
  /// Keeps a reference to `set`. threads 0: all there are. Errors: discs beyond Embree's range, Embree's own.
  /// Throws std::bad_alloc.
  [[nodiscard]] static Result<DiscVolumes> build(const KernelSet& set, const ImageModel& model, int threads);

  DiscVolumes(DiscVolumes&&) noexcept;
  DiscVolumes& operator=(DiscVolumes&&) noexcept;
  ~DiscVolumes();

  /// Replaces `hits` by what the ray meets, sorted by depth, then by kernel. What an opaque disc hides need
  /// not be met, and is left out: hits do not depend on how the volumes lie. Returns how many were met.
  /// Throws std::bad_alloc.
  std::size_t meet(const DiscRay& ray, std::vector<Hit>& hits) const;

  /// Distinct stretches of time that kernels exist in.
  [[nodiscard]] std::size_t motion_ranges() const;

 private:
  struct Parts;
  explicit DiscVolumes(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace swept
