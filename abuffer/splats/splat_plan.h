// How many instants every cell of a frame of splats begins with.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "abuffer/lens_looks.h"
#include "abuffer/parallel.h"
#include "abuffer/splats/cell_work.h"
#include "abuffer/splats/film_motion.h"
#include "abuffer/splats/film_surfaces.h"
#include "abuffer/splats/splat_cell.h"
#include "abuffer/splats/splat_packets.h"

namespace swept {

/// What a frame of splats is drawn from; outlives its plan.
struct SplatFilm {
  const Scene& scene;
  const SampledOptions& options;
  const Exposure& exposure;
  const CellGrid& grid;
  const SplatMath& math;
  const LensLooks& lens;
  const std::vector<SplatPackets>& sets;
  FilmSurfaces& surfaces;
  PerThread<SplatPainter>& painters;
  const std::vector<char>& window;  ///< of every cell of the grid: whether any of it is asked for
};

struct SplatPlan {
  std::vector<CellWork> cells;         ///< of the window, in the grid's order
  std::unique_ptr<FilmMotion> motion;  ///< null where no splat moves, and through a lens
  double allowed_mean_square = 0.0;    ///< error that a moving cell may have
  int instants_of_a_point = 1;         ///< of the lens, where its points are given
  std::size_t placed_instants = 0;     ///< that planning took
};

[[nodiscard]] SplatPlan plan_splats(const SplatFilm& film);

}  // namespace swept
