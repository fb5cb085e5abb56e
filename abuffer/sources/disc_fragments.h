// Fragments of moving discs. For the project's own sources. Source: model sections 2 and 6.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "abuffer/sources/fragment_source.h"
#include "abuffer/tiles/bins.h"
#include "splat/kernel/kernel_maker.h"
#include "splat/kernel/kernel_order.h"

namespace swept {

/// What all threads share of the discs of a scene: not their kernels, which a thread makes as a tile needs
/// them.
struct DiscFilm {
  KernelMaker maker;
  KernelCounts counts;
  std::size_t kernels = 0;
  KernelOrder order;
  TileBins bins;
  RasterModel raster;  ///< `backs` is of a tile
  std::size_t fragment_limit;

  /// The scene must outlive it. Bins that take more than `max_bytes` are left as they are by then; 0: none
  /// do. Throws Stopped once `stop` asks for it.
  DiscFilm(const Scene& scene, const Window& window, SegmentShape shape, int tile_px, std::size_t limit,
           const std::stop_token& stop, std::size_t max_bytes = 0);
};

class DiscFragments final : public FragmentSource {
 public:
  /// `film` must outlive it.
  explicit DiscFragments(const DiscFilm& film, bool simd = true) : film_(film), raster_(film.raster) {
    raster_.simd = simd;
  }

  void select(std::size_t tile) override;
  [[nodiscard]] bool gather(const Window& window) override;
  /// Of a tile's window, the part outside of which nothing that was selected moves; what does not come by it
  /// is put away.
  [[nodiscard]] Window keep_what_moves(const Window& window);

  [[nodiscard]] const DiscFilm& film() const { return film_; }
  [[nodiscard]] const FragmentArrays& fragments() const { return fragments_; }
  /// Of the tile's kernels, and how they change; that is empty where none does.
  [[nodiscard]] const std::vector<Shade>& shades() const { return shades_; }
  [[nodiscard]] const std::vector<ShadeChange>& changes() const { return changes_; }
  /// Whether the depth tolerance of any of the tile's kernels changes.
  [[nodiscard]] bool tolerances_change() const { return tolerances_change_; }
  /// Indices of the fragments of a pixel, which is counted row by row within the window. They are in the
  /// order of the kernels, and may be put into another.
  [[nodiscard]] std::span<std::uint32_t> of_pixel(std::size_t local) {
    return std::span(sorted_).subspan(starts_[local], starts_[local + 1] - starts_[local]);
  }
  /// Whether any fragment of the pixel is not is_still(), or changes its colour.
  [[nodiscard]] bool moves(std::size_t local) const { return moving_[local] != 0; }
  [[nodiscard]] bool changes_color(std::size_t local) const {
    return !changing_.empty() && changing_[local] != 0;
  }

 private:
  struct BoundedKernel {
    std::uint64_t key;          ///< of KernelOrder
    std::uint32_t index, turn;  ///< `no_turn`: none
    Octagon octagon;
  };
  static constexpr std::uint32_t no_turn = ~0u;
  [[nodiscard]] const DiscTurn* turn_of(const BoundedKernel& kernel) const {
    return kernel.turn == no_turn ? nullptr : &turns_[kernel.turn];
  }
  [[nodiscard]] bool before(const BoundedKernel& a, const BoundedKernel& b) const;
  void sort_by_pixel(const Window& window);

  const DiscFilm& film_;
  std::vector<MovingKernel> kernels_;  ///< of the tile
  std::vector<DiscTurn> turns_;        ///< of some of these
  std::vector<Shade> shades_;
  std::vector<ShadeChange> changes_;
  bool tolerances_change_ = false;
  RasterModel raster_;
  std::vector<BoundedKernel> octagons_;  ///< of these, in KernelOrder
  FragmentArrays fragments_;
  std::vector<std::uint32_t> starts_, fill_, sorted_;
  std::vector<std::uint8_t> moving_, changing_;  ///< by pixel
};

}  // namespace swept
