// Several frames in flight: each comes back whole, in its turn, with its own numbers; and nothing stays
// behind.
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "gl_calls.h"
#include "gpu_passes/context.h"
#include "gpu_passes/gl_errors.h"
#include "gpu_passes/gpu_renderer.h"
#include "gpu_stage.h"

namespace swept {
namespace {

using test::LiveObjects;
using test::Replaced;

GpuRenderOptions six(int subframes) { return {GpuMethod::six_pass, subframes, false}; }

/// A striped ball that flies through a small film.
Scene ball(int width = 48, int height = 32) {
  Scene scene;
  scene.film = {width, height, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats.emplace_back();
  scene.camera.look_ats.back().eye.z() = 3.5;
  scene.background = {0.05f, 0.1f, 0.2f, 1.0f};
  scene.objects = {striped_sphere(0.8, 600)};
  TransformKey key;
  key.translate = {-0.4, 0.0, 0.0};
  scene.objects[0].transform.keys.push_back(key);
  key.frame = 1.0;
  key.translate = {0.4, 0.1, 0.2};
  scene.objects[0].transform.keys.push_back(key);
  return scene;
}

double counter(const Rendered& rendered, const std::string& name) {
  for (const auto& [key, value] : rendered.statistics.counters)
    if (key == name) return value;
  ADD_FAILURE() << "no counter " << name;
  return 0.0;
}

std::vector<double> pass_seconds(const Rendered& rendered) {
  std::vector<double> seconds;
  for (const auto& [stage, value] : rendered.statistics.seconds)
    if (stage.ends_with(", GPU")) seconds.push_back(value);
  return seconds;
}

class GpuFrames : public testing::Test {
 protected:
  void SetUp() override { create({}); }
  void create(const GpuOptions& options) {
    Result<GpuRenderer> renderer = GpuRenderer::create(options);
    if (!renderer) GTEST_SKIP() << renderer.error().message();
    renderer_.emplace(std::move(*renderer));
  }

  void submit(const Scene& scene, const GpuRenderOptions& options) {
    const Status status = renderer_->submit(scene, options);
    EXPECT_TRUE(status) << status.error().message();
  }
  Rendered collect() {
    Result<Rendered> rendered = renderer_->collect();
    EXPECT_TRUE(rendered) << rendered.error().message();
    return rendered ? std::move(*rendered) : Rendered{};
  }
  Image render(const Scene& scene, const GpuRenderOptions& options) {
    Result<Rendered> rendered = renderer_->render(scene, options);
    EXPECT_TRUE(rendered) << rendered.error().message();
    return rendered ? std::move(rendered->image) : Image{};
  }

  std::optional<GpuRenderer> renderer_;
};

TEST_F(GpuFrames, ComeBackInTheirOrderAsIfRenderedAlone) {
  struct Frame {
    Scene scene;
    GpuRenderOptions options;
  };
  // Other sizes, methods, shaders and lengths from one frame to the next, and two that are alike.
  std::vector<Frame> frames{{ball(), six(1)},
                            {ball(20, 40), six(4)},
                            {ball(20, 40), {GpuMethod::still, 3, false}},
                            {ball(64, 16), {GpuMethod::six_pass, 2, true}},
                            {ball(), six(5)},
                            {ball(), six(5)}};
  frames[5].scene.background = {1.0f, 0.0f, 0.0f, 1.0f};
  std::vector<Image> alone;
  for (const Frame& frame : frames) alone.push_back(render(frame.scene, frame.options));
  for (const std::size_t in_flight : {1u, 2u, 5u}) {
    SCOPED_TRACE(in_flight);
    GpuOptions options;
    options.frames_in_flight = in_flight;
    create(options);
    ASSERT_EQ(renderer_->most_pending(), in_flight);
    std::size_t next = 0;
    for (const Frame& frame : frames) {
      submit(frame.scene, frame.options);
      if (renderer_->pending() < in_flight) continue;
      EXPECT_EQ(collect().image.rgba, alone[next].rgba) << next;
      ++next;
    }
    for (; next < frames.size(); ++next) {
      EXPECT_EQ(renderer_->pending(), frames.size() - next);
      const Image image = collect().image;
      EXPECT_EQ(image.rgba, alone[next].rgba) << next;
      EXPECT_EQ(image.depth, alone[next].depth) << next;
    }
    EXPECT_EQ(renderer_->pending(), 0u);
  }
}

TEST_F(GpuFrames, TooManyAndNoneAreErrorsThatLoseNothing) {
  const Image first = render(ball(), six(1)), second = render(ball(20, 40), six(1));
  EXPECT_FALSE(renderer_->collect().ok());
  submit(ball(), six(1));
  submit(ball(20, 40), six(1));
  const Status full = renderer_->submit(ball(), six(1));
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().field, "frames_in_flight");
  EXPECT_EQ(renderer_->render(ball(), six(1)).error().field, "frames_in_flight");
  EXPECT_EQ(collect().image.rgba, first.rgba);
  EXPECT_EQ(collect().image.rgba, second.rgba);
  EXPECT_FALSE(renderer_->collect().ok());
  EXPECT_EQ(render(ball(), six(1)).rgba, first.rgba);
  for (const std::size_t bad : {0u, 17u}) {
    GpuOptions options;
    options.frames_in_flight = bad;
    const Result<GpuRenderer> refused = GpuRenderer::create(options);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().field, "frames_in_flight");
  }
}

TEST_F(GpuFrames, OneThatIsRefusedLeavesThoseBeforeIt) {
  const Image first = render(ball(), six(2));
  submit(ball(), six(2));
  Scene scene = ball();
  scene.objects[0].cloud.opacity.assign(scene.objects[0].cloud.size(), 0.5f);
  EXPECT_FALSE(renderer_->submit(scene, six(1)).ok());
  scene = ball();
  scene.film = {65536, 1, 0, 0, 0, 0};
  EXPECT_EQ(renderer_->submit(scene, six(1)).error().field, "/film");
  EXPECT_EQ(renderer_->pending(), 1u);
  submit(ball(), six(2));
  EXPECT_EQ(collect().image.rgba, first.rgba);
  EXPECT_EQ(collect().image.rgba, first.rgba);
}

int waits = 0, unbuffered_reads = 0;

TEST_F(GpuFrames, SubmittingDoesNotWaitForTheDevice) {
  const Replaced<epoxy_glFinish> finish([] {
    ++waits;
    Replaced<epoxy_glFinish>::original();
  });
  const Replaced<epoxy_glClientWaitSync> wait([](GLsync sync, GLbitfield flags, GLuint64 timeout) {
    ++waits;
    return Replaced<epoxy_glClientWaitSync>::original(sync, flags, timeout);
  });
  const Replaced<epoxy_glGetQueryObjectui64v> query([](GLuint name, GLenum parameter, GLuint64* value) {
    ++waits;
    Replaced<epoxy_glGetQueryObjectui64v>::original(name, parameter, value);
  });
  const Replaced<epoxy_glMapBufferRange> map(
      [](GLenum target, GLintptr offset, GLsizeiptr length, GLbitfield access) {
        ++waits;
        return Replaced<epoxy_glMapBufferRange>::original(target, offset, length, access);
      });
  const Replaced<epoxy_glGetTexImage> read(
      [](GLenum target, GLint level, GLenum format, GLenum type, void* pixels) {
        GLint buffer = 0;
        glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &buffer);
        unbuffered_reads += buffer == 0 ? 1 : 0;
        Replaced<epoxy_glGetTexImage>::original(target, level, format, type, pixels);
      });
  waits = unbuffered_reads = 0;
  // As many sub-frames as the device may be behind.
  submit(ball(), six(1));
  submit(ball(), six(1));
  EXPECT_EQ(waits, 0);
  collect();
  EXPECT_GT(waits, 0);
  waits = 0;
  collect();
  EXPECT_GT(waits, 0);
  EXPECT_EQ(unbuffered_reads, 0);
}

TEST_F(GpuFrames, EachHasItsOwnTimesAndCounts) {
  // Every query of the device's clock gives a millisecond.
  const Replaced<epoxy_glGetQueryObjectui64v> query(
      [](GLuint, GLenum, GLuint64* nanoseconds) { *nanoseconds = 1'000'000; });
  const std::vector<int> counts{3, 5, 1, 1, 2};
  std::size_t next = 0;
  const auto check = [&] {
    const Rendered rendered = collect();
    const int n = counts[next++];
    EXPECT_EQ(counter(rendered, "subframes"), n);
    EXPECT_EQ(counter(rendered, "kernels"), 600.0 * n);
    const std::vector<double> seconds = pass_seconds(rendered);
    EXPECT_EQ(seconds.size(), 6u);
    for (const double value : seconds) EXPECT_NEAR(value, 1e-3 * n, 1e-12) << n;
  };
  for (const int n : counts) {
    submit(ball(), six(n));
    if (renderer_->pending() == renderer_->most_pending()) check();
  }
  while (renderer_->pending() > 0) check();
  EXPECT_EQ(next, counts.size());
}

TEST_F(GpuFrames, WithoutAClockTheyAreNotTimed) {
  const Image timed = render(ball(), six(3));
  const Replaced<epoxy_glGetQueryiv> no_clock([](GLenum, GLenum, GLint* bits) { *bits = 0; });
  create({});
  const Result<Rendered> rendered = renderer_->render(ball(), six(3));
  ASSERT_TRUE(rendered);
  EXPECT_EQ(rendered->image.rgba, timed.rgba);
  EXPECT_TRUE(pass_seconds(*rendered).empty());
}

/// Calls of the replaced function until the one that goes wrong; not at all once it is negative.
int calls_to_failure = 0;
bool fails_now() { return calls_to_failure-- == 0; }

class GpuFramesFailing : public GpuFrames {
 protected:
  /// Two frames in flight, of which the first cannot be collected.
  void expect_the_first_to_fail(const std::string& reason) {
    calls_to_failure = -1;
    const Image second = render(ball(20, 40), six(2));
    submit(ball(), six(2));
    submit(ball(20, 40), six(2));
    calls_to_failure = 0;
    const Result<Rendered> lost = renderer_->collect();
    ASSERT_FALSE(lost.ok());
    EXPECT_NE(lost.error().message().find(reason), std::string::npos) << lost.error().message();
    EXPECT_LT(calls_to_failure, 0);
    EXPECT_EQ(renderer_->pending(), 1u);
    EXPECT_EQ(collect().image.rgba, second.rgba);
    EXPECT_EQ(render(ball(20, 40), six(2)).rgba, second.rgba);
  }
};

TEST_F(GpuFramesFailing, ALostDeviceIsAnErrorOfTheFrame) {
  const Replaced<epoxy_glClientWaitSync> wait([](GLsync sync, GLbitfield flags, GLuint64 timeout) {
    return fails_now() ? GL_WAIT_FAILED : Replaced<epoxy_glClientWaitSync>::original(sync, flags, timeout);
  });
  expect_the_first_to_fail("lost");
}

TEST_F(GpuFramesFailing, MemoryThatCannotBeMappedIsAnErrorOfTheFrame) {
  const Replaced<epoxy_glMapBufferRange> map([](GLenum target, GLintptr offset, GLsizeiptr length,
                                                GLbitfield access) -> void* {
    return fails_now() ? nullptr : Replaced<epoxy_glMapBufferRange>::original(target, offset, length, access);
  });
  expect_the_first_to_fail("read back");
}

TEST_F(GpuFramesFailing, MemoryThatWasTakenAwayIsAnErrorOfTheFrame) {
  const Replaced<epoxy_glUnmapBuffer> unmap([](GLenum target) -> GLboolean {
    const GLboolean intact = Replaced<epoxy_glUnmapBuffer>::original(target);
    return fails_now() ? GL_FALSE : intact;
  });
  expect_the_first_to_fail("read back");
}

TEST_F(GpuFramesFailing, AnErrorThatShowsLateIsAnErrorOfTheFrame) {
  const Replaced<epoxy_glGetError> error(
      [] { return fails_now() ? GL_OUT_OF_MEMORY : Replaced<epoxy_glGetError>::original(); });
  expect_the_first_to_fail("not enough memory on the GPU");
}

TEST_F(GpuFramesFailing, AnErrorThatShowsAtTheNextSubmissionIsOneOfTheFrameBefore) {
  const Replaced<epoxy_glGetError> error(
      [] { return fails_now() ? GL_OUT_OF_MEMORY : Replaced<epoxy_glGetError>::original(); });
  calls_to_failure = -1;
  const Image second = render(ball(20, 40), six(2));
  submit(ball(), six(2));
  calls_to_failure = 0;
  submit(ball(20, 40), six(2));
  EXPECT_FALSE(renderer_->collect().ok());
  EXPECT_EQ(collect().image.rgba, second.rgba);
}

TEST_F(GpuFramesFailing, WithoutMemoryForItASubmissionFailsAndTheRestGoesOn) {
  calls_to_failure = -1;
  const Image image = render(ball(), six(2));
  // An upload fails as the driver would say it: with an error, and nothing done. The first one is the frame's
  // block, then the sub-frames' kernels, then the pixel buffer of another size.
  static bool out_of_memory = false;
  const Replaced<epoxy_glBufferData> data(
      [](GLenum target, GLsizeiptr size, const void* bytes, GLenum usage) {
        if (fails_now())
          out_of_memory = true;
        else
          Replaced<epoxy_glBufferData>::original(target, size, bytes, usage);
      });
  const Replaced<epoxy_glGetError> error([] {
    return std::exchange(out_of_memory, false) ? GL_OUT_OF_MEMORY : Replaced<epoxy_glGetError>::original();
  });
  submit(ball(), six(2));
  for (int call = 0; call < 4; ++call) {
    SCOPED_TRACE(call);
    calls_to_failure = call;
    const Status status = renderer_->submit(ball(24, 40), six(2));
    EXPECT_LT(calls_to_failure, 0);
    ASSERT_FALSE(status.ok());
    EXPECT_NE(status.error().reason.find("not enough memory"), std::string::npos);
    EXPECT_EQ(renderer_->pending(), 1u);
  }
  EXPECT_EQ(collect().image.rgba, image.rgba);
  EXPECT_EQ(render(ball(), six(2)).rgba, image.rgba);
}

TEST(GlErrors, AreNamedOnceWithWhatTheDriverSays) {
  const Result<GlContext> context = GlContext::create("");
  if (!context) GTEST_SKIP() << context.error().message();
  const CurrentContext current(*context);
  keep_error_messages();
  EXPECT_TRUE(take_errors("testing"));
  glEnable(0xdead);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glDrawArrays(GL_TRIANGLES, -1, 3);
  const Status status = take_errors("testing");
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().reason.find("GL_INVALID_ENUM while testing"), std::string::npos)
      << status.error().reason;
  RecordProperty("message", status.error().reason);
  EXPECT_TRUE(take_errors("testing"));
}

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

class GpuMemory : public GpuFrames {};

TEST_F(GpuMemory, ThreeHundredFramesInARowTakeNoMoreThanAFew) {
  renderer_.reset();
  const LiveObjects objects;
  create({});
  // All sizes, passes and shaders have their turn within twelve frames.
  const std::vector<Scene> scenes{ball(128, 128), ball(128, 128), ball(64, 128), ball(128, 64)};
  int next = 0;
  const auto frames = [&](int count) {
    for (const int end = next + count; next < end; ++next) {
      const GpuRenderOptions options{next % 3 == 2 ? GpuMethod::still : GpuMethod::six_pass, 1 + next % 2,
                                     next % 5 == 0, false};
      submit(scenes[static_cast<std::size_t>(next % 4)], options);
      if (renderer_->pending() == 2) collect();
    }
    collect();
  };
  frames(60);
  const int objects_before = LiveObjects::count();
  const std::size_t bytes_before = resident_bytes();
  EXPECT_GT(objects_before, 0);
  frames(240);
  EXPECT_EQ(LiveObjects::count(), objects_before);
  // Lost once a frame, the smallest of what a frame takes would be 240 times 96 kB of kernels: 22 MiB.
  EXPECT_LT(resident_bytes(), bytes_before + 6u * (1u << 20));
  submit(scenes[0], six(1));
  renderer_.reset();
  EXPECT_EQ(LiveObjects::count(), 0);
}

TEST_F(GpuMemory, FiftyRenderersLeaveNothingBehind) {
  const LiveObjects objects;
  const auto renderers = [&](int count) {
    for (int i = 0; i < count; ++i) {
      create({});
      submit(ball(), six(1));
      submit(ball(), six(2));
      // With a frame in flight, or after all.
      for (int collected = 0; collected < i % 3; ++collected) collect();
      renderer_.reset();
    }
  };
  renderer_.reset();
  const int before = LiveObjects::count();
  renderers(10);
  EXPECT_EQ(LiveObjects::count(), before);
  const std::size_t bytes_before = resident_bytes();
  renderers(40);
  EXPECT_EQ(LiveObjects::count(), before);
  RecordProperty("growth_kib", std::to_string((resident_bytes() - bytes_before) / 1024));
}

}  // namespace
}  // namespace swept
