// Fuzzes the whole way from a scene to its image: a few discs, edge-on, huge, tiny, coincident, behind the
// eye, fast, on a few pixels. A valid scene renders to finite pixels; order, tiles and crops change no bit.
#include <algorithm>
#include <utility>

#include "abuffer/abuffer.h"
#include "tests/fuzz/any_scene.h"

namespace swept {
namespace {

using fuzz::any_scene, fuzz::check_pixels, fuzz::check_same, fuzz::reversed;

Image render(const Scene& scene, int tile_px = 32, std::size_t tile_fragments = 1u << 20) {
  AbufferOptions options;
  options.tile_px = tile_px;
  options.tile_fragments = tile_fragments;
  Result<Rendered> rendered = render_abuffer(scene, options, {.threads = 1});
  SWEPT_HOLDS(rendered.ok());
  return std::move(rendered->image);
}

}  // namespace
}  // namespace swept

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swept;
  fuzz::Bytes bytes(data, size);
  Scene scene = any_scene(bytes);
  if (const Status valid = scene.validate(); !valid) {
    const Result<Rendered> refused = render_abuffer(scene);
    SWEPT_HOLDS(!refused && refused.error().reason == valid.error().reason);
    return 0;
  }
  const Image image = render(scene);
  check_pixels(image);
  check_same(image, render(reversed(scene)));
  check_same(image, render(scene, 1, 1));
  scene.film.crop_x = image.width - 1;
  scene.film.crop_y = image.height - 1;
  scene.film.crop_width = scene.film.crop_height = 1;
  const Image corner = render(scene);
  SWEPT_HOLDS(std::equal(corner.rgba.begin(), corner.rgba.end(), image.rgba.end() - 4));
  SWEPT_HOLDS(corner.depth[0] == image.depth.back());
  return 0;
}
