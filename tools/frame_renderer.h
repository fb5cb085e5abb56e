// A method of rendering as a run of frames needs it.
#pragma once

#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// Renders scenes in the order in which they are submitted.
class FrameRenderer {
 public:
  virtual ~FrameRenderer() = default;
  /// Frames that may be submitted before the first of them is collected; ≥ 1.
  [[nodiscard]] virtual std::size_t most_pending() const = 0;
  /// The scene is not needed afterwards. A frame that fails here is not pending.
  [[nodiscard]] virtual Status submit(const Scene& scene) = 0;
  /// The frame submitted first of those pending.
  [[nodiscard]] virtual Result<Rendered> collect() = 0;
  /// What to call with the share of a frame that is done, as RenderControl::progress; a renderer may never do
  /// so.
  virtual void on_progress(std::function<void(double)> /*progress*/) {}
};

/// Renders each frame when it is submitted.
class OneByOne : public FrameRenderer {
 public:
  using Render = std::function<Result<Rendered>(const Scene&, const RenderControl&)>;
  explicit OneByOne(Render render, RenderControl control = {})
      : render_(std::move(render)), control_(std::move(control)) {}

  [[nodiscard]] std::size_t most_pending() const override { return 1; }
  [[nodiscard]] Status submit(const Scene& scene) override {
    // What no renderer expects, such as a machine that has no threads to give.
    try {
      Result<Rendered> rendered = render_(scene, control_);
      if (!rendered) return rendered.error();
      rendered_ = std::move(*rendered);
    } catch (const std::exception& exception) {
      return Error{"", "", exception.what()};
    }
    return Done{};
  }
  [[nodiscard]] Result<Rendered> collect() override { return std::move(*std::exchange(rendered_, {})); }
  void on_progress(std::function<void(double)> progress) override { control_.progress = std::move(progress); }

 private:
  Render render_;
  RenderControl control_;
  std::optional<Rendered> rendered_;
};

}  // namespace swept
