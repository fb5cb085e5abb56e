// What the samples of a block of pixels met, and the pixels that come of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "abuffer/stochastic/pixel_samples.h"
#include "splat/interval/composite.h"
#include "splat/interval/side.h"
#include "splat/render_control.h"

namespace swept::stochastic {

/// A triangle, met by sample `sample`.
struct LayerHit {
  std::uint32_t sample;
  double z;
  float rgba[4];  ///< premultiplied
};

/// A disc, likewise.
struct DiscHit {
  std::uint32_t sample;
  double z;
  float weight;     ///< ρ
  float tolerance;  ///< ε
  Side side;
  float rgba[4];  ///< premultiplied
};

/// Entries are those of BlockSamples. What is kept, and how it is composed, does not depend on the order in
/// which hits are added.
class SampleHits {
 public:
  void start(std::size_t samples);

  /// Of opaque triangles, the depth of the nearest so far.
  [[nodiscard]] double nearest(std::size_t sample) const { return nearest_[sample].z; }
  void add(const LayerHit& hit, bool opaque);
  void add(const DiscHit& hit) { discs_.push_back(hit); }

  /// Orders what was added by sample. Once, before the pixels are composed.
  void finish();
  /// The sum over the `count` samples from `first` on, over no background: each a still image of model
  /// section 1, with triangles among the surfaces of discs as section 15.4 has it.
  [[nodiscard]] PixelSum compose(std::size_t first, std::size_t count, const SurfaceModel& model);

 private:
  struct Surface {
    SurfaceSum sum;
    float depth;
  };
  void gather_surfaces(std::size_t sample);

  std::vector<LayerHit> nearest_;  ///< of opaque triangles, by sample
  std::vector<LayerHit> layers_;   ///< of the others
  std::vector<DiscHit> discs_;
  std::vector<std::uint32_t> layer_begin_,
      disc_begin_;                 ///< by sample, and the end; empty where there are none
  std::vector<Surface> surfaces_;  ///< of a sample's discs
  std::vector<DiscHit> rest_;
};

}  // namespace swept::stochastic
