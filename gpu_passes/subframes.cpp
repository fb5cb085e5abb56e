#include "gpu_passes/subframes.h"

#include <algorithm>

namespace swept {
namespace {

bool nothing_moves(const Scene& scene) {
  const double first = scene.frame + scene.shutter.open, last = scene.frame + scene.shutter.close;
  return first == last ||
         (scene.camera.constant_over(first, last) &&
          std::none_of(scene.objects.begin(), scene.objects.end(), [&](const Object& object) {
            return object.cloud.moves() || !object.transform.constant_over(first, last);
          }));
}

}  // namespace

Subframes::Subframes(const Scene& scene, const GpuRenderOptions& options)
    : part_(scene),
      shutter_(scene.shutter),
      still_frames_(options.method == GpuMethod::still),
      nothing_moves_(nothing_moves(scene)),
      count_(nothing_moves_ ? 1 : options.subframes) {
  part_.model.segments = 1;
  for (Object& object : part_.objects) object.segments = 0;
}

KernelSet Subframes::kernels(int j) {
  const double length = shutter_.close - shutter_.open;
  const auto at = [&](double share) { return shutter_.open + share * length; };
  const double n = count_;
  part_.shutter = {j == 0 ? shutter_.open : at(j / n), j + 1 == count_ ? shutter_.close : at((j + 1) / n)};
  if (still_frames_) part_.shutter.open = part_.shutter.close = at((j + 0.5) / n);
  return build_kernels(part_);
}

}  // namespace swept
