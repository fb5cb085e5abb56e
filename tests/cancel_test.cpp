// A render that is stopped returns soon, whatever it is doing. Measured in CPU time of one thread, which
// other programs on the machine do not change: no more than 100 ms may pass from the request to the return.
#include <ctime>

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/layers.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "abuffer/stochastic/stochastic.h"
#include "small_scenes.h"

namespace swept {
namespace {

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__) || !defined(NDEBUG)
constexpr double most_seconds = 3.0;  // such builds are slower by up to 30 times
#else
constexpr double most_seconds = 0.1;
#endif

double cpu_seconds(clockid_t clock) {
  timespec time;
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

Scene large_scene(int points = 100000) {
  Scene scene = test::stage();
  scene.film = {960, 540, 0, 0, 0, 0};
  Object& object = scene.objects.emplace_back(test::checkered_sphere(1.2, points));
  object.cloud.velocity.assign(object.cloud.size(), {1.0f, 0.3f, 0.2f});
  return scene;
}

Scene large_splat_scene() {
  Scene scene = test::stage();
  scene.film = {960, 540, 0, 0, 0, 0};
  SplatCloud& splats = scene.objects.emplace_back().splats;
  test::Random random(5);
  for (int i = 0; i < 50000; ++i) {
    splats.position.push_back(random.vector(-1.5, 1.5));
    splats.scale.push_back(Eigen::Vector3f::Constant(0.02f));
    splats.rotation.push_back(Eigen::Quaternionf::Identity());
    splats.opacity.push_back(0.5f);
    splats.velocity.push_back(random.vector(-1.0, 1.0).cast<float>());
  }
  splats.harmonics.assign(3 * splats.size(), 0.5f);
  return scene;
}

using Render = std::function<ErrorKind(const RenderControl&)>;

template <class Call>
Render kind_of(const Call& call) {
  return [call](const RenderControl& control) {
    const auto result = call(control);
    return result ? ErrorKind::argument : result.error().kind;
  };
}

/// The CPU time of a render by one thread from a stop that comes after `before` seconds of it; negative: it
/// had ended by then.
double seconds_after_stop(const Render& render, double before) {
  std::stop_source stop;
  RenderControl control;
  control.threads = 1;
  control.stop = stop.get_token();
  std::atomic<bool> done{false};
  std::atomic<ErrorKind> kind{ErrorKind::argument};
  clockid_t clock;
  std::atomic<bool> started{false};
  std::atomic<double> returned{0.0};
  std::jthread worker([&] {
    pthread_getcpuclockid(pthread_self(), &clock);
    started = true;
    kind = render(control);
    returned = cpu_seconds(CLOCK_THREAD_CPUTIME_ID);
    done = true;
    done.notify_all();
    // The clock of a thread is gone with it.
    while (started) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  while (!started) std::this_thread::yield();
  while (!done && cpu_seconds(clock) < before) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const double at_stop = cpu_seconds(clock);
  const bool early = done;
  stop.request_stop();
  done.wait(false);
  started = false;
  worker.join();
  if (early) return -1.0;
  if (kind == ErrorKind::argument) return -1.0;  // it was as good as ready
  EXPECT_EQ(kind, ErrorKind::cancelled);
  return returned - at_stop;
}

void expect_soon(const char* name, const Render& render) {
  double worst = 0.0;
  int stopped = 0;
  for (const double before : {0.0, 0.02, 0.05, 0.1, 0.15, 0.25, 0.5}) {
    const double seconds = seconds_after_stop(render, before);
    if (seconds < 0.0) break;
    ++stopped;
    worst = std::max(worst, seconds);
  }
  EXPECT_GE(stopped, 3) << name;
  EXPECT_LT(worst, most_seconds) << name;
  std::printf("%s: %d stops, the latest after %.1f ms\n", name, stopped, 1e3 * worst);
}

TEST(Cancel, SampledRendersReturnSoon) {
  const Scene discs = large_scene();
  expect_soon("sampled", kind_of([&](const RenderControl& control) {
                return render_sampled(discs, {.max_error_db = 80.0}, control);
              }));
}

TEST(Cancel, RendersOfSplatsReturnSoon) {
  const Scene splats = large_splat_scene();
  expect_soon("sampled, splats", kind_of([&](const RenderControl& control) {
                return render_sampled(splats, {.max_error_db = 80.0}, control);
              }));
}

TEST(Cancel, ExactRendersReturnSoon) {
  const Scene discs = large_scene();
  expect_soon("exact",
              kind_of([&](const RenderControl& control) { return render_abuffer(discs, {}, control); }));
}

/// What comes before the tiles takes most of half a second then.
TEST(Cancel, ExactRendersOfManyPointsReturnSoon) {
  const Scene discs = large_scene(500000);
  expect_soon("exact, 500,000 points",
              kind_of([&](const RenderControl& control) { return render_abuffer(discs, {}, control); }));
}

/// A sheet of many triangles that turns, so that its paths take stretches.
Object turning_sheet(std::uint32_t side) {
  Object object;
  SurfelPose& pose = object.cloud.keys.emplace_back().pose;
  for (std::uint32_t i = 0; i <= side; ++i)
    for (std::uint32_t j = 0; j <= side; ++j) {
      const double x = 2.0 * i / side - 1.0, y = 2.0 * j / side - 1.0;
      pose.position.emplace_back(x, y, 0.1 * std::sin(7.0 * x) * std::cos(5.0 * y));
      pose.axis_u.emplace_back(0.1f, 0.0f, 0.0f);
      pose.axis_v.emplace_back(0.0f, 0.1f, 0.0f);
    }
  object.cloud.color.assign(pose.size(), {0.2f, 0.5f, 0.8f});
  object.cloud.opacity.assign(pose.size(), 0.5f);
  for (std::uint32_t i = 0; i < side; ++i)
    for (std::uint32_t j = 0; j < side; ++j) {
      const std::uint32_t a = i * (side + 1) + j, b = a + 1, c = a + side + 1, d = c + 1;
      object.triangles.push_back({a, c, b});
      object.triangles.push_back({b, c, d});
    }
  TransformKey first, last;
  first.frame = -1.0, last.frame = 1.0;
  first.rotate_axis = last.rotate_axis = {0.0, 0.0, 1.0};
  last.rotate_radians = 1.0;
  object.transform.keys = {first, last};
  return object;
}

/// Paths and bins, which take a second; and tiles of many intervals, some of them a pixel's.
TEST(Cancel, ExactRendersOfMeshesReturnSoon) {
  Scene sheet = test::stage();
  sheet.film = {960, 540, 0, 0, 0, 0};
  sheet.objects = {turning_sheet(400)};
  expect_soon("exact, 320,000 triangles",
              kind_of([&](const RenderControl& control) { return render_abuffer(sheet, {}, control); }));
  // Seen from so far away that it is a few pixels.
  sheet.objects.back().transform.keys[0].scale = sheet.objects.back().transform.keys[1].scale =
      Eigen::Vector3d::Constant(0.004);
  expect_soon("exact, 320,000 triangles in a few pixels",
              kind_of([&](const RenderControl& control) { return render_abuffer(sheet, {}, control); }));
  // Sheets of which any two change places.
  sheet.film = {4, 4, 0, 0, 0, 0};
  sheet.objects = {Object()};
  Object& layers = sheet.objects.back();
  SurfelPose& pose = layers.cloud.keys.emplace_back().pose;
  for (std::uint32_t i = 0; i < 800; ++i) {
    for (const auto& [x, y] : {std::pair{-9.0, -9.0}, {9.0, -9.0}, {0.0, 9.0}}) {
      pose.position.emplace_back(x, y, 0.001 * i);
      pose.axis_u.emplace_back(0.1f, 0.0f, 0.0f);
      pose.axis_v.emplace_back(0.0f, 0.1f, 0.0f);
      layers.cloud.velocity.emplace_back(0.0f, 0.0f, -0.002f * static_cast<float>(i * 7919 % 800));
    }
    layers.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  layers.cloud.color.assign(pose.size(), {0.2f, 0.5f, 0.8f});
  layers.cloud.opacity.assign(pose.size(), 0.001f);
  expect_soon("exact, 800 sheets over each other",
              kind_of([&](const RenderControl& control) { return render_abuffer(sheet, {}, control); }));
  sheet.objects.push_back(large_scene(100).objects[0]);
  expect_soon("exact, 800 sheets over each other and discs",
              kind_of([&](const RenderControl& control) { return render_abuffer(sheet, {}, control); }));
  // And many triangles among many discs.
  sheet.film = {960, 540, 0, 0, 0, 0};
  sheet.objects = {turning_sheet(40), large_scene().objects[0]};
  expect_soon("exact, triangles among discs",
              kind_of([&](const RenderControl& control) { return render_abuffer(sheet, {}, control); }));
}

TEST(Cancel, ReferencesReturnSoon) {
  const Scene discs = large_scene();
  expect_soon("reference", kind_of([&](const RenderControl& control) {
                return render_reference(discs, {.samples = 1024}, control);
              }));
  expect_soon("reference, true path", kind_of([&](const RenderControl& control) {
                return render_reference(discs, {.samples = 1024, .motion = ReferenceMotion::smooth}, control);
              }));
  const Scene splats = large_splat_scene();
  expect_soon("reference, splats", kind_of([&](const RenderControl& control) {
                return render_reference(splats, {.samples = 1024}, control);
              }));
}

TEST(Cancel, StochasticRendersReturnSoon) {
  Scene scene = large_scene();
  expect_soon("stochastic", kind_of([&](const RenderControl& control) {
                return render_stochastic(scene, {.samples = 256}, control);
              }));
  // Large triangles between points that are far apart, of which each pixel has many.
  Object& object = scene.objects[0];
  for (std::uint32_t i = 0; i + 40000 < object.cloud.size(); ++i)
    object.triangles.push_back({i, i + 1, i + 20000});
  object.cloud.opacity.assign(object.cloud.size(), 0.5f);
  for (const Traversal traversal :
       {Traversal::tile, Traversal::interval, Traversal::interleave, Traversal::hierarchy})
    if (traversal != Traversal::hierarchy || hierarchy_available())
      expect_soon("stochastic, triangles", kind_of([&](const RenderControl& control) {
                    return render_stochastic(scene, {.samples = 64, .traversal = traversal}, control);
                  }));
}

TEST(Cancel, LayersReturnSoon) {
  const Scene discs = large_scene();
  expect_soon("layers", kind_of([&](const RenderControl& control) {
                return render_layers(discs, {true, true, true}, control);
              }));
}

}  // namespace
}  // namespace swept
