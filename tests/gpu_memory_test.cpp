// Hundreds of frames and dozens of renderers leave nothing behind.
#include <fstream>
#include <vector>

#include <unistd.h>

#include "gl_calls.h"
#include "gpu_frames.h"

// AddressSanitizer holds back 256 MB of what is freed, which looks like a leak to these tests.
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "quarantine_size_mb=1"; }
// NOLINTEND(bugprone-reserved-identifier)

namespace swept {
namespace {

using test::LiveObjects;

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
  // One that is lost keeps 10 MiB.
  EXPECT_LT(resident_bytes(), bytes_before + 20u * (1u << 20));
}

}  // namespace
}  // namespace swept
