// Layers that never merge, each a surface by itself, which change their order within a piece of time.
//
// Two neighbours that swap change what they give and nothing else: the light before and behind them stays. So
// a piece costs its layers and its swaps, however many there are, instead of all layers again at each of
// them.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/interval/composite.h"

namespace swept {

/// One layer over a piece, as a straight line in time: `mean` and `swing` are premultiplied colour times
/// coverage, to be taken as those of FrontSum.
struct AloneLayer {
  float mean[4], swing[4];
  float z_begin, z_end;  ///< depth at the piece's ends
};

class AloneStack {
 public:
  std::vector<AloneLayer> layers;  ///< front to back as the piece begins

  /// Adds all layers over a piece that lasts `duration` of the exposure.
  void composite(double duration, PixelSum& pixel);

 private:
  struct Swap {
    double time;  ///< a share of the piece
    std::uint32_t before, behind;
  };
  struct Light {
    double mean[4], depth;
  };

  void find_swaps();
  bool swap(const Swap& crossing, double duration, PixelSum& pixel);

  std::vector<std::uint32_t> order_;     ///< position → layer
  std::vector<std::uint32_t> position_;  ///< layer → position
  std::vector<double> light_[2];         ///< what is left before a position, at Gauss's two points
  std::vector<Swap> swaps_, waiting_;
};

}  // namespace swept
