// Several renders at once: the library keeps nothing between them, and so they need no lock.
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

TEST(Threads, EightRenderOneScene) {
  const Scene scene = scene_of(3);
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

}  // namespace
}  // namespace swept
