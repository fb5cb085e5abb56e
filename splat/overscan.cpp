#include "splat/overscan.h"

namespace swept {

Scene widened(const Scene& scene) {
  Scene wide = scene;
  Film& film = wide.film;
  const Film& own = scene.film;
  film = {own.window_width(), own.window_height()};
  const double height = own.height, taller = film.height / height;
  // Rows keep their times: the first is another one now.
  const double sooner = scene.shutter.row_delay * own.overscan_top;
  wide.shutter.open -= sooner;
  wide.shutter.close -= sooner;
  const auto widen = [&](auto& keys) {
    for (auto& key : keys) {
      key.tan_half_fov_y *= taller;
      // From the upper left corner, which is farther away, to heights of the larger film from its middle.
      const double x = 0.5 * own.width + height * key.lens.shift.x() + own.overscan_left;
      const double y = 0.5 * own.height + height * key.lens.shift.y() + own.overscan_top;
      key.lens.shift = {(x - 0.5 * film.width) / film.height, (y - 0.5 * film.height) / film.height};
    }
  };
  widen(wide.camera.poses);
  widen(wide.camera.look_ats);
  return wide;
}

}  // namespace swept
