#include "tools/gpu_method.h"

namespace swept {
namespace {

Error not_built() { return {"", "", "this swept was built without the GPU modes (SWEPT_GPU=OFF)"}; }

}  // namespace

std::unique_ptr<FrameRenderer> gpu_frames(const GpuChoice&) {
  return std::make_unique<OneByOne>(
      [](const Scene&, const RenderControl&) -> Result<Rendered> { return not_built(); });
}

Result<std::vector<std::string>> describe_gpus() { return not_built(); }

}  // namespace swept
