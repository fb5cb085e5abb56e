// What the device may refuse, planted: an error of the frame that it belongs to, after which all goes on.
#include <string>
#include <utility>

#include "gl_calls.h"
#include "gpu_frames.h"
#include "gpu_passes/device/context.h"
#include "gpu_passes/device/gl_errors.h"

namespace swept {
namespace {

using test::Replaced;

/// Calls of the replaced function until the one that goes wrong; not at all once it is negative.
int calls_to_failure = 0;
bool fails_now() { return calls_to_failure-- == 0; }

class GpuErrors : public GpuFrames {
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

TEST_F(GpuErrors, ALostDeviceIsAnErrorOfTheFrame) {
  const Replaced<epoxy_glClientWaitSync> wait([](GLsync sync, GLbitfield flags, GLuint64 timeout) {
    return fails_now() ? GL_WAIT_FAILED : Replaced<epoxy_glClientWaitSync>::original(sync, flags, timeout);
  });
  expect_the_first_to_fail("lost");
}

TEST_F(GpuErrors, MemoryThatCannotBeMappedIsAnErrorOfTheFrame) {
  const Replaced<epoxy_glMapBufferRange> map([](GLenum target, GLintptr offset, GLsizeiptr length,
                                                GLbitfield access) -> void* {
    return fails_now() ? nullptr : Replaced<epoxy_glMapBufferRange>::original(target, offset, length, access);
  });
  expect_the_first_to_fail("read back");
}

TEST_F(GpuErrors, MemoryThatWasTakenAwayIsAnErrorOfTheFrame) {
  const Replaced<epoxy_glUnmapBuffer> unmap([](GLenum target) -> GLboolean {
    const GLboolean intact = Replaced<epoxy_glUnmapBuffer>::original(target);
    return fails_now() ? GL_FALSE : intact;
  });
  expect_the_first_to_fail("read back");
}

TEST_F(GpuErrors, AnErrorThatShowsLateIsAnErrorOfTheFrame) {
  const Replaced<epoxy_glGetError> error(
      [] { return fails_now() ? GL_OUT_OF_MEMORY : Replaced<epoxy_glGetError>::original(); });
  expect_the_first_to_fail("not enough memory on the GPU");
}

TEST_F(GpuErrors, AnErrorThatShowsAtTheNextSubmissionIsOneOfTheFrameBefore) {
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

TEST_F(GpuErrors, WithoutMemoryForItASubmissionFailsAndTheRestGoesOn) {
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

}  // namespace
}  // namespace swept
