// Several renders at once: the library keeps nothing between them, and so they need no lock.
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/layers.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "small_scenes.h"

namespace swept {
namespace {

Scene scene_of(int number) {
  Scene scene = test::stage();
  Object& object = scene.objects.emplace_back(test::checkered_sphere(0.6 + 0.1 * number, 300 + 50 * number));
  object.cloud.velocity.assign(object.cloud.size(), {0.2f + 0.1f * static_cast<float>(number), 0.0f, 0.0f});
  return scene;
}

/// Discs, splats and a mesh, moving among each other.
Scene mixed_scene(int number) {
  Scene scene = scene_of(number);
  Object& mesh = scene.objects.emplace_back(test::checkered_sphere(0.3, 60));
  for (std::uint32_t i = 0; i + 2 < 60; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
  mesh.cloud.velocity.assign(60, {-0.4f, 0.2f, 0.5f});
  SplatCloud& splats = scene.objects.emplace_back().splats;
  test::Random random(static_cast<unsigned>(number));
  for (int i = 0; i < 400; ++i) {
    splats.position.push_back(random.vector(-1.0, 1.0));
    splats.scale.push_back(Eigen::Vector3f::Constant(0.05f));
    splats.rotation.push_back(Eigen::Quaternionf::Identity());
    splats.opacity.push_back(0.5f);
    splats.velocity.push_back(random.vector(-0.3, 0.3).cast<float>());
  }
  splats.harmonics.assign(3 * splats.size(), 0.5f);
  return scene;
}

/// Each of the methods, for two scenes.
Result<Rendered> render(int number, const Scene& scene) {
  switch (number % 4) {
    case 0:
      return render_sampled(scene, {.max_error_db = 45.0}, {.threads = 2});
    case 1:
      return render_abuffer(scene, {}, {.threads = 2});
    case 2:
      return render_reference(scene, {.samples = 8}, {.threads = 2});
    default: {
      Result<std::vector<ImageChannel>> layers =
          render_layers(scene, {.normal = true, .motion = true, .coverage = true}, {.threads = 2});
      if (!layers) return layers.error();
      Rendered rendered;
      for (const ImageChannel& channel : *layers)
        rendered.image.rgba.insert(rendered.image.rgba.end(), channel.values.begin(), channel.values.end());
      return rendered;
    }
  }
}

TEST(Threads, EightRenderDifferentScenesAtOnce) {
  constexpr int count = 8;
  std::vector<std::vector<float>> alone, together(count);
  for (int i = 0; i < count; ++i) alone.push_back(render(i, scene_of(i)).value().image.rgba);
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < count; ++i)
      threads.emplace_back([i, &together] {
        const Scene scene = scene_of(i);
        for (int again = 0; again < 2; ++again) {
          Result<Rendered> rendered = render(i, scene);
          if (rendered) together[static_cast<std::size_t>(i)] = std::move(rendered->image.rgba);
        }
      });
  }
  for (int i = 0; i < count; ++i)
    EXPECT_EQ(together[static_cast<std::size_t>(i)], alone[static_cast<std::size_t>(i)]) << i;
}

void expect_eight_to_render(const Scene& scene) {
  const std::vector<float> alone = render_sampled(scene, {.max_error_db = 45.0}).value().image.rgba;
  std::vector<std::vector<float>> together(8);
  {
    std::vector<std::jthread> threads;
    for (std::vector<float>& image : together)
      threads.emplace_back([&] {
        Result<Rendered> rendered = render_sampled(scene, {.max_error_db = 45.0}, {.threads = 2});
        if (rendered) image = std::move(rendered->image.rgba);
      });
  }
  for (const std::vector<float>& image : together) EXPECT_EQ(image, alone);
}

TEST(Threads, EightRenderOneScene) { expect_eight_to_render(scene_of(3)); }

TEST(Threads, EightRenderOneSceneOfDiscsSplatsAndAMesh) { expect_eight_to_render(mixed_scene(3)); }

}  // namespace
}  // namespace swept
