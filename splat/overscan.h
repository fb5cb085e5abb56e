// Pixels beyond the film's edges, as the pixels of a larger film.
#pragma once

#include <utility>

#include "splat/export.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// A copy of the scene whose film includes the overscan. Focal length and principal point stay as they are,
/// in pixels, so that the picture is the same. Throws std::bad_alloc.
[[nodiscard]] Scene widened(const Scene& scene);

/// render(scene); for a scene with overscan render(widened(scene)), with windows relative to the scene's own
/// film.
template <class Render>
[[nodiscard]] Result<Rendered> render_overscan(const Scene& scene, const Render& render) {
  if (!scene.film.has_overscan()) return render(scene);
  Result<Rendered> rendered = render(widened(scene));
  if (!rendered) return rendered;
  const Film& film = scene.film;
  rendered->image.x -= film.overscan_left;
  rendered->image.y -= film.overscan_top;
  rendered->image.film_width = film.width;
  rendered->image.film_height = film.height;
  for (FilmPart& part : rendered->parts) {
    part.x -= film.overscan_left;
    part.y -= film.overscan_top;
  }
  return rendered;
}

}  // namespace swept
