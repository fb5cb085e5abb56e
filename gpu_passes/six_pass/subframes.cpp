#include "gpu_passes/six_pass/subframes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "gpu_passes/six_pass/clamp_motion.h"
#include "splat/kernel/screen_bounds.h"
#include "splat/motion/segments.h"

namespace swept {
namespace {

/// Farthest motion in a chosen sub-frame, px: the depths at its ends stand for all of it, so it should be
/// about as long as a few discs are large. Still frames farther apart than a pixel show as copies.
constexpr double subframe_px = 8.0, still_frame_px = 1.0;
constexpr int most_chosen = 256;
/// Parts in which the motion is measured, each by its chord.
constexpr int measured_parts = 8;

}  // namespace

Subframes::Subframes(const Scene& scene, const GpuRenderOptions& options)
    : scene_(scene),
      still_frames_(options.method == GpuMethod::still),
      clamp_motion_(options.clamp_motion && !still_frames_),
      nothing_moves_(nothing_moves(scene, scene.exposure())),
      count_(nothing_moves_ ? 1 : options.subframes) {
  scene_.model.segments = 1;
  for (Object& object : scene_.objects) object.segments = 0;
  if (count_ == 0) count_ = choose();
}

int Subframes::choose() {
  const bool still_frames = std::exchange(still_frames_, false);
  count_ = measured_parts;
  const Film& film = scene_.film;
  const PixelBox window{double(film.crop_x), double(film.crop_x + film.window_width()), double(film.crop_y),
                        double(film.crop_y + film.window_height())};
  double farthest = 0.0;
  for (int part = 0; part < measured_parts; ++part) {
    const KernelSet set = kernels(part);
    Octagon octagon;
    for (const MovingKernel& kernel : set.kernels) {
      if (!screen_bounds(kernel, set.projection, set.near, octagon) || !octagon.overlaps(window)) continue;
      const auto middle = [](const PixelBox& box) {
        return Eigen::Vector2d(0.5 * (box.x_min + box.x_max), 0.5 * (box.y_min + box.y_max));
      };
      farthest = std::max(farthest, (middle(octagon.end) - middle(octagon.begin)).norm());
    }
  }
  still_frames_ = still_frames;
  const double wanted = std::ceil(farthest * measured_parts / (still_frames ? still_frame_px : subframe_px));
  return static_cast<int>(std::clamp(wanted, 1.0, double(most_chosen)));
}

KernelSet Subframes::kernels(int j) {
  const Exposure whole = scene_.exposure();
  const double n = count_;
  const Exposure part = still_frames_ ? whole.instant_at((j + 0.5) / n) : whole.part(j / n, (j + 1) / n);
  KernelSet set = build_kernels(scene_, part);
  if (clamp_motion_)
    for (MovingKernel& kernel : set.kernels) kernel.velocity = clamped_motion(kernel);
  return set;
}

}  // namespace swept
