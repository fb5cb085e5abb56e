// Pixels beyond the film's edges: those of a larger film, and those within are as they were.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/layers.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "splat/io/image_file.h"
#include "splat/overscan.h"
#include "tests/small_scenes.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using Method = std::function<Result<Rendered>(const Scene&)>;

std::vector<Method> methods() {
  SampledOptions sampled;
  sampled.samples = 4;
  return {[=](const Scene& scene) { return render_sampled(scene, sampled); },
          [](const Scene& scene) { return render_abuffer(scene); },
          [](const Scene& scene) {
            return render_reference(scene, {4, ReferenceMotion::smooth});
          }};
}

Scene balls() {
  Scene scene = test::busy_scene();
  scene.film = {40, 30};
  scene.camera.look_ats[0].lens.shift = {-0.45, -0.4};  // so that they stick out of the film
  return scene;
}

TEST(Overscan, IsThePictureOfALargerFilm) {
  for (const Method& method : methods()) {
    Scene scene = balls();
    const Result<Rendered> inner = method(scene);
    ASSERT_TRUE(inner.ok()) << inner.error().message();
    scene.film.overscan_left = 5, scene.film.overscan_top = 3;
    scene.film.overscan_right = 9, scene.film.overscan_bottom = 1;
    const Result<Rendered> outer = method(scene);
    ASSERT_TRUE(outer.ok()) << outer.error().message();
    const Image &a = inner->image, &b = outer->image;
    EXPECT_EQ(b.x, -5);
    EXPECT_EQ(b.y, -3);
    EXPECT_EQ(b.width, 54);
    EXPECT_EQ(b.height, 34);
    EXPECT_EQ(b.film_width, 40);
    EXPECT_EQ(b.film_height, 30);
    ASSERT_TRUE(b.validate().ok());
    const auto at = [](const Image& image, int x, int y, int c) {
      return image.rgba[static_cast<std::size_t>(4 * ((y - image.y) * image.width + x - image.x) + c)];
    };
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x)
        for (int c = 0; c < 4; ++c) ASSERT_NEAR(at(a, x, y, c), at(b, x, y, c), 2e-4f) << x << ' ' << y;
    double beyond = 0.0;
    for (int x = 0; x < 40; ++x) beyond += at(b, x, -1, 3);
    EXPECT_GT(beyond, 1.0) << "nothing is seen there";
  }
}

TEST(Overscan, IsADataWindowBeyondTheDisplayWindow) {
  Scene scene = balls();
  scene.film.overscan_left = 7, scene.film.overscan_top = 2;
  const Result<Rendered> rendered = methods()[0](scene);
  ASSERT_TRUE(rendered.ok());
  const test::TemporaryFolder folder;
  const std::string path = folder / "overscan.exr";
  ASSERT_TRUE(write_exr(path, rendered->image, {}).ok());
  const Result<Image> read = read_exr(path);
  ASSERT_TRUE(read.ok()) << read.error().message();
  EXPECT_EQ(read->x, -7);
  EXPECT_EQ(read->y, -2);
  EXPECT_EQ(read->width, 47);
  EXPECT_EQ(read->film_width, 40);
  EXPECT_EQ(read->rgba, rendered->image.rgba);
}

TEST(Overscan, WidensFocalLengthAndPrincipalPointInPixels) {
  Scene scene = balls();
  scene.film.overscan_right = 13, scene.film.overscan_top = 4;
  const Scene wide = widened(scene);
  const Projection own = projection_of(scene.film, scene.camera.at(0.5));
  const Projection larger = projection_of(wide.film, wide.camera.at(0.5));
  EXPECT_NEAR(larger.focal_px, own.focal_px, 1e-12 * own.focal_px);
  EXPECT_NEAR(larger.center_x, own.center_x, 1e-12 * own.focal_px);
  EXPECT_NEAR(larger.center_y, own.center_y + 4.0, 1e-12 * own.focal_px);
}

TEST(Overscan, LayersHaveItToo) {
  Scene scene = balls();
  scene.film.overscan_left = 5;
  const auto layers = render_layers(scene, {.coverage = true});
  ASSERT_TRUE(layers.ok());
  EXPECT_EQ((*layers)[0].values.size(), 45u * 30u);
}

TEST(Overscan, GoesWithoutACrop) {
  Scene scene = balls();
  scene.film = {40, 30, 1, 1, 8, 8, 2, 0, 0, 0};
  EXPECT_EQ(scene.validate().error().field, "/film/overscan");
  scene.film = {40, 30, 0, 0, 0, 0, 65535, 0, 0, 0};
  EXPECT_EQ(scene.validate().error().field, "/film/overscan");
  scene.film = {40, 30, 0, 0, 0, 0, -1, 0, 0, 2};
  EXPECT_EQ(scene.validate().error().field, "/film/overscan/0");
}

}  // namespace
}  // namespace swept
