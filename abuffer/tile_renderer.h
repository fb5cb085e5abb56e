// The tiles of the exact method: fragments of a window from every source, then pixel by pixel. For the
// project's own sources.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "abuffer/abuffer.h"
#include "abuffer/exact_meshes.h"
#include "abuffer/film_sink.h"
#include "abuffer/resolve/exact_pixel.h"
#include "abuffer/sources/disc_fragments.h"
#include "abuffer/sweep_counts.h"

namespace swept {

/// What all threads share. What is null the scene does not have.
struct TileWork {
  const DiscFilm* discs = nullptr;
  const MeshFilm* meshes = nullptr;
  const Image* standing = nullptr;  ///< what does not move, where that is known
  SurfaceModel model, model_by_interval;
  bool simd = true;
  std::stop_token stop;
};

/// One thread's. Its memory is kept from tile to tile.
class TileRenderer {
 public:
  TileRenderer(const TileWork& work, const FilmSink& film);
  TileRenderer(TileRenderer&&) = default;

  void render(std::size_t tile, const Window& window);
  /// Of all tiles it has rendered.
  [[nodiscard]] SweepCounts counts() const;

 private:
  void render_part(const Window& window, bool whole, int halvings = 0);
  [[nodiscard]] int gather(const Window& window);
  [[nodiscard]] Window select_what_moves(std::size_t tile, const Window& window);
  void resolve(const Window& window);
  void resolve_pixel(const Window& window, int x, int y, std::size_t local);
  void copy_standing(int x, int y);
  void store_standing(int x, int y, const PixelSum& pixel, const DiscsOfPixel& discs);

  const TileWork& work_;
  FilmSink film_;
  std::optional<DiscFragments> discs_;
  std::optional<MeshFragments> meshes_;
  ExactPixel pixel_;
  StillPixel still_by_interval_;
  bool copies_standing_;  ///< what does not move is there as it is to be
  SweepCounts counters_;
};

}  // namespace swept
