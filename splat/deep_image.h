// A picture whose pixels hold what is seen at which depth, for compositing.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/interval/depth_sum.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// Samples of every pixel of a window of the film, rows top to bottom, each pixel's from front to back. They
/// are tidy in OpenEXR's sense: a sample begins no nearer than the one before it ends.
///
/// Alpha and premultiplied colour are those for compositing with `over`: of the light that the samples before
/// it leave, as the mean over the exposure. With aᵢ the mean over the exposure of what is seen of the sample,
/// and of its colour cᵢ, alphaᵢ = aᵢ / (1 − Σⱼ₍ⱼ﹤ᵢ₎ aⱼ), and cᵢ likewise. So flattened samples are the
/// picture, and what is put among them and stands still is covered as much as it is on average.
struct DeepImage {
  int x = 0, y = 0, width = 0, height = 0;  ///< window within the film, px
  int film_width = 0, film_height = 0;
  std::vector<std::size_t> first;  ///< a pixel's first sample; one entry more than pixels, the last the count
  std::vector<float> rgba;         ///< 4 per sample, linear
  /// 2 per sample: where in camera-space z it begins and where it ends; equal for what has no thickness.
  std::vector<float> depth;

  [[nodiscard]] std::size_t pixel_count() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  [[nodiscard]] std::size_t sample_count() const { return first.empty() ? 0 : first.back(); }

  /// Window and film hold at least a pixel, the arrays fit each other, and the samples are tidy, with depths
  /// that are finite numbers above 0. The error's field names the member.
  [[nodiscard]] Status validate() const;
};

/// Appends a pixel to first, rgba and depth. `parts` is in any state that DepthSum leaves it in, its light to
/// be multiplied by `scale`. `background` is what is behind all, premultiplied: where it is not transparent
/// black it is the last sample, at the largest float's depth.
void append_pixel(const std::vector<DepthPart>& parts, double scale, const Eigen::Vector4d& background,
                  DeepImage& image);

}  // namespace swept
