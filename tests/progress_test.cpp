// What a run says of itself on stderr, on a terminal and elsewhere.
#include "tools/progress.h"

#include <chrono>
#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace swept {
namespace {

/// Longer than the bar's own pause.
void wait() { std::this_thread::sleep_for(std::chrono::milliseconds(120)); }

TEST(Progress, ABarMovesWithinAFrameAndALineStays) {
  ::testing::internal::CaptureStderr();
  {
    Progress progress(2, true);
    progress.begin_frame(7);
    wait();
    progress.within_frame(0.5);
    progress.within_frame(0.6);  // too soon to be drawn
    wait();
    progress.within_frame(0.4);  // never back
    progress.end_frame(7, 0.1, "f.7.exr");
    progress.begin_frame(8);
    progress.end_frame(8, 0.1, "f.8.exr");
    progress.finish();
  }
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(text.find("25%, 0 of 2, frame 7"), std::string::npos) << text;
  EXPECT_NE(text.find("30%, 0 of 2, frame 7"), std::string::npos) << text;
  EXPECT_EQ(text.find("20%"), std::string::npos) << text;
  EXPECT_NE(text.find("100%, 2 of 2"), std::string::npos) << text;
  EXPECT_NE(text.find("remaining 0:0"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("\x1b[K2 frames in 0:00\n")) << text;
}

TEST(Progress, ElsewhereThereAreLines) {
  ::testing::internal::CaptureStderr();
  {
    Progress progress(3, false);
    progress.begin_frame(1);
    wait();
    progress.within_frame(0.5);
    progress.end_frame(1, 0.25, "f.1.exr");
    progress.skip_frame(2, "f.2.exr");
    progress.note("a\x1bnote");
    progress.finish();
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "frame 1: 1 of 3, 0.25 s, f.1.exr\nframe 2: 2 of 3, f.2.exr exists\na\\x1bnote\n"
            "1 frame in 0:00, 1 skipped\n");
}

}  // namespace
}  // namespace swept
