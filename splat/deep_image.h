// An image whose pixels hold samples by depth, for compositing.
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
/// Alpha and premultiplied colour of a sample are those for compositing with `over`: shares of the light that
/// the samples before it leave in the mean over the exposure. With aᵢ the mean over the exposure of what is
/// seen of sample i, alphaᵢ = aᵢ / (1 − Σⱼ₍ⱼ﹤ᵢ₎ aⱼ); the colour is its mean divided likewise. So flattened
/// samples give the picture, and an object that is put among them and stands still is covered as much as it
/// is on average.
struct DeepImage {
  int x = 0, y = 0, width = 0, height = 0;  ///< window within the film, px
  int film_width = 0, film_height = 0;
  /// The index of each pixel's first sample, row by row; one entry more than pixels, the last being the
  /// count.
  std::vector<std::size_t> first;
  std::vector<float> rgba;  ///< 4 per sample, linear
  /// 2 per sample: the camera-space z at which it begins and ends; equal if it has no thickness.
  std::vector<float> depth;

  [[nodiscard]] std::size_t pixel_count() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  [[nodiscard]] std::size_t sample_count() const { return first.empty() ? 0 : first.back(); }

  /// Window and film hold at least a pixel, the arrays fit each other, and the samples are tidy, with finite
  /// depths above 0. The error's field names the member.
  [[nodiscard]] Status validate() const;
};

/// Appends a pixel to first, rgba and depth. `parts` are those of a DepthSum; their light is multiplied by
/// `scale`. `background` is what is behind everything, premultiplied RGBA. If it is not transparent black, it
/// becomes the last sample, at the depth of the largest float.
void append_pixel(const std::vector<DepthPart>& parts, double scale, const Eigen::Vector4d& background,
                  DeepImage& image);

}  // namespace swept
