#include "tools/gpu_method.h"

namespace swept {
namespace {

Error not_built() { return {"", "", "this swept was built without the GPU modes (SWEPT_GPU=OFF)"}; }

}  // namespace

std::function<Result<Rendered>(const Scene&)> gpu_method(const GpuChoice&) {
  return [](const Scene&) -> Result<Rendered> { return not_built(); };
}

Result<std::vector<std::string>> describe_gpus() { return not_built(); }

}  // namespace swept
