#include "tools/gpu_method.h"

#include <memory>
#include <optional>
#include <utility>

#include "gpu_passes/gpu_renderer.h"

namespace swept {
namespace {

class GpuFrames : public FrameRenderer {
 public:
  explicit GpuFrames(const GpuChoice& choice)
      : device_{choice.device},
        options_{choice.still_frames ? GpuMethod::still : GpuMethod::six_pass, choice.subframes,
                 choice.lookup_tables, choice.clamp_motion} {}

  [[nodiscard]] std::size_t most_pending() const override { return device_.frames_in_flight; }

  [[nodiscard]] Status submit(const Scene& scene) override {
    if (!renderer_) {
      Result<GpuRenderer> made = GpuRenderer::create(device_);
      if (!made) {
        // Not the scene's fault: names the option or the variable where a file would stand.
        const Error& error = made.error();
        return Error{error.field == "gpu" ? "--gpu" : error.field, "", error.reason, error.kind};
      }
      renderer_.emplace(std::move(*made));
    }
    return renderer_->submit(scene, options_);
  }

  [[nodiscard]] Result<Rendered> collect() override {
    Result<Rendered> rendered = renderer_->collect();
    if (rendered) rendered->statistics.effect("device: " + renderer_->device().renderer);
    return rendered;
  }

 private:
  GpuOptions device_;
  GpuRenderOptions options_;
  std::optional<GpuRenderer> renderer_;
};

}  // namespace

std::unique_ptr<FrameRenderer> gpu_frames(const GpuChoice& choice) {
  return std::make_unique<GpuFrames>(choice);
}

Result<std::vector<std::string>> describe_gpus() {
  const Result<std::vector<GpuDevice>> devices = list_gpus();
  if (!devices) return devices.error();
  std::vector<std::string> lines;
  for (const GpuDevice& device : *devices)
    lines.push_back(device.id + ": " +
                    (device.problem.empty()
                         ? device.vendor + ", " + device.renderer + ", OpenGL " + device.version
                         : "cannot be used: " + device.problem));
  return lines;
}

}  // namespace swept
