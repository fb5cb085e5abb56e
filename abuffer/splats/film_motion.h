// How far splats move across the film during an exposure, and how many instants that takes.
//
// Source: model section 14. A pixel's signal while a splat passes by is a bell whose width is the splat's
// own: N stills give its mean to any accuracy from about N = r/2 on, r being its motion in its standard
// deviations.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "abuffer/simd/splat_math.h"
#include "abuffer/splats/splat_packets.h"
#include "abuffer/splats/splat_row.h"

namespace swept {

class FilmMotion {
 public:
  /// Follows every splat of `sets` that moves. `standing` are placed. Runs in the caller's task arena.
  FilmMotion(const Scene& scene, const Exposure& exposure, const std::vector<SplatPackets>& sets,
             const SplatRow& standing, const SplatMath& math, const CellGrid& grid);

  /// Whether anything moves in a cell at any time of the exposure, perhaps.
  [[nodiscard]] bool moves(std::size_t cell) const { return touched_[cell] != 0; }
  /// What few of its pixels exceed at the exposure's ends and in its middle: √(Σ α T r²), r the motion of a
  /// splat in its own standard deviations. Of every fourth pixel each way.
  [[nodiscard]] float spread(std::size_t cell) const { return spread_[cell]; }
  /// Whether a splat on the film passes the near plane: it covers much of the film, and all at once no more.
  [[nodiscard]] bool jumps() const { return jumps_; }
  /// The longest way of a splat on the film, px, and the same in its standard deviations.
  [[nodiscard]] float fastest_px() const { return fastest_px_; }
  [[nodiscard]] float fastest_spread() const { return fastest_spread_; }

 private:
  void follow(const Scene& scene, const Exposure& exposure, const SplatPackets& set, const SplatMath& math,
              const CellGrid& grid, std::vector<float>& spreads);
  void look(const Scene& scene, const std::vector<SplatPackets>& sets,
            const std::vector<std::vector<float>>& spreads, double frame, const SplatRow& standing,
            const SplatMath& math, const CellGrid& grid);

  std::vector<char> touched_;
  std::vector<float> spread_;
  bool jumps_ = false;
  float fastest_px_ = 0.0f, fastest_spread_ = 0.0f;
};

/// Instants to begin with for `spread` and an error in dB, of 2, 3, 4, 6, 8, 12, …
[[nodiscard]] int first_splat_instants(float spread, double max_error_db);

}  // namespace swept
