// One cell of the film at one instant after another, all of it in the cache. Source: model sections 1 and 12.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "abuffer/resolve/cell_image.h"
#include "abuffer/sources/object_instant.h"
#include "abuffer/tiles/cells.h"
#include "abuffer/tiles/point_lists.h"

namespace swept {

struct SampledCounters {
  std::uint64_t instants = 0;        ///< of cells
  std::uint64_t packets = 0;         ///< that came by a cell at an instant
  std::uint64_t packets_hidden = 0;  ///< of these, those that a front surface hides
  std::uint64_t general_discs = 0;   ///< placed by the general formulas
  std::uint64_t fragments_behind = 0;

  void add(const SampledCounters& other) {
    instants += other.instants;
    packets += other.packets;
    packets_hidden += other.packets_hidden;
    general_discs += other.general_discs;
    fragments_behind += other.fragments_behind;
  }
};

/// A thread's: memory is kept from cell to cell.
class SampledCell {
 public:
  SampledCell(const Scene& scene, const std::vector<PointPackets>& objects, const SampledMath& math);

  /// Begins a cell. `packets` must outlive what is done with it.
  void begin(const Cell& cell, std::span<const PacketRef> packets);
  /// The same of packets of its own.
  void begin(const Cell& cell, CellPackets packets);
  /// Goes on, right after begin(), with one that was left at `so_far`, which image(1, so_far) had given.
  void resume(const CellImage& so_far);

  /// Adds the image at an instant, one ObjectInstant for each object.
  void add(std::span<const ObjectInstant> instants, const InstantWeights& weights);

  /// A surface in a pixel: premultiplied, linear.
  struct Surface {
    int x, y;  ///< pixel of the cell
    float depth, rgba[4];
  };
  /// The surfaces at an instant, in each pixel from the nearest to the farthest; nothing is added to any sum.
  const std::vector<Surface>& surfaces(std::span<const ObjectInstant> instants);

  /// Σ over pixels of squared sums, the background included.
  struct Squares {
    double alternating = 0.0;  ///< of R, G and B
    double grey = 0.0;         ///< of their sum
    double quarter = 0.0;      ///< of the sums of every other instant, even and odd, of R + G + B
  };
  [[nodiscard]] Squares squares() const;
  /// Of each pixel of cell_px × cell_px, the alternating sums' squares over R, G and B, times `scale`.
  void alternating_squares(double scale, std::vector<float>& out) const;
  /// Makes the alternating sums those of all instants so far, which have `weight` in all.
  void alternate_from_sums(double weight);

  /// Σ weight·image, of `total` weight.
  void image(double total, CellImage& out);

  SampledCounters counters;

 private:
  struct Visible {
    PacketRef ref;
    Eigen::Vector3d center;
    PacketBounds bounds;
    /// Patches of the cell that it may touch, both ends included.
    int patch_x_first = 0, patch_x_last = 0, patch_y_first = 0, patch_y_last = 0;
    std::size_t general_begin = 0, general_end = 0;
    bool placed = false;
  };
  /// Of a disc's index: it is one of general_.
  static constexpr std::uint32_t general_flag = 1u << 31;
  struct Layer {
    float depth, weight;
    std::uint32_t disc, order;  ///< order: of the points
  };
  struct LayerSum {
    float weight = 0.0f, rgba[4] = {0.0f, 0.0f, 0.0f, 0.0f}, depth = 0.0f;
  };

  void draw(std::span<const ObjectInstant> instants);
  void select(std::span<const ObjectInstant> instants);
  void place(std::size_t i, std::span<const ObjectInstant> instants);
  [[nodiscard]] bool shows_other_side(const GeneralDisc::Fragment& f, int pixel) const;
  void bring_general_to_front(const GeneralDisc& disc);
  void add_general_to_front(const GeneralDisc& disc);
  void find_general_behind(const GeneralDisc& disc, std::uint32_t index);
  void shade_behind(std::span<const ObjectInstant> instants, int y_begin, int y_end);
  bool gather_behind(std::span<const ObjectInstant> instants, bool may_give_up);
  void shade_layers(std::size_t begin, std::size_t end);
  [[nodiscard]] static int side_of(const Layer& fragment);
  void add_to_layer(const Layer& fragment, LayerSum& sum) const;
  void shade_layer(const LayerSum& sum, std::uint32_t pixel, float& through);
  [[nodiscard]] bool hidden(const Visible& v) const;
  [[nodiscard]] bool lit(const Visible& v) const;
  [[nodiscard]] float tolerance_of(std::uint32_t disc) const;
  [[nodiscard]] const float* color_of(std::uint32_t disc, float (&rgba)[4]) const;
  void flush();

  const Scene& scene_;
  std::vector<const PointPackets*> all_objects_;
  CellPackets own_;
  std::span<const PointPackets* const> objects_;  ///< that the packets are of
  const SampledMath& math_;
  SurfaceRule rule_;
  float background_[3];
  Cell cell_;
  std::span<const PacketRef> packets_;

  std::unique_ptr<CellBuffers> buffers_;
  std::unique_ptr<CellSums> sums_;
  CellImage total_;
  int unflushed_ = 0;
  bool flushed_ = false;

  std::vector<Visible> visible_;  ///< in content order
  std::vector<std::uint32_t> nearest_first_;
  std::vector<PlacedPacket> placed_;
  std::vector<GeneralDisc> general_;
  std::vector<float> behind_limits_;  ///< CellBuffers::behind of all rows, while some are looked at
  std::vector<FragmentBehind> behind_;
  std::size_t behind_count_ = 0;
  std::vector<std::uint32_t> starts_, sorted_;
  std::vector<Layer> layers_;
  bool keeps_surfaces_ = false;
  std::vector<Surface> surfaces_;
};

}  // namespace swept
