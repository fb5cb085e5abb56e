// Nothing is thrown out of a public function: not for want of memory, at whichever allocation, and not what a
// callback of the caller throws.
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <new>

#include <gtest/gtest.h>

#include "sanitizers.h"
#if SWEPT_WITH_ASAN
#include <sanitizer/lsan_interface.h>
#endif

#include "abuffer/abuffer.h"
#include "abuffer/layers.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "abuffer/stochastic/stochastic.h"
#include "datasets/generators.h"
#include "small_scenes.h"
#include "splat/arrays.h"
#include "splat/compare/metrics.h"
#include "splat/io/image_file.h"
#include "splat/io/point_file.h"
#include "splat/io/scene_file.h"
#include "splat/io/splat_file.h"
#include "temporary_folder.h"

namespace {

/// As long as it lives, what is allocated need not be freed.
struct MayLeak {
#if SWEPT_WITH_ASAN
  __lsan::ScopedDisabler disabler;
#else
  MayLeak() {}
#endif
};

/// Allocations until one fails; negative: none does. `every_further` fails all that follow, too.
std::atomic<long> allocations_left{-1};
std::atomic<bool> every_further{false};

bool fails() {
  if (allocations_left.load(std::memory_order_relaxed) < 0) return false;
  const long left = allocations_left.fetch_sub(1, std::memory_order_relaxed);
  if (left > 0) return false;
  if (every_further) allocations_left.store(0, std::memory_order_relaxed);
  return left == 0;
}

void* allocate(std::size_t size, std::size_t alignment) {
  if (fails()) return nullptr;
  if (alignment <= alignof(std::max_align_t)) return std::malloc(size > 0 ? size : 1);
  return std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

void* allocate_or_throw(std::size_t size, std::size_t alignment = 1) {
  void* const memory = allocate(size, alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return allocate_or_throw(size); }
void* operator new[](std::size_t size) { return allocate_or_throw(size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate_or_throw(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate_or_throw(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return allocate(size, 1); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return allocate(size, 1); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { std::free(memory); }

namespace swept {
namespace {

enum class End { success, no_memory, other };

template <class T>
End end_of(const Result<T>& result) {
  if (result) return End::success;
  return result.error().kind == ErrorKind::out_of_memory ? End::no_memory : End::other;
}

/// Calls a public function with memory running out at each of its first allocations, and at ever rarer ones
/// from there on, once or for good, until it succeeds. It must return that there is no memory, or succeed;
/// or, of those that read by streams, which take want of memory for a failed read, another error.
void expect_no_throw(const char* name, const std::function<End()>& call, bool any_error = false,
                     bool once_only = false) {
  ASSERT_EQ(call(), End::success) << name;  // what is made once only is made now
  for (const bool for_good : {false, true}) {
    if (for_good && once_only) continue;
    long failures = 0;
    for (long left = 0; left < 1'000'000; left += 1 + left / 12) {
      every_further = for_good;
      End end = End::other;
      allocations_left = left;
      try {
        end = call();
      } catch (...) {
        allocations_left = -1;
        FAIL() << name << " throws when allocation " << left << " fails";
      }
      const bool failed = allocations_left < 0 || for_good;
      const bool ran_out = for_good ? allocations_left == 0 : failed;
      allocations_left = -1;
      if (!any_error) {
        EXPECT_NE(end, End::other) << name << " at allocation " << left;
      }
      if (end != End::success) ++failures;
      if (!ran_out) break;
    }
    EXPECT_GT(failures, 0) << name;
  }
}

Scene moving_scene() {
  Scene scene = test::stage();
  scene.film = {24, 16, 0, 0, 0, 0};
  Object& object = scene.objects.emplace_back(test::checkered_sphere(0.8, 40));
  object.cloud.velocity.assign(object.cloud.size(), {0.4f, 0.0f, 0.0f});
  return scene;
}

Scene splat_scene() {
  Scene scene = test::stage();
  scene.film = {24, 16, 0, 0, 0, 0};
  SplatCloud& splats = scene.objects.emplace_back().splats;
  splats.position = {{0, 0, 0}, {0.5, 0, 0}};
  splats.scale = {{0.2f, 0.2f, 0.2f}, {0.1f, 0.3f, 0.2f}};
  splats.rotation = {Eigen::Quaternionf::Identity(), Eigen::Quaternionf::Identity()};
  splats.opacity = {0.9f, 0.5f};
  splats.harmonics.assign(6, 0.5f);
  splats.velocity = {{0.5f, 0, 0}, {0, 0.5f, 0}};
  return scene;
}

const RenderControl one_thread{.threads = 1};

TEST(NoThrow, WhenMemoryRunsOutInARender) {
  const Scene discs = moving_scene(), splats = splat_scene();
  expect_no_throw("render_sampled", [&] {
    return end_of(render_sampled(discs, {.max_error_db = 30.0, .error_channel = true}, one_thread));
  });
  expect_no_throw("render_sampled of splats",
                  [&] { return end_of(render_sampled(splats, {.max_error_db = 30.0}, one_thread)); });
  expect_no_throw("render_abuffer", [&] { return end_of(render_abuffer(discs, {}, one_thread)); });
  expect_no_throw("render_stochastic",
                  [&] { return end_of(render_stochastic(discs, {.samples = 4}, one_thread)); });
  Scene triangles = discs;
  triangles.objects[0].triangles = {{0, 1, 2}, {3, 4, 5}};
  expect_no_throw("render_stochastic of triangles",
                  [&] { return end_of(render_stochastic(triangles, {.samples = 4}, one_thread)); });
  expect_no_throw("render_reference",
                  [&] { return end_of(render_reference(discs, {.samples = 2}, one_thread)); });
  expect_no_throw("render_reference along the true path", [&] {
    return end_of(render_reference(discs, {.samples = 2, .motion = ReferenceMotion::smooth}, one_thread));
  });
  expect_no_throw("render_reference of splats",
                  [&] { return end_of(render_reference(splats, {.samples = 2}, one_thread)); });
  expect_no_throw("render_layers", [&] {
    return end_of(render_layers(discs, {true, true, true}, one_thread));
  });
}

// Not of sequences: the directory iterator of libstdc++ 12 ends the program where there is no memory for it.
TEST(NoThrow, WhenMemoryRunsOutWhileFilesAreReadAndWritten) {
  // OpenEXR's constructors leave behind what they had when one of their allocations fails.
  const MayLeak openexr;
  const test::TemporaryFolder folder;
  const std::string exr = folder / "image.exr", png = folder / "image.png", ply = folder / "a.0001.ply";
  const Image image = render_sampled(moving_scene(), {.samples = 2}).value().image;
  expect_no_throw(
      "write_exr", [&] { return end_of(write_exr(exr, image)); }, true);
  expect_no_throw(
      "read_exr", [&] { return end_of(read_exr(exr)); }, true);
  expect_no_throw(
      "read_exr_origin", [&] { return end_of(read_exr_origin(exr)); }, true);
  expect_no_throw(
      "write_png", [&] { return end_of(write_png(png, image)); }, true);
  std::ofstream(ply) << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                        "property float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  expect_no_throw(
      "read_points", [&] { return end_of(read_points(ply)); }, true);
  const std::string scene = std::string(SWEPT_SCENES) + "/both_ends.json",
                    splats = std::string(SWEPT_SCENES) + "/dandelion.splat";
  const Generator generator = generate;
  expect_no_throw(
      "read_splats", [&] { return end_of(read_splats(splats)); }, true);
  // Once only: nlohmann-json takes memory to free its own, and has no way out where there is none.
  expect_no_throw(
      "read_scene_file", [&] { return end_of(read_scene_file(scene)); }, true, true);
  SceneOverrides few;
  few.points_scale = 0.01;
  expect_no_throw(
      "scene_at",
      [&] {
        Result<SceneFile> file = read_scene_file(scene, few);
        if (!file) return end_of(file);
        return end_of(file->scene_at(1.0, generator));
      },
      true, true);
  expect_no_throw(
      "hash",
      [&] {
        Result<SceneFile> file = read_scene_file(scene, few);
        if (!file) return end_of(file);
        return end_of(file->hash(1.0));
      },
      true, true);
}

TEST(NoThrow, WhenMemoryRunsOutElsewhere) {
  const Image image = render_sampled(moving_scene(), {.samples = 2}).value().image;
  expect_no_throw("compare_images", [&] { return end_of(compare_images(image, image)); });
  expect_no_throw("generate", [&] { return end_of(generate("sphere", 20, {})); });
  const std::vector<Eigen::Vector3f> positions(4, {0, 0, 0}), normals(4, {0, 0, 1});
  const std::vector<float> radii(4, 0.5f);
  SurfelArrays arrays;
  arrays.position_single = positions;
  arrays.normal = normals;
  arrays.radius = radii;
  expect_no_throw("cloud_from_arrays", [&] { return end_of(cloud_from_arrays(arrays)); });
}

TEST(NoThrow, WhenACallbackDoes) {
  struct Nonsense {};
  const std::function<void(double)> broken[] = {
      [](double) { throw std::runtime_error("out of paper"); },
      [](double share) {
        if (share > 0.5) throw Nonsense();
      },
  };
  const Scene discs = moving_scene(), splats = splat_scene();
  const std::function<Result<Rendered>(const RenderControl&)> renders[] = {
      [&](const RenderControl& control) { return render_sampled(discs, {}, control); },
      [&](const RenderControl& control) { return render_sampled(splats, {}, control); },
      [&](const RenderControl& control) { return render_abuffer(discs, {}, control); },
      [&](const RenderControl& control) { return render_reference(discs, {.samples = 4}, control); },
      [&](const RenderControl& control) { return render_reference(splats, {.samples = 4}, control); },
  };
  for (const auto& render : renders) {
    for (const auto& progress : broken) {
      RenderControl control;
      control.progress = progress;
      const Result<Rendered> rendered = render(control);
      ASSERT_FALSE(rendered);
      EXPECT_EQ(rendered.error().field, "progress");
      EXPECT_EQ(rendered.error().kind, ErrorKind::argument);
      EXPECT_NE(rendered.error().reason.find("threw"), std::string::npos);
    }
    RenderControl control;
    control.log = [](const std::string&) { throw std::runtime_error("out of paper"); };
    const Result<Rendered> rendered = render(control);
    ASSERT_FALSE(rendered);
    EXPECT_NE(rendered.error().reason.find("out of paper"), std::string::npos);
  }
}

TEST(NoThrow, TheLogHearsWhatTheStatisticsSay) {
  std::vector<std::string> lines;
  RenderControl control;
  control.log = [&](const std::string& line) { lines.push_back(line); };
  const Result<Rendered> rendered = render_abuffer(moving_scene(), {}, control);
  ASSERT_TRUE(rendered);
  EXPECT_FALSE(lines.empty());
  EXPECT_EQ(lines, rendered->statistics.effects);
}

}  // namespace
}  // namespace swept
