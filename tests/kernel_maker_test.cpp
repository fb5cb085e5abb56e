// Kernels that are made again when a tile needs them: the same bits, and hardly any memory meanwhile.
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/sources/disc_fragments.h"
#include "splat/kernel/kernel_maker.h"
#include "splat/kernel/kernel_order.h"
#include "splat/kernel/kernel_set.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

bool same(const MovingKernel& a, const MovingKernel& b) {
  return !KernelOrder::content_less(a, b) && !KernelOrder::content_less(b, a);
}

/// A sphere whose points go their own ways, by arcs, spinning.
Object ballistic(int points, bool curved = true) {
  Object object = test::checkered_sphere(0.8, points);
  test::Random random(3);
  for (int i = 0; i < points; ++i) {
    object.cloud.velocity.push_back(random.vector(-0.5, 0.5).cast<float>());
    if (!curved) continue;
    object.cloud.acceleration.push_back(random.vector(-2.0, 2.0).cast<float>());
    object.cloud.angular_velocity.push_back(random.vector(-1.0, 1.0).cast<float>());
  }
  return object;
}

struct Case {
  const char* name;
  std::function<void(Scene&)> change;
};

/// Of several objects, one of which has triangles and so no discs.
Scene several_objects() {
  Scene scene = test::stage();
  test::Random random(5);
  Object turning = test::checkered_sphere(0.7, 300);
  test::move(turning, {-0.5, 0.1, 0.0}, {0.5, 0.2, 0.4}, 1.1);
  scene.objects = {ballistic(300),
                   test::triangles_about(4, 1.0f, random, [] { return Eigen::Vector3d(0, 0, 0); }), turning,
                   test::checkered_sphere(0.4, 200), ballistic(200, false)};
  scene.objects[3].two_sided = false;
  scene.objects[4].cloud.oriented.assign(200, 1);
  scene.objects[4].transform.keys.resize(1);
  scene.objects[4].transform.keys[0].scale = {-1.0, 1.0, 1.0};
  return scene;
}

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"as it is", [](Scene&) {}},
      {"finely cut", [](Scene& s) { s.motion.tolerance_px = 0.01; }},
      {"cut alike", [](Scene& s) { s.model.segments = 3; }},
      {"rolling shutter", [](Scene& s) { s.shutter.row_delay = 0.01; }},
      {"trapezoid",
       [](Scene& s) {
         s.shutter.curve = ShutterShape::trapezoid;
         s.shutter.opening = s.shutter.closing = 0.3;
       }},
      {"lives and looks",
       [](Scene& s) {
         SurfelCloud& cloud = s.objects[0].cloud;
         for (std::size_t i = 0; i < cloud.size(); ++i)
           cloud.lifetime.push_back({i % 3 == 0 ? 0.3 : -1.0, i % 4 == 0 ? 0.7 : 2.0});
         cloud.looks.resize(2);
         cloud.looks[1].frame = 0.6;
         cloud.looks[0].color.assign(cloud.size(), {1.0f, 0.0f, 0.5f});
         cloud.looks[1].color.assign(cloud.size(), {0.0f, 1.0f, 0.5f});
       }},
      {"an instant", [](Scene& s) { s.shutter.close = s.shutter.open; }},
  };
  return all;
}

TEST(KernelMaker, MakesAnyKernelAgainToTheBit) {
  for (const Case& of : cases()) {
    Scene scene = several_objects();
    of.change(scene);
    ASSERT_TRUE(scene.validate().ok()) << of.name << ": " << scene.validate().error().message();
    KernelMaker maker(scene, scene.exposure());
    std::vector<KernelSource> sources;
    std::vector<MovingKernel> kernels;
    KernelOrder order;
    const KernelCounts counts = maker.make_all(
        [&](const KernelSource& source, const MovingKernel& kernel, const DiscTurn*) {
          sources.push_back(source);
          kernels.push_back(kernel);
          order.include(kernel);
        },
        {});
    EXPECT_EQ(counts.surfels, 1000u);
    ASSERT_GE(kernels.size(), 800u) << of.name;
    std::optional<DiscTurn> turn;
    for (std::size_t k = kernels.size(); k-- > 0;)
      ASSERT_TRUE(same(maker.make(sources[k], turn), kernels[k])) << of.name << ", kernel " << k;

    // In their order they are what those have that keep them all.
    std::sort(kernels.begin(), kernels.end(), [&](const MovingKernel& a, const MovingKernel& b) {
      return order.key(a) != order.key(b) ? order.key(a) < order.key(b) : KernelOrder::content_less(a, b);
    });
    const KernelSet set = build_kernels(scene);
    ASSERT_EQ(set.kernels.size(), kernels.size()) << of.name;
    for (std::size_t k = 0; k < kernels.size(); ++k)
      ASSERT_TRUE(same(set.kernels[k], kernels[k])) << of.name << ", in order " << k;
    EXPECT_EQ(set.still_kernels, counts.still_kernels);
    EXPECT_EQ(set.most_segments, counts.most_segments);
  }
}

std::size_t bytes_in_use() { return mallinfo2().uordblks + mallinfo2().hblkhd; }

TEST(KernelMaker, APointKeepsBytesForItsSegmentsAndNotKernels) {
  const std::size_t before_probe = bytes_in_use();
  const auto probe = std::make_unique<std::vector<char>>(100'000, char{1});
  if (bytes_in_use() < before_probe + 100'000) GTEST_SKIP() << "this allocator does not say what is in use";

  Scene scene = test::stage();
  scene.film = {640, 480, 0, 0, 0, 0};
  constexpr int points = 20'000;
  scene.objects = {ballistic(points)};
  const std::size_t before = bytes_in_use();
  const auto film = std::make_unique<DiscFilm>(scene, Window{0, 0, 640, 480}, SegmentShape::parabolas, 32,
                                               std::size_t{1} << 20, std::stop_token{});
  const auto kept = static_cast<double>(bytes_in_use() - before);
  const double segments = static_cast<double>(film->kernels);
  std::printf("%.1f segments a point, of which %.1f bytes each are kept\n", segments / points,
              kept / segments);
  ASSERT_GT(segments, 10.0 * points);
  EXPECT_LT(kept, 24.0 * segments) << "a kernel and its shade are 200 bytes";
}

}  // namespace
}  // namespace swept
