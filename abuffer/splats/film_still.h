// The whole film at an instant, drawn before anything is known of how many instants it takes.
#pragma once

#include <vector>

#include "abuffer/parallel.h"
#include "abuffer/splats/cell_work.h"
#include "abuffer/splats/error_forecast.h"
#include "abuffer/splats/film_surfaces.h"

namespace swept {

/// Draws `cells`, all of the film's, and has them keep their sums where `keep` says so of a cell of the grid.
/// `standing` and `moving` are placed, `objects` those of `surfaces` at that time.
[[nodiscard]] FilmStill draw_still(const CellGrid& grid, const SplatRow& standing, const SplatRow& moving,
                                   FilmSurfaces& surfaces, const FilmSurfaces::Instant& objects,
                                   PerThread<SplatPainter>& painters, const std::vector<char>& keep,
                                   std::vector<CellWork>& cells);

}  // namespace swept
