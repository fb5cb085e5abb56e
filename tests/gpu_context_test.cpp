// Contexts without a display: what is listed works, and what is missing is said, never a crash.
#include "gpu_passes/device/context.h"

#include <cstdio>
#include <cstdlib>
#include <thread>

#include <epoxy/gl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "gpu_passes/device/egl_library.h"
#include "gpu_passes/gpu_renderer.h"

namespace swept {
namespace {

TEST(GpuContext, EveryUsableDeviceOfTheListMakesAContext) {
  const Result<std::vector<GpuDevice>> devices = list_gpus();
  if (!devices) GTEST_SKIP() << devices.error().message();
  int usable = 0;
  for (const GpuDevice& device : *devices) {
    SCOPED_TRACE(device.id);
    const Result<GlContext> context = GlContext::create(device.id);
    EXPECT_EQ(context.ok(), device.problem.empty());
    if (!context) continue;
    ++usable;
    EXPECT_EQ(context->device().renderer, device.renderer);
    EXPECT_FALSE(device.vendor.empty());
    EXPECT_FALSE(device.renderer.empty());
    const CurrentContext current(*context);
    ASSERT_TRUE(current.status());
    EXPECT_GE(epoxy_gl_version(), 43);
  }
  if (usable == 0) GTEST_SKIP() << "no device with OpenGL 4.3 here";
}

TEST(GpuContext, RefusesADeviceThatIsNotThere) {
  if (!list_gpus()) GTEST_SKIP() << "no EGL here";
  for (const char* id : {"4711", "-1", "0x", "first", "1.0"}) {
    const Result<GlContext> context = GlContext::create(id);
    ASSERT_FALSE(context.ok()) << id;
    EXPECT_NE(context.error().reason.find(id), std::string::npos) << context.error().message();
  }
}

TEST(GpuContext, TheVariableNamesTheDevice) {
  if (!list_gpus()) GTEST_SKIP() << "no EGL here";
  ASSERT_EQ(setenv("SWEPT_GPU", "4711", 1), 0);
  const Result<GlContext> context = GlContext::create("");
  unsetenv("SWEPT_GPU");
  ASSERT_FALSE(context.ok());
  EXPECT_EQ(context.error().field, "SWEPT_GPU");
}

TEST(GpuContext, NamesTheLibraryThatIsMissing) {
  EXPECT_TRUE(find_libraries({{"libnowhere.so.7", "libc.so.6"}}));
  const Status status = find_libraries({{"libc.so.6"}, {"libnowhere.so.7", "libneither.so.1"}});
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().reason.find("libnowhere.so.7 or libneither.so.1"), std::string::npos);
}

TEST(GpuContext, IsCurrentForItsTurnAndThenGivesTheThreadBack) {
  const Result<GlContext> outer = GlContext::create("");
  const Result<GlContext> inner = GlContext::create("");
  if (!outer || !inner) GTEST_SKIP() << outer.error().message();
  ASSERT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
  {
    const CurrentContext first(*outer);
    EXPECT_EQ(eglGetCurrentContext(), outer->handle());
    {
      const CurrentContext second(*inner);
      EXPECT_EQ(eglGetCurrentContext(), inner->handle());
    }
    EXPECT_EQ(eglGetCurrentContext(), outer->handle());
  }
  EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
}

TEST(GpuContext, SaysSoWhereAnotherThreadHasTheContext) {
  const Result<GlContext> context = GlContext::create("");
  if (!context) GTEST_SKIP() << context.error().message();
  const CurrentContext here(*context);
  ASSERT_TRUE(here.status());
  std::thread([&] {
    const CurrentContext there(*context);
    EXPECT_FALSE(there.status().ok());
  }).join();
}

/// Creates a renderer where `variable` is set, and prints why there is none: 0. Prints its vendor: 1.
int without_driver(const char* variable, const char* value) {
  setenv(variable, value, 1);
  unsetenv("SWEPT_GPU");
  const Result<GpuRenderer> renderer = GpuRenderer::create();
  std::fprintf(stderr, "%s\n",
               renderer ? renderer->device().vendor.c_str() : renderer.error().message().c_str());
  return renderer ? 1 : 0;
}

/// Each in a process of its own, and nothing before: drivers read their variables once.
class GpuContextDeathTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!find_libraries(egl_libraries())) GTEST_SKIP() << "no EGL here";
    GTEST_FLAG_SET(death_test_style, "threadsafe");
  }
};

TEST_F(GpuContextDeathTest, WithoutADriverThereIsAMessageAndNoCrash) {
  // The dispatch library finds no vendor at all.
  EXPECT_EXIT(std::exit(without_driver("__EGL_VENDOR_LIBRARY_FILENAMES", "/nowhere.json")),
              testing::ExitedWithCode(0), "no OpenGL 4.3 without a display.*lists no devices");
}

TEST_F(GpuContextDeathTest, ADriverThatIsTooOldIsRefused) {
  // Mesa's own switch.
  const auto exits = [](int status) { return WIFEXITED(status) && WEXITSTATUS(status) <= 1; };
  EXPECT_EXIT(std::exit(without_driver("MESA_GL_VERSION_OVERRIDE", "3.3")), exits,
              "it has no OpenGL 4.3 core|NVIDIA");
}

}  // namespace
}  // namespace swept
