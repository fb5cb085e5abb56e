// The sampled method: what it converges to, and what changes no bit of it.
#include "abuffer/stochastic/stochastic.h"

#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/stochastic/pixel_samples.h"
#include "tests/image_difference.h"
#include "tests/stochastic_scenes.h"

namespace swept {
namespace {

using test::add_lens, test::expect_same_images, test::mean_difference, test::rendered, test::soup,
    test::soup_scene;

TEST(Stochastic, ObeysMaxBytes) {
  Scene scene = test::busy_scene();
  for (const bool triangles : {false, true}) {
    if (triangles) scene.objects.push_back(soup(20, 3, false));
    StochasticOptions options;
    options.samples = 1;
    const Rendered all = rendered(scene, options);
    const auto bytes = static_cast<std::size_t>(all.statistics.counter("primitive_bytes").value_or(0.0));
    ASSERT_GT(bytes, 100u);
    RenderControl control;
    control.max_bytes = bytes;
    EXPECT_TRUE(render_stochastic(scene, options, control).ok());
    for (const std::size_t little : {bytes - 1, std::size_t{1}}) {
      control.max_bytes = little;
      const Result<Rendered> refused = render_stochastic(scene, options, control);
      ASSERT_FALSE(refused.ok()) << little;
      EXPECT_EQ(refused.error().field, "max_bytes");
      EXPECT_EQ(refused.error().kind, ErrorKind::out_of_memory);
    }
  }
}

/// The error must be that of noise: of random samples 1,024 would leave a fourth of what 64 leave. `share`:
/// what may be left of it.
void expect_converges(const Scene& scene, int stills, double most_at_1024, const char* what,
                      double share = 0.5) {
  // Triangles move on their true path either way, discs along their segments.
  const Image truth = test::reference(scene, stills, ReferenceMotion::segments);
  const Image few = rendered(scene, {.samples = 64}).image, many = rendered(scene, {.samples = 1024}).image;
  const double at_64 = test::difference_of(few, truth).color,
               at_1024 = test::difference_of(many, truth).color;
  EXPECT_LT(at_1024, most_at_1024) << what;
  EXPECT_LT(at_1024, share * at_64) << what;
  EXPECT_LT(std::abs(mean_difference(many, truth)), 0.3 * at_1024) << what;
  std::printf("%s: RMSE %.5f at 64 samples, %.5f at 1024\n", what, at_64, at_1024);
}

/// What is left at 1,024 samples: 1/√1024 = 0.03 of a pixel's spread if samples were random; they are spread
/// well, and few pixels are mixed.
TEST(Stochastic, ConvergesToTheReferenceOfTriangles) {
  for (const bool transparent : {false, true})
    for (const bool two_sided : {true, false}) {
      Scene scene = soup_scene(11, transparent);
      scene.objects[0].two_sided = two_sided;
      expect_converges(scene, 256, 0.003, transparent ? "transparent soup" : "soup");
    }
  Scene mirrored = soup_scene(12, false);
  mirrored.objects[0].two_sided = false;
  for (TransformKey& key : mirrored.objects[0].transform.keys) key.scale = {-1.0, 1.0, 1.0};
  expect_converges(mirrored, 256, 0.003, "mirrored soup");
  Scene warped = soup_scene(13, false);
  warped.shutter.curve = ShutterShape::gaussian;
  expect_converges(warped, 256, 0.003, "soup, Gaussian shutter");
}

/// Colours and opacities that change while the shutter is open, and a picture, of which parts are clear, on
/// triangles: as the reference, which has them at every instant.
TEST(Stochastic, ConvergesToTheReferenceOfTexturesAndChangingLooks) {
  Scene scene = soup_scene(14, false);
  Object& object = scene.objects[0];
  test::Random random(15);
  const std::size_t points = object.cloud.size();
  for (const double frame : {0.0, 0.3, 1.0}) {
    LookKey& look = object.cloud.looks.emplace_back();
    look.frame = frame;
    for (std::size_t i = 0; i < points; ++i) {
      look.color.push_back(random.vector(0.0, 1.0).cast<float>());
      look.opacity.push_back(static_cast<float>(random(0.0, 1.0)));
    }
  }
  expect_converges(scene, 256, 0.003, "looks that change");
  object.cloud.looks.clear();
  for (const bool clear : {false, true}) {
    auto texture = std::make_shared<Texture>();
    texture->width = 4, texture->height = 3;
    for (int i = 0; i < 12; ++i) {
      const float alpha = clear ? static_cast<float>(random(0.0, 1.0)) : 1.0f;
      const Eigen::Vector3f color = alpha * random.vector(0.0, 1.0).cast<float>();
      texture->texels.emplace_back(color.x(), color.y(), color.z(), alpha);
    }
    object.texture = texture;
    object.texture_corners.clear();
    for (std::size_t t = 0; t < object.triangles.size(); ++t) {
      TextureCorners corners;
      for (Eigen::Vector2f& corner : corners)
        corner = {static_cast<float>(random(-1.0, 2.0)), static_cast<float>(random(-1.0, 2.0))};
      object.texture_corners.push_back(corners);
    }
    expect_converges(scene, 256, 0.003, clear ? "a texture, in part clear" : "a texture");
    expect_same_images(scene, 16, 0, "a texture");
  }
}

TEST(Stochastic, ConvergesToTheReferenceOfDiscs) {
  Scene scene = test::busy_scene();
  expect_converges(scene, 256, 0.001, "discs");
  scene.model.coverage = Coverage::hard;
  scene.objects[0].two_sided = false;
  scene.objects[1].cloud.opacity.assign(scene.objects[1].cloud.size(), 0.4f);
  expect_converges(scene, 256, 0.002, "discs, hard, translucent, one-sided");
  scene.objects.push_back(soup(12, 3, false));
  expect_converges(scene, 256, 0.003, "discs and triangles");
}

/// Discs whose colours and opacities change: as the reference, which has them at every instant; frozen ones
/// would be off by far more.
TEST(Stochastic, ConvergesToTheReferenceOfDiscsWhoseLooksChange) {
  Scene scene = test::busy_scene();
  test::Random random(16);
  for (Object& object : scene.objects)
    for (const double frame : {-0.2, 0.1, 0.9}) {
      LookKey& look = object.cloud.looks.emplace_back();
      look.frame = frame;
      for (std::size_t i = 0; i < object.cloud.size(); ++i) {
        look.color.push_back(random.vector(0.0, 1.0).cast<float>());
        look.opacity.push_back(static_cast<float>(random(0.0, 1.0)));
      }
    }
  expect_converges(scene, 256, 0.002, "discs whose looks change");
  expect_same_images(scene, 16, 0, "discs whose looks change");
  Scene still = scene;
  for (Object& object : still.objects) {
    object.transform = {};
    object.cloud.velocity.clear();
    object.cloud.keys.resize(1);
  }
  expect_converges(still, 256, 0.002, "discs that stand still, and whose looks change");
}

TEST(Stochastic, ConvergesToTheReferenceThroughALens) {
  Scene scene = test::busy_scene();
  scene.film = {40, 30, 0, 0, 0, 0};
  add_lens(scene);
  scene.camera.aperture.samples = 64;
  // The reference's 64 points of the lens are not all of it, and its discs' filters are those of each point.
  expect_converges(scene, 32, 0.002, "discs through a lens", 1.0);
  scene.camera.aperture.blades = 5;
  scene.camera.look_ats.push_back(scene.camera.look_ats[0]);
  scene.camera.look_ats[1].frame = 1.0;
  scene.camera.look_ats[1].lens.focus = 6.0;
  scene.camera.look_ats[1].tan_half_fov_y *= 0.9;
  expect_converges(scene, 32, 0.0015, "a polygon, focus and zoom that change", 1.0);
}

/// A still rectangle of one colour that is out of focus spreads evenly over the disc that optics has: half
/// its light beyond the edge is what a half-plane's edge sees of a disc.
TEST(Stochastic, DefocusesTrianglesAsOpticsDoes) {
  Scene scene = test::stage();
  scene.shutter = {0.0, 0.0};
  Object object;
  for (const auto& [x, y] : {std::pair{0.0, -9.0}, {9.0, -9.0}, {9.0, 9.0}, {0.0, 9.0}})
    test::add_disc(object, {x, y, 0.0}, {0, 0, 1}, 0.1);
  object.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.objects = {object};
  scene.camera.aperture.radius = 0.5;
  scene.camera.look_ats[0].lens.focus = 2.5;
  const Image image = rendered(scene, {.samples = 1024}).image;
  // The eye is 5 from it: c = 2 · 0.5 · f (1/2.5 − 1/5) px across, the focal length f being 48 px.
  const double focal_px = 24.0 / scene.camera.look_ats[0].tan_half_fov_y, radius = 0.5 * focal_px * 0.2;
  for (int x = 0; x < 64; ++x) {
    double truth = 0.0;  // of the pixel's width
    for (int k = 0; k < 64; ++k) {
      const double at = std::clamp((x + (k + 0.5) / 64 - 32.0) / radius, -1.0, 1.0);
      truth += (std::asin(at) + at * std::sqrt(1.0 - at * at)) / M_PI / 64 + 0.5 / 64;
    }
    EXPECT_NEAR(image.rgba[4 * static_cast<std::size_t>(24 * 64 + x)], truth, 0.01) << x;
  }
}

/// A sheet of many triangles covers every sample once: no gap, and where it lets half the light through no
/// seam.
TEST(Stochastic, MeetsSheetsWithoutGapsAndOverlaps) {
  for (const bool lens : {false, true})
    for (const float opacity : {1.0f, 0.5f}) {
      Scene scene = test::stage();
      if (lens) add_lens(scene);
      test::Random random(5);
      Object object;
      constexpr int side = 40;
      for (int i = 0; i <= side; ++i)
        for (int j = 0; j <= side; ++j)
          test::add_disc(object,
                         {0.3 * (i - side / 2 + random(-0.2, 0.2)), 0.3 * (j - side / 2 + random(-0.2, 0.2)),
                          random(-0.05, 0.05)},
                         {0, 0, 1}, 0.1, {0.25f, 0.5f, 1.0f});
      for (std::uint32_t i = 0; i < side; ++i)
        for (std::uint32_t j = 0; j < side; ++j) {
          const std::uint32_t a = i * (side + 1) + j, b = a + 1, c = a + side + 1, d = c + 1;
          object.triangles.push_back({a, c, b});
          object.triangles.push_back({b, c, d});
        }
      object.cloud.opacity.assign(object.cloud.size(), opacity);
      scene.objects = {object};
      test::move(scene.objects[0], {0, 0, 0}, {0.2, 0.1, 0.3}, 0.3);
      const Image image = rendered(scene, {.samples = 64}).image;
      for (std::size_t i = 0; i < image.pixel_count(); ++i) {
        ASSERT_NEAR(image.rgba[4 * i + 3], opacity, 1e-6) << i;
        ASSERT_NEAR(image.rgba[4 * i + 2], opacity, 1e-6) << i;
      }
    }
}

TEST(Stochastic, HasTheSameBitsForThreadsCropsAndOrders) {
  Scene scene = soup_scene(21, true);
  scene.objects.push_back(test::checkered_sphere(0.8, 300));
  add_lens(scene);
  const StochasticOptions options{.samples = 16};
  const Image whole = rendered(scene, options).image;
  EXPECT_EQ(rendered(scene, options, 1).image.rgba, whole.rgba);
  std::reverse(scene.objects[0].triangles.begin(), scene.objects[0].triangles.end());
  std::swap(scene.objects[0], scene.objects[1]);
  EXPECT_EQ(rendered(scene, options).image.rgba, whole.rgba);
  scene.film.crop_x = 13, scene.film.crop_y = 7, scene.film.crop_width = 31, scene.film.crop_height = 29;
  const Image crop = rendered(scene, options).image;
  EXPECT_TRUE(test::is_crop_of(crop, whole, scene.film));
}

TEST(Stochastic, RefusesWhatItDoesNotDraw) {
  Scene scene = test::stage();
  scene.objects = {test::checkered_sphere(0.8, 20)};
  scene.shutter.row_delay = 0.001;
  const auto delayed = render_stochastic(scene);
  ASSERT_FALSE(delayed.ok());
  EXPECT_NE(delayed.error().message().find("stochastic"), std::string::npos);
  scene.shutter.row_delay = 0.0;
  scene.objects.emplace_back().splats.position.emplace_back(0, 0, 0);
  const auto splats = render_stochastic(scene);
  ASSERT_FALSE(splats.ok());
  EXPECT_EQ(splats.error().kind, ErrorKind::unsupported);
  scene.objects.pop_back();
  for (const StochasticOptions& wrong :
       {StochasticOptions{.samples = 0}, {.times = -1}, {.tile_px = 3}, {.intervals = 0}})
    EXPECT_FALSE(render_stochastic(scene, wrong).ok());
}

/// A fade of a disc that stands still, under a shutter that lets in more light late: the shutter's mean.
TEST(Stochastic, ADiscThatFadesIsTheShuttersMean) {
  Scene scene = test::stage();
  Object& object = scene.objects.emplace_back();
  test::add_disc(object, {0, 0, 0}, {0, 0, 1}, 40.0, {1.0f, 0.5f, 0.25f});
  for (const double frame : {0.0, 1.0}) {
    LookKey& look = object.cloud.looks.emplace_back();
    look.frame = frame;
    look.color = {{1.0f, 0.5f, 0.25f}};
    look.opacity = {static_cast<float>(frame)};
  }
  scene.shutter.curve = ShutterShape::table;
  scene.shutter.rates = {0.0, 1.0};  // twice the time: the mean of it is ⅔
  const Image image = rendered(scene, {.samples = 1024}).image;
  for (const std::size_t pixel : {std::size_t{0}, std::size_t{24 * 64 + 32}}) {
    EXPECT_NEAR(image.rgba[4 * pixel], 2.0 / 3.0, 2e-3);
    EXPECT_NEAR(image.rgba[4 * pixel + 1], 1.0 / 3.0, 2e-3);
    EXPECT_NEAR(image.rgba[4 * pixel + 3], 2.0 / 3.0, 2e-3);
  }
}

/// In each of a power of two of strata of every dimension there is one sample of a pixel.
TEST(Stochastic, SpreadsSamplesInEveryDimension) {
  Scene scene = test::stage();
  add_lens(scene);
  constexpr int count = 64;
  const stochastic::SampleSource source(scene, scene.exposure(), count, 0);
  stochastic::BlockSamples samples;
  source.fill({3, 5, 2, 2}, samples);
  for (std::size_t pixel = 0; pixel < 4; ++pixel) {
    for (const std::vector<float>* dimension : {&samples.x, &samples.y, &samples.share}) {
      std::vector<int> of_stratum(count, 0);
      for (std::size_t i = 0; i < count; ++i)
        ++of_stratum[static_cast<std::size_t>((*dimension)[pixel * count + i] * count)];
      for (const int n : of_stratum) EXPECT_EQ(n, 1);
    }
    std::vector<int> of_ring(count, 0), of_square(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t k = pixel * count + i;
      const double radius = std::hypot(samples.lens_x[k], samples.lens_y[k]) / 0.15;
      ++of_ring[std::min<std::size_t>(static_cast<std::size_t>(radius * radius * count), count - 1)];
      ++of_square[static_cast<std::size_t>(samples.x[k] * 8) * 8 +
                  static_cast<std::size_t>(samples.y[k] * 8)];
    }
    for (const int n : of_square) EXPECT_EQ(n, 1);
    // Rounding may move one across a ring's border.
    EXPECT_LE(std::count_if(of_ring.begin(), of_ring.end(), [](int n) { return n != 1; }), 4);
    EXPECT_EQ(samples.x[0] == samples.x[pixel * count], pixel == 0);
  }
}

}  // namespace
}  // namespace swept
