#include "tools/gpu_method.h"

#include <memory>
#include <optional>
#include <utility>

#include "gpu_passes/gpu_renderer.h"

namespace swept {

std::function<Result<Rendered>(const Scene&)> gpu_method(const GpuChoice& choice) {
  const GpuOptions device{choice.device};
  const GpuRenderOptions options{choice.still_frames ? GpuMethod::still : GpuMethod::six_pass,
                                 choice.subframes, choice.lookup_tables, choice.clamp_motion};
  const auto renderer = std::make_shared<std::optional<GpuRenderer>>();
  return [=](const Scene& scene) -> Result<Rendered> {
    if (!*renderer) {
      Result<GpuRenderer> made = GpuRenderer::create(device);
      if (!made) {
        // Not the scene's fault: names the option or the variable where a file would stand.
        const Error& error = made.error();
        return Error{error.field == "gpu" ? "--gpu" : error.field, "", error.reason};
      }
      renderer->emplace(std::move(*made));
    }
    Result<Rendered> rendered = (*renderer)->render(scene, options);
    if (rendered) rendered->statistics.effect("device: " + (*renderer)->device().renderer);
    return rendered;
  };
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
