#include "abuffer/splats/film_still.h"

#include <memory>

#include "abuffer/parallel.h"

namespace swept {

FilmStill draw_still(const CellGrid& grid, const SplatRow& standing, const SplatRow& moving,
                     FilmSurfaces& surfaces, const FilmSurfaces::Instant& objects,
                     PerThread<SplatPainter>& painters, const std::vector<char>& keep,
                     std::vector<CellWork>& cells) {
  FilmStill still;
  still.width = grid.film.width, still.height = grid.film.height;
  still.rgba.resize(4 * static_cast<std::size_t>(still.width) * static_cast<std::size_t>(still.height));
  static const std::vector<SampledCell::Surface> no_surfaces;
  parallel_for_each_index(cells.size(), [&](std::size_t c) {
    CellWork& work = cells[c];
    auto sums = std::make_unique<CellOfSplats>();
    painters.local().add(work.cell, work.index, standing, moving,
                         surfaces.empty() ? no_surfaces : surfaces.begin(work.index).at(objects), {}, *sums);
    sums->copy_colors(work.cell, still.width, still.rgba);
    if (keep[work.index] == 0) return;
    work.sums = std::move(sums);
    work.has_middle = true;
    work.instants = 1;
  });
  return still;
}

}  // namespace swept
