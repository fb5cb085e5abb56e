// Pixels beyond the film's edges, as the pixels of a larger film.
#pragma once

#include <utility>

#include "splat/export.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// The same picture of a film that has the overscan within it: focal length and principal point stay where
/// they are, in pixels. A copy of the whole scene. Throws std::bad_alloc.
[[nodiscard]] Scene widened(const Scene& scene);

/// render(scene), or of a scene with overscan that of the widened scene, seen from the scene's own film.
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
