// Several frames in flight: each comes back whole, in its turn, with its own numbers.
#include "gpu_frames.h"

#include <string>
#include <vector>

#include "gl_calls.h"
#include "tests/counter.h"

namespace swept {
namespace {

using test::counter;
using test::Replaced;

std::vector<double> pass_seconds(const Rendered& rendered) {
  std::vector<double> seconds;
  for (const auto& [stage, value] : rendered.statistics.seconds)
    if (stage.ends_with(", GPU")) seconds.push_back(value);
  return seconds;
}

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

}  // namespace
}  // namespace swept
