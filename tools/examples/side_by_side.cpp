// One scene by three methods, side by side in one picture, and how far two of them are from the first.
//
// side_by_side [PICTURE.exr]: left the exact image, in the middle the sampled one, on the right the GPU's
// where there is one.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <swept/abuffer/abuffer.h>
#include <swept/abuffer/sampled.h>
#ifdef WITH_GPU
#include <swept/gpu_passes/gpu_renderer.h>
#endif
#include <swept/splat/compare/metrics.h>
#include <swept/splat/io/image_file.h>
#include <swept/splat/pixel_target.h>

namespace {

swept::Scene ring_of_discs() {
  swept::Scene scene;
  scene.film = {160, 120, 0, 0, 0, 0};
  scene.camera.look_ats.emplace_back();
  swept::SurfelCloud& cloud = scene.objects.emplace_back().cloud;
  cloud.keys.resize(1);
  swept::SurfelPose& pose = cloud.keys[0].pose;
  for (int i = 0; i < 60; ++i) {
    const double angle = 2.0 * 3.14159265358979 * i / 60.0;
    pose.position.emplace_back(1.2 * std::cos(angle), 1.2 * std::sin(angle), 0.0);
    pose.axis_u.emplace_back(0.1f, 0.0f, 0.0f);
    pose.axis_v.emplace_back(0.0f, 0.1f, 0.0f);
    cloud.velocity.emplace_back(static_cast<float>(-0.8 * std::sin(angle)),
                                static_cast<float>(0.8 * std::cos(angle)), 0.0f);
    cloud.color.emplace_back(0.5f + 0.5f * static_cast<float>(std::cos(angle)), 0.4f, 0.3f);
  }
  return scene;
}

struct Named {
  std::string name;
  swept::Result<swept::Rendered> rendered;
};

}  // namespace

int main(int argc, char** argv) {
  const swept::Scene scene = ring_of_discs();
  std::vector<Named> pictures;
  pictures.push_back({"exact", swept::render_abuffer(scene)});
  pictures.push_back({"sampled", swept::render_sampled(scene)});
#ifdef WITH_GPU
  if (swept::Result<swept::GpuRenderer> gpu = swept::GpuRenderer::create())
    pictures.push_back({"gpu", gpu->render(scene, {.subframes = 8})});
  else
    std::printf("gpu: %s\n", gpu.error().message().c_str());
#endif
  for (const Named& picture : pictures)
    if (!picture.rendered)
      return std::fprintf(stderr, "%s: %s\n", picture.name.c_str(),
                          picture.rendered.error().message().c_str()),
             1;

  const int width = scene.film.width, height = scene.film.height, count = static_cast<int>(pictures.size());
  swept::Image together = swept::blank_image({width * count, height, 0, 0, 0, 0});
  for (int i = 0; i < count; ++i) {
    const swept::Image& image = pictures[static_cast<std::size_t>(i)].rendered->image;
    const swept::PixelTarget part{
        &together.rgba[static_cast<std::size_t>(4 * width * i)], width, height, 4, 0, 16 * width * count};
    if (const swept::Status copied = swept::copy_pixels(image, part); !copied) return 1;
    if (i == 0) continue;
    const swept::Result<swept::ImageMetrics> difference =
        swept::compare_images(pictures[0].rendered->image, image);
    if (!difference) return 1;
    std::printf("%s against exact: %.1f dB\n", pictures[static_cast<std::size_t>(i)].name.c_str(),
                difference->psnr_db);
    // The sampled image was asked for 60 dB; of six passes, 8 sub-frames are near, not equal.
    if (difference->psnr_db < 30.0) return 1;
  }
  const swept::Status written = swept::write_exr(argc > 1 ? argv[1] : "side_by_side.exr", together);
  if (!written) return std::fprintf(stderr, "%s\n", written.error().message().c_str()), 1;
}
