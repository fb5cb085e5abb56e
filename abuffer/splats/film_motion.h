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
#include "abuffer/splats/near_jumps.h"
#include "abuffer/splats/splat_packets.h"
#include "abuffer/splats/splat_row.h"

namespace swept {

class FilmMotion {
 public:
  /// One of so many pixels each way is looked at.
  static constexpr int pitch_px = 4;

  /// Along what way the picture moves through a pixel over the exposure, px.
  struct Way {
    float x = 0.0f, y = 0.0f;
    float spread = 0.0f;  ///< the same in standard deviations of what moves
  };

  /// Follows every splat of `sets` that moves. Runs in the caller's task arena.
  FilmMotion(const Scene& scene, const Exposure& exposure, const std::vector<SplatPackets>& sets,
             const SplatMath& math, const CellGrid& grid);

  /// Looks for spread(). `standing` are placed, in the whole film.
  void look_for_spreads(const Scene& scene, const Exposure& exposure, const std::vector<SplatPackets>& sets,
                        const SplatRow& standing, const SplatMath& math, const CellGrid& grid);

  /// Whether anything moves in a cell at any time of the exposure, perhaps.
  [[nodiscard]] bool moves(std::size_t cell) const { return touched_[cell] != 0; }
  /// What few of its pixels exceed at the exposure's ends and in its middle: √(Σ α T r²), r the motion of a
  /// splat in its own standard deviations. Of every fourth pixel each way.
  [[nodiscard]] float spread(std::size_t cell) const { return spread_[cell]; }
  /// Looks for ways() and jumps at an instant.
  void look_for_ways(const Scene& scene, const std::vector<SplatPackets>& sets, double frame,
                     const SplatRow& standing, const SplatMath& math, const CellGrid& grid);
  /// Of what was finest at a pixel of the film then, or comes by before or after.
  [[nodiscard]] Way way(int x, int y) const {
    return ways_.empty() ? Way{}
                         : ways_[static_cast<std::size_t>(y / pitch_px) * way_columns_ +
                                 static_cast<std::size_t>(x / pitch_px)];
  }
  /// What changes of depth order make of the N-instants' mean square in a cell, times N².
  [[nodiscard]] double jumps_of(std::size_t cell) const { return jumps_of_.empty() ? 0.0 : jumps_of_[cell]; }
  /// The most of it, times N², where splats pass the near plane on the film.
  [[nodiscard]] double near_jumps_of(std::size_t cell) const {
    return near_jumps_of_.empty() ? 0.0 : near_jumps_of_[cell];
  }
  /// The exposure in standard deviations of how the briefest splat comes and goes that is there then, seen at
  /// some instant or not; 0: none does.
  [[nodiscard]] float briefest() const { return briefest_; }
  /// The longest way of a splat on the film, px, and the same in its standard deviations.
  [[nodiscard]] float fastest_px() const { return fastest_px_; }
  [[nodiscard]] float fastest_spread() const { return fastest_spread_; }

 private:
  /// What a splat does: its way from open to close, as long as its path is, and its depths then; 0: unseen.
  struct Path {
    Way way;
    float first_depth = 0.0f, last_depth = 0.0f;
    float fade = 0.0f;  ///< the exposure in standard deviations of how it comes and goes
  };
  using Paths = std::vector<Path>;
  enum class Look { spreads, ways, first_order, last_order };

  void follow(const Scene& scene, const Exposure& exposure, const SplatPackets& set, const SplatMath& math,
              const CellGrid& grid, Paths& paths);
  /// A splat at an instant on a film of one of every few pixels, and how many standard deviations a pixel is.
  struct CoarseSplat {
    PlacedSplat splat;
    Path path;
    float per_px;
    bool disc;
  };

  [[nodiscard]] std::vector<CoarseSplat> gather(const Scene& scene, const std::vector<SplatPackets>& sets,
                                                double frame, const SplatRow& standing,
                                                const SplatMath& math) const;
  void draw(const Scene& scene, const std::vector<CoarseSplat>& seen, const SplatMath& math,
            const CellGrid& grid, Look what);
  void take_spreads(const SplatTile& tile, int x, int y, const CellGrid& grid);
  void take_order(const SplatTile& tile, int x, int y, const CellGrid& grid, bool linear, Look which);
  void take_ways(const SplatTile& tile, int x, int y);
  void spread_ways(const Film& film);

  std::vector<char> touched_;
  std::vector<float> spread_;
  std::vector<Paths> of_sets_;
  std::vector<Way> ways_;      ///< of every few pixels, whole tiles
  std::vector<float> colors_;  ///< the same in the order that splats have first, linear
  std::vector<double> jumps_of_, near_jumps_of_;
  std::vector<NearSplat> near_splats_;
  std::size_t way_columns_ = 0;
  float fastest_px_ = 0.0f, fastest_spread_ = 0.0f, briefest_ = 0.0f;
};

/// Instants to begin with for `spread` and an error in dB, of 2, 3, 4, 6, 8, 12, …
[[nodiscard]] int first_splat_instants(float spread, double max_error_db);

}  // namespace swept
