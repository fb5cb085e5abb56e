// The passes on a context of their own, and their targets pixel by pixel.
#pragma once

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "gpu_passes/device/context.h"
#include "gpu_passes/six_pass/pass_runner.h"
#include "gpu_stage.h"

namespace swept {

inline const Eigen::Vector3f red(1.0f, 0.0f, 0.0f), green(0.0f, 1.0f, 0.0f), blue(0.0f, 0.0f, 1.0f);

/// Kernels in, targets out.
class GpuPasses : public testing::Test {
 protected:
  void SetUp() override {
    Result<GlContext> context = GlContext::create("");
    if (!context) GTEST_SKIP() << context.error().message();
    context_.emplace(std::move(*context));
    current_.emplace(*context_);
    Result<PassRunner> runner = PassRunner::create(batch_kernels);
    ASSERT_TRUE(runner) << runner.error().message();
    runner_.emplace(std::move(*runner));
  }
  void TearDown() override {
    runner_.reset();
    current_.reset();
  }

  /// Six passes over one sub-frame, which is all of the exposure.
  void draw(const KernelSet& set, const Scene& scene) { draw_all({set}, scene); }
  /// Over sub-frames of equal shares.
  void draw_all(const std::vector<KernelSet>& sets, const Scene& scene) {
    const PixelWindow window{0, 0, scene.film.width, scene.film.height};
    width_ = window.width;
    FrameSetup setup = stage_setup(sets.front(), scene, six_passes());
    setup.block.share = 1.0f / static_cast<float>(sets.size());
    ASSERT_TRUE(runner_->begin_frame(setup));
    for (const KernelSet& set : sets) runner_->draw_subframe(make_instances(set, window));
    const Result<DrawnFrame> frame = runner_->end_frame();
    ASSERT_TRUE(frame) << frame.error().message();
    const Status status = runner_->wait(*frame);
    ASSERT_TRUE(status) << status.error().message();
    batches_ = frame->batches;
    seconds_ = *frame->seconds;
  }

  /// Channel `c` of a target at a pixel.
  [[nodiscard]] double at(Target target, int x, int y, int c = 0) const {
    const int count = channels(target);
    return static_cast<double>(runner_->read(target)[static_cast<std::size_t>(count * (y * width_ + x) + c)]);
  }
  [[nodiscard]] const PassRunner& runner() const { return *runner_; }
  /// Of the last frame drawn.
  [[nodiscard]] std::size_t batches() const { return batches_; }
  [[nodiscard]] const std::vector<double>& seconds() const { return seconds_; }

  /// Small, so that some tests take several buffers.
  static constexpr std::size_t batch_kernels = 64;

 private:
  std::optional<GlContext> context_;
  std::optional<CurrentContext> current_;
  std::optional<PassRunner> runner_;
  int width_ = 0;
  std::size_t batches_ = 0;
  std::vector<double> seconds_;
};

/// Few roundings of numbers around 1.
inline constexpr double rounding = 8 * 0x1p-24;
inline constexpr double nowhere = static_cast<double>(std::numeric_limits<float>::max());

}  // namespace swept
