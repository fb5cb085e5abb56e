// A method of rendering as a run of frames needs it.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

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
};

/// Renders each frame when it is submitted.
class OneByOne : public FrameRenderer {
 public:
  using Render = std::function<Result<Rendered>(const Scene&)>;
  explicit OneByOne(Render render) : render_(std::move(render)) {}

  [[nodiscard]] std::size_t most_pending() const override { return 1; }
  [[nodiscard]] Status submit(const Scene& scene) override {
    Result<Rendered> rendered = render_(scene);
    if (!rendered) return rendered.error();
    rendered_ = std::move(*rendered);
    return Done{};
  }
  [[nodiscard]] Result<Rendered> collect() override { return std::move(*std::exchange(rendered_, {})); }

 private:
  Render render_;
  std::optional<Rendered> rendered_;
};

}  // namespace swept
