// A scene's kernels one after the other, and any of them again, to the bit: who would have to keep them all
// keeps where they come from. Private to splat and the A-buffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "splat/export.h"
#include "splat/kernel/kernel_set.h"
#include "splat/kernel/turning_kernel.h"
#include "splat/motion/cut.h"

namespace SWEPT_API swept {

class ObjectKernels;

/// What a kernel is made from: a point, counted over all objects, and a piece of its path.
struct KernelSource {
  std::uint32_t point, piece;
};

class KernelMaker {
 public:
  /// The scene must outlive it, and satisfy validate().
  KernelMaker(const Scene& scene, const Exposure& exposure, SegmentShape shape = SegmentShape::chords);
  ~KernelMaker();
  KernelMaker(KernelMaker&&) noexcept;

  [[nodiscard]] const Projection& projection() const { return projection_; }
  [[nodiscard]] double near() const { return near_; }

  /// How many kernels there will be, by some of the points of each object, and a little more.
  [[nodiscard]] std::size_t expected();

  /// No DiscTurn: the axes are those of the middle.
  using Visit = std::function<void(const KernelSource&, const MovingKernel&, const DiscTurn*)>;
  /// Cuts the paths of all points, by object and point, and visits what build_kernels() has of them. Once
  /// `stop` asks for it, it returns with what was met by then.
  KernelCounts make_all(const Visit& visit, const std::stop_token& stop);

  /// One that make_all() has visited. For any threads, after that.
  [[nodiscard]] MovingKernel make(const KernelSource& source, std::optional<DiscTurn>& turn) const;

 private:
  const Scene& scene_;
  Exposure exposure_;
  Projection projection_;
  double near_;
  std::vector<std::unique_ptr<ObjectKernels>> objects_;
  std::vector<std::size_t> first_point_;  ///< of each object
};

}  // namespace swept
