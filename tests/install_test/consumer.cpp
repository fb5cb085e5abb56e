// Renders one disc that crosses the film, and writes the picture to the path given.
#include <cstdio>

#include <swept/abuffer/abuffer.h>
#include <swept/abuffer/sampled.h>
#include <swept/datasets/generators.h>
#ifdef WITH_GPU
#include <swept/gpu_passes/gpu_renderer.h>
#endif
#include <swept/splat/io/image_file.h>
#ifdef WITH_PCL
#include <swept/splat/io/pcl/point_cloud.h>
#endif
#include <swept/splat/scene.h>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  swept::Scene scene;
  scene.film.width = 64;
  scene.film.height = 48;
  scene.camera.look_ats.emplace_back();
  swept::SurfelPose disc{{{0, 0, 0}}, {{0.5f, 0, 0}}, {{0, 0.5f, 0}}};
  scene.objects.emplace_back().cloud.keys.push_back({0.0, disc});
  scene.objects.back().cloud.velocity = {{1, 0, 0}};

  const swept::Result<swept::Rendered> exact = swept::render_abuffer(scene);
  if (!exact) return std::fprintf(stderr, "%s\n", exact.error().message().c_str()), 1;
  const swept::Result<swept::Rendered> rendered = swept::render_sampled(scene);
  if (!rendered) return std::fprintf(stderr, "%s\n", rendered.error().message().c_str()), 1;
  const swept::Status written = swept::write_exr(argv[1], rendered->image);
  if (!written) return std::fprintf(stderr, "%s\n", written.error().message().c_str()), 1;

  if (!swept::generate("sphere", 100, {})) return 1;

#ifdef WITH_PCL
  const auto points = swept::pcl_from_cloud(scene.objects[0].cloud, 0.0);
  if (!points || !swept::cloud_from_pcl(*points, 0.0)) return 1;
#endif

#ifdef WITH_GPU
  if (swept::Result<swept::GpuRenderer> gpu = swept::GpuRenderer::create(); !gpu)
    std::printf("%s\n", gpu.error().message().c_str());
  else if (!gpu->render(scene))
    return 1;
#endif

  const swept::Result<swept::Image> read = swept::read_exr(argv[1]);
  if (!read) return std::fprintf(stderr, "%s\n", read.error().message().c_str()), 1;
  float coverage = 0;
  for (std::size_t i = 3; i < read->rgba.size(); i += 4) coverage += read->rgba[i];
  std::printf("covered %.1f px\n", static_cast<double>(coverage));
  return coverage > 0 && read->rgba == rendered->image.rgba ? 0 : 1;
}
