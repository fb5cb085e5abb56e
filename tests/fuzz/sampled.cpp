// Fuzzes the sampled engine on scenes of a few discs, on one cell of the film or several: finite pixels, the
// same bits for every instruction set, number of threads, order and crop, and the reference at the same
// instants.
#include <algorithm>
#include <cmath>
#include <utility>

#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "tests/fuzz/any_scene.h"

namespace swept {
namespace {

Image render(const Scene& scene, SampledOptions options, int threads = 1) {
  RenderControl control;
  control.threads = threads;
  Result<Rendered> rendered = render_sampled(scene, options, control);
  SWEPT_HOLDS(rendered.ok());
  return std::move(rendered->image);
}

/// Whether a fragment's weight decides by how much it shows, and not rounding alone whether it shows at all:
/// as with a disc that is edge-on to the last digit, or 10²⁰ times as long as it is far.
bool is_judged(const Scene& scene) {
  const ImageModel& model = scene.model;
  bool judged = model.coverage == Coverage::soft && model.edge_weight >= 0x1p-6 &&
                model.filter_radius_px >= 0x1p-4 && scene.camera.near >= 1e-6;
  const auto within = [&](const auto& vector) {
    judged = judged && static_cast<double>(vector.cwiseAbs().maxCoeff()) <= 1e4;
  };
  for (const LookAtKey& key : scene.camera.look_ats) within(key.eye), within(key.target);
  for (const Object& object : scene.objects) {
    for (const TransformKey& key : object.transform.keys) {
      within(key.translate), within(key.scale);
      judged = judged && std::abs(key.rotate_radians) <= 1e4;
    }
    for (const SurfelKey& key : object.cloud.keys)
      for (std::size_t i = 0; i < key.pose.size(); ++i)
        within(key.pose.position[i]), within(key.pose.axis_u[i]), within(key.pose.axis_v[i]);
    for (const Eigen::Vector3f& velocity : object.cloud.velocity) within(velocity);
  }
  return judged;
}

float brightest(const Scene& scene) {
  float largest = 1.0f;
  for (const Object& object : scene.objects)
    for (const Eigen::Vector3f& color : object.cloud.color)
      largest = std::max(largest, color.cwiseAbs().maxCoeff());
  return largest;
}

/// Both round, and a fragment at the very end of a surface's reach, or of the near plane, may fall on either
/// side: in one pixel of fifty.
void check_reference(const Image& image, const Scene& scene, int samples) {
  ReferenceOptions options;
  options.samples = samples;
  options.motion = ReferenceMotion::smooth;
  const Result<Rendered> reference = render_reference(scene, options, {.threads = 1});
  SWEPT_HOLDS(reference.ok());
  const double largest = double{brightest(scene)};
  std::size_t off = 0;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    double most = 0.0;
    for (std::size_t c = 0; c < 4; ++c)
      most =
          std::max(most, std::abs(double{image.rgba[4 * i + c]} - double{reference->image.rgba[4 * i + c]}) /
                             (c < 3 ? largest : 1.0));
    off += most > 1e-3 ? 1 : 0;
  }
  SWEPT_HOLDS(off * 50 <= image.pixel_count());
}

}  // namespace
}  // namespace swept

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swept;
  fuzz::Bytes bytes(data, size);
  SampledOptions options;
  options.samples = 2 * bytes.below(4);
  options.max_error_db = 20.0 + bytes.below(20);
  const bool large = bytes.flag();
  Scene scene = fuzz::any_scene(bytes);
  if (large) scene.film = {60 + 8 * scene.film.width, 60 + 8 * scene.film.height, 0, 0, 0, 0};
  // No number of instants brings the error of very bright points down to what is asked for.
  if (brightest(scene) > 16.0f) options.samples = std::max(options.samples, 2);
  if (const Status valid = scene.validate(); !valid) {
    const Result<Rendered> refused = render_sampled(scene, options);
    SWEPT_HOLDS(!refused && refused.error().reason == valid.error().reason);
    return 0;
  }
  const Image image = render(scene, options);
  fuzz::check_pixels(image);
  fuzz::check_same(image, render(fuzz::reversed(scene), options, 2));
  if (options.samples > 0 && is_judged(scene)) check_reference(image, scene, options.samples);
  options.implementation = 0;
  scene.film.crop_x = image.width / 2;
  scene.film.crop_y = image.height / 2;
  scene.film.crop_width = image.width - scene.film.crop_x;
  scene.film.crop_height = image.height - scene.film.crop_y;
  const Image crop = render(scene, options);
  for (int y = 0; y < crop.height; ++y)
    for (int x = 0; x < crop.width; ++x) {
      const auto a = static_cast<std::size_t>(y * crop.width + x),
                 b = static_cast<std::size_t>((y + crop.y) * image.width + x + crop.x);
      for (std::size_t c = 0; c < 4; ++c) SWEPT_HOLDS(crop.rgba[4 * a + c] == image.rgba[4 * b + c]);
      SWEPT_HOLDS(crop.depth[a] == image.depth[b]);
    }
  return 0;
}
