// Whole images of the GPU modes against the A-buffer, the plain twin and each other.
#include "gpu_passes/gpu_renderer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "datasets/generators.h"
#include "gpu_compare.h"
#include "gpu_passes/six_pass/clamp_motion.h"
#include "gpu_passes/six_pass/six_pass_twin.h"
#include "gpu_passes/six_pass/subframes.h"
#include "gpu_stage.h"
#include "splat/io/scene_file.h"
#include "tests/image_difference.h"

namespace swept {
namespace {

class GpuImage : public testing::Test {
 protected:
  void SetUp() override {
    Result<GpuRenderer> renderer = GpuRenderer::create();
    if (!renderer) GTEST_SKIP() << renderer.error().message();
    renderer_.emplace(std::move(*renderer));
  }

  Image render(const Scene& scene, const GpuRenderOptions& options) {
    Result<Rendered> rendered = renderer_->render(scene, options);
    EXPECT_TRUE(rendered) << rendered.error().message();
    return rendered ? std::move(rendered->image) : Image{};
  }

  std::optional<GpuRenderer> renderer_;
};

GpuRenderOptions six(int subframes) { return {GpuMethod::six_pass, subframes, false}; }
GpuRenderOptions still(int subframes) { return {GpuMethod::still, subframes, false}; }

/// A striped sphere that turns and flies past another, over a plain background; 96 × 64 px.
Scene spheres() {
  Scene scene;
  scene.film = {96, 64, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats.emplace_back();
  scene.camera.look_ats.back().eye.z() = 3.5;
  scene.background = {0.05f, 0.1f, 0.2f, 1.0f};
  scene.objects = {striped_sphere(1.0, 3000), striped_sphere(0.6, 2000)};
  TransformKey key;
  key.translate = {-0.8, 0.1, 1.0};
  scene.objects[1].transform.keys.push_back(key);
  key.frame = 1.0;
  key.translate = {0.6, -0.2, 1.3};
  key.rotate_radians = 1.0;
  scene.objects[1].transform.keys.push_back(key);
  for (Object& object : scene.objects) object.two_sided = false;
  return scene;
}

Scene dataset(const char* name, double points_scale) {
  SceneOverrides overrides;
  overrides.fields = {{"/film/width", {144}}, {"/film/height", {96}}};
  overrides.points_scale = points_scale;
  Result<SceneFile> file = read_scene_file(std::string(SWEPT_SCENES "/") + name, overrides);
  EXPECT_TRUE(file) << file.error().message();
  Result<const Scene*> scene = file->scene_at(file->scene().frame, generate);
  EXPECT_TRUE(scene) << scene.error().message();
  return **scene;
}

Image render_cpu(const Scene& scene) {
  Result<Rendered> rendered = render_abuffer(scene);
  EXPECT_TRUE(rendered);
  return std::move(rendered->image);
}

double psnr(const Image& a, const Image& b) {
  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    const double difference = static_cast<double>(a.rgba[i]) - static_cast<double>(b.rgba[i]);
    squares += difference * difference;
    ++count;
  }
  return -10.0 * std::log10(squares / static_cast<double>(count));
}

/// What single precision may do to the colours of a scene: a kernel's place is rounded in units of its
/// radius, with up to half its motion as offset, six times; the kernel changes by 2δ of that, and a colour by
/// less, its contrast being 1 at most.
double float_tolerance(const Scene& scene, const GpuRenderOptions& options) {
  Subframes subframes(scene, options);
  const KernelSet set = subframes.kernels(0);
  double motion = 1.0;
  for (const MovingKernel& kernel : set.kernels) {
    const double radius = static_cast<double>(std::min(kernel.axis_u.norm(), kernel.axis_v.norm()));
    motion = std::max(motion, 1.0 + 0.5 * kernel.velocity.norm() / radius);
  }
  return 2.0 * scene.model.delta * motion * 6.0 * 0x1p-24;
}

/// Pixels are flipped where rounding, at most 1e-5 of a radius or of a depth tolerance, puts one of some
/// hundred fragments across a cut-off.
constexpr double flips = 1e-3;

TEST_F(GpuImage, AStillSceneEqualsTheCpuInTheInterior) {
  for (const Lens& lens : {Lens{}, Lens{1.4, {0.1, -0.2}}}) {
    Scene scene = spheres();
    scene.camera.look_ats.front().lens = lens;
    scene.background.setZero();  // so that alpha is coverage
    scene.shutter.close = scene.shutter.open;
    const Image cpu = render_cpu(scene);
    const TwinTargets targets = twin_passes(Subframes(scene, six(1)).kernels(0), scene, GpuMethod::six_pass);
    // Where the front surface covers the pixel, nothing behind it counts, and both models are the same.
    const auto interior = [&](std::size_t p) {
      return targets.color_sum[4 * p + 3] > scene.model.edge_weight * (1.0 + 1e-5);
    };
    for (const GpuRenderOptions& options : {six(1), six(4), still(1), still(4)}) {
      const Image gpu = render(scene, options);
      EXPECT_TRUE(equal_within(gpu.rgba, cpu.rgba, 4, {1e-5, flips}, interior));
      EXPECT_TRUE(equal_within(gpu.depth, cpu.depth, 1, {1e-5 * 6.0, flips}, interior));
      std::size_t count = 0;
      for (std::size_t p = 0; p < gpu.pixel_count(); ++p) count += interior(p) ? 1 : 0;
      EXPECT_GT(count, gpu.pixel_count() / 8);
    }
  }
}

TEST_F(GpuImage, SixPassesEqualTheirPlainTwin) {
  for (const Coverage coverage : {Coverage::soft, Coverage::hard})
    for (const GpuRenderOptions& options : {six(1), six(3), still(3)}) {
      Scene scene = spheres();
      scene.model.coverage = coverage;
      const Result<Rendered> twin = render_six_pass_twin(scene, options);
      ASSERT_TRUE(twin);
      const Image gpu = render(scene, options);
      const double tolerance = float_tolerance(scene, options);
      EXPECT_LE(tolerance, 1e-4);
      EXPECT_TRUE(equal_within(gpu.rgba, twin->image.rgba, 4, {tolerance, flips}));
      EXPECT_TRUE(equal_within(gpu.depth, twin->image.depth, 1, {10.0 * tolerance, flips}));
    }
}

TEST_F(GpuImage, MoreSubframesComeNearerToTheExactImage) {
  for (const auto& [name, scale] : {std::pair{"overlap.json", 0.1}, std::pair{"both_ends.json", 0.1}}) {
    SCOPED_TRACE(name);
    const Scene scene = dataset(name, scale);
    const Image exact = render_cpu(scene);
    std::vector<double> decibels;
    for (const int n : {1, 2, 4, 8, 16}) {
      decibels.push_back(psnr(render(scene, six(n)), exact));
      RecordProperty(std::string(name) + "_" + std::to_string(n), std::to_string(decibels.back()));
    }
    // What is wrong is wrong within the sub-frames in which visibility changes, a share of the exposure that
    // halves with their length: 6 dB per doubling where that is all, and less where surfaces change within
    // one sub-frame and the next alike. A quarter of it has to be there each time, half of it on the whole.
    for (std::size_t i = 1; i < decibels.size(); ++i) EXPECT_GE(decibels[i], decibels[i - 1] + 1.5) << i;
    EXPECT_GE(decibels.back(), decibels.front() + 12.0);
  }
}

TEST_F(GpuImage, StillFramesAverageToTheExactImage) {
  Scene scene = spheres();
  // A soft edge over several surfaces stays wrong however many there are.
  scene.model.coverage = Coverage::hard;
  const Image exact = render_cpu(scene);
  const double few = psnr(render(scene, still(4)), exact), many = psnr(render(scene, still(32)), exact);
  // The midpoint rule errs by 1/n where a pixel jumps: 18 dB for 8 times as many. The A-buffer's segments are
  // not the true path, which still frames follow; a quarter is for that.
  EXPECT_GT(many, few + 13.5);
}

TEST(ClampMotion, BendsWhatLiesInThePlaneAndNothingElse) {
  MovingKernel kernel = disc(16.5, 16.5, 100.0, 2.0, 10.0, {1.0f, 0.0f, 0.0f});
  const Eigen::Vector3d bent = clamped_motion(kernel);
  EXPECT_NEAR(bent.x(), 10.0, 1e-12);
  EXPECT_NEAR(std::abs(bent.z()), 10.0 * least_motion_tangent, 1e-12);
  // Slow: the least length, and still the least angle.
  kernel.velocity = {0.03, 0.0, 0.0};
  EXPECT_NEAR(clamped_motion(kernel).norm(), 2.0 * least_motion_radii, 1e-7);
  kernel.velocity.setZero();
  EXPECT_NEAR(clamped_motion(kernel).norm(), 2.0 * least_motion_radii, 1e-7);
  for (const Eigen::Vector3d& steep : {Eigen::Vector3d(3.0, 0.0, -2.0), Eigen::Vector3d(0.0, 0.0, 0.5)}) {
    kernel.velocity = steep;
    EXPECT_EQ(clamped_motion(kernel), steep);
  }
}

TEST_F(GpuImage, TheClampedMotionChangesThePicture) {
  // A ball that turns moves each of its discs within the disc's plane.
  Scene scene = spheres();
  scene.objects.pop_back();
  TransformKey key;
  scene.objects[0].transform.keys.push_back(key);
  key.frame = 1.0;
  key.rotate_radians = 0.6;
  scene.objects[0].transform.keys.push_back(key);
  const GpuRenderOptions clamped{GpuMethod::six_pass, 2, false, true};
  const Result<Rendered> twin = render_six_pass_twin(scene, clamped);
  ASSERT_TRUE(twin);
  const Image bent = render(scene, clamped), straight = render(scene, six(2));
  EXPECT_TRUE(equal_within(bent.rgba, twin->image.rgba, 4, {float_tolerance(scene, clamped), flips}));
  // What it does to the picture, apart from what the six passes and single precision do: 40 dB above the
  // latter.
  const Result<Rendered> plain = render_six_pass_twin(scene, six(2));
  ASSERT_TRUE(plain);
  RecordProperty("clamped_db", std::to_string(psnr(bent, plain->image)));
  RecordProperty("straight_db", std::to_string(psnr(straight, plain->image)));
  EXPECT_LT(psnr(bent, plain->image) + 40.0, psnr(straight, plain->image));
}

/// A thin disc flies past and towards the eye: half of its pixels have it only at an end of the exposure,
/// where its weight is at an end of the interval.
TEST_F(GpuImage, DepthIsWhereTheWeightIs) {
  Scene scene;
  scene.film = {48, 32, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats.emplace_back();
  scene.camera.look_ats.back().eye.z() = 4.0;
  scene.background.setZero();
  Object& object = scene.objects.emplace_back();
  object.cloud.keys.push_back({0.0, {{{-0.2, 0, 0}}, {{0.4f, 0, 0}}, {{0, 0.4f, 0}}}});
  object.cloud.velocity = {{0.4f, 0.1f, 2.0f}};
  scene.model.edge_weight = 1.0;  // no more than the disc's own: nothing is clamped
  scene.model.segments = 1;       // as the one sub-frame has, with the pixel filter of its middle
  const Image exact = render_cpu(scene);
  const Image image = render(scene, six(1));
  std::size_t covered = 0;
  for (std::size_t p = 0; p < image.pixel_count(); ++p) {
    if (!(exact.rgba[4 * p + 3] > 1e-3f)) continue;
    ++covered;
    ASSERT_NEAR(image.depth[p], exact.depth[p], 1e-4f * exact.depth[p]) << p;
  }
  EXPECT_GT(covered, 100u);
}

TEST(Subframes, AreChosenFromTheMotion) {
  Scene scene = spheres();
  const auto chosen = [&](const GpuRenderOptions& options) { return Subframes(scene, options).count(); };
  scene.objects.pop_back();
  EXPECT_EQ(chosen(six(0)), 1);
  EXPECT_EQ(chosen(still(0)), 1);

  // The near side of the ball at depth 2.5, 64 px of focal length: 1 unit is 25.6 px. The disc nearest to the
  // eye stands a little beyond its very front, and discs are bounded by boxes: a pixel for that.
  TransformKey key;
  key.translate.x() = -0.5;
  scene.objects[0].transform.keys.push_back(key);
  key.frame = 1.0;
  key.translate.x() = 0.5;
  scene.objects[0].transform.keys.push_back(key);
  EXPECT_EQ(chosen(six(0)), 4);
  EXPECT_NEAR(chosen(still(0)), 26, 1);
  EXPECT_EQ(chosen(six(7)), 7);

  // A whole turn: its ends are where it began.
  scene.objects[0].transform.keys[1] = scene.objects[0].transform.keys[0];
  scene.objects[0].transform.keys[1].frame = 1.0;
  scene.objects[0].transform.keys[1].rotate_radians = 2.0 * M_PI;
  EXPECT_GT(chosen(six(0)), 10);

  // Too fast for any number.
  scene.objects[0].transform.keys[0].translate.x() = -5000.0;
  scene.objects[0].transform.keys[1].translate.x() = 5000.0;
  EXPECT_EQ(chosen(six(0)), 256);
}

TEST(Subframes, StillFramesStandAtTheMiddleOfTheirs) {
  Scene scene = spheres();
  scene.objects.pop_back();
  TransformKey key;
  scene.objects[0].transform.keys.push_back(key);
  key.frame = 1.0;
  key.translate.x() = 1.0;
  scene.objects[0].transform.keys.push_back(key);
  Subframes subframes(scene, still(4));
  ASSERT_EQ(subframes.count(), 4);
  for (int j = 0; j < 4; ++j) {
    const KernelSet set = subframes.kernels(j);
    EXPECT_EQ(set.still_kernels, set.kernels.size());
    double sum = 0.0;
    for (const MovingKernel& kernel : set.kernels) sum += kernel.center.x();
    // Points lie evenly around the ball's middle: within a thousandth of their spacing.
    EXPECT_NEAR(sum / static_cast<double>(set.kernels.size()), (j + 0.5) / 4.0, 1e-3) << j;
  }
}

TEST_F(GpuImage, LookupTablesChangeLittle) {
  const Scene scene = spheres();
  const Image computed = render(scene, six(1));
  const Image tabled = render(scene, {GpuMethod::six_pass, 1, true});
  EXPECT_NE(tabled.rgba, computed.rgba);
  // Linear between texels h = 8/1023 apart, erf errs by 0.97 h²/8, and by 1.13 h/512 where a device filters
  // with 8 bits; twice, over a span of 1/16 at least.
  const double h = 8.0 / 1023.0, error = 0.97 * h * h / 8.0 + 1.13 * h / 512.0;
  EXPECT_TRUE(equal_within(tabled.rgba, computed.rgba, 4, {std::sqrt(M_PI) / 2.0 * 2.0 * 16.0 * error, 0.0}));
}

TEST_F(GpuImage, ACropEqualsThosePixelsOfTheWholeFilm) {
  Scene scene = spheres();
  const Image whole = render(scene, six(2));
  scene.film.crop_x = 37, scene.film.crop_y = 21, scene.film.crop_width = 30, scene.film.crop_height = 19;
  const Image crop = render(scene, six(2));
  ASSERT_EQ(crop.width, 30);
  ASSERT_EQ(crop.height, 19);
  EXPECT_TRUE(test::is_crop_of(crop, whole, scene.film));
}

TEST_F(GpuImage, TheSameSceneGivesTheSameBitsAgain) {
  const Scene scene = spheres();
  const Image first = render(scene, six(2));
  render(scene, still(1));
  EXPECT_EQ(render(scene, six(2)).rgba, first.rgba);
}

TEST_F(GpuImage, AOneSidedSphereIsNotSeenFromWithin) {
  Scene scene = spheres();
  scene.objects.pop_back();
  scene.camera.look_ats.back().eye.z() = 0.1;
  scene.camera.look_ats.back().target.z() = -1.0;
  scene.shutter.close = 0.5;
  TransformKey key;
  scene.objects[0].transform.keys.push_back(key);
  key.frame = 1.0;
  key.translate.x() = 0.4;
  scene.objects[0].transform.keys.push_back(key);
  for (const GpuRenderOptions& options : {six(1), six(3), still(2)}) {
    scene.objects[0].two_sided = false;
    const Image from_within = render(scene, options);
    for (std::size_t i = 0; i < from_within.rgba.size(); ++i)
      ASSERT_NEAR(from_within.rgba[i], scene.background[i % 4], 4 * 0x1p-24) << i;
    scene.objects[0].two_sided = true;
    const Image two_sided = render(scene, options);
    for (std::size_t p = 0; p < two_sided.pixel_count(); ++p) ASSERT_LT(two_sided.depth[p], 2.0f) << p;
  }
}

TEST_F(GpuImage, AnEmptySceneIsTheBackground) {
  Scene scene = spheres();
  scene.objects.clear();
  const Image image = render(scene, six(4));
  for (std::size_t i = 0; i < image.rgba.size(); ++i) ASSERT_EQ(image.rgba[i], scene.background[i % 4]);
  for (const float depth : image.depth) ASSERT_TRUE(std::isinf(depth));
}

TEST_F(GpuImage, RefusesWhatItCannotDoAndGoesOn) {
  Scene scene = spheres();
  scene.objects[1].cloud.opacity.assign(scene.objects[1].cloud.size(), 0.5f);
  Result<Rendered> refused = renderer_->render(scene, six(1));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "/objects/1");
  EXPECT_EQ(renderer_->render(spheres(), six(-1)).error().field, "subframes");
  scene = spheres();
  scene.model.delta = -1.0;
  EXPECT_FALSE(renderer_->render(scene, six(1)).ok());
  scene = spheres();
  scene.film = {65536, 1, 0, 0, 0, 0};
  refused = renderer_->render(scene, six(1));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "/film");
  EXPECT_FALSE(render(spheres(), six(1)).rgba.empty());
}

}  // namespace
}  // namespace swept
