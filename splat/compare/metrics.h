// How far apart two images are (model section 9): figures on linear RGB, alpha apart.
#pragma once

#include <cstddef>
#include <vector>

#include "splat/export.h"
#include "splat/image.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// Colour figures are over R, G and B as stored, premultiplied. A pixel with a NaN or an infinity in either
/// image has no finite error: it is counted, it is among those over 1/255, and all other figures are over
/// the pixels finite in both. Whoever judges by the figures must look at the two counts first.
struct ImageMetrics {
  std::size_t pixels = 0;                        ///< of the window compared
  std::size_t nonfinite_a = 0, nonfinite_b = 0;  ///< pixels with NaN or infinity in R, G, B or A
  std::size_t finite_pixels = 0;                 ///< finite in both images
  bool identical = false;                        ///< every R, G, B, A equal and finite (0 equals −0)

  double rmse = 0.0;     ///< √(Σ d² / 3n); NaN if no pixel is finite in both
  double psnr_db = 0.0;  ///< −20 log₁₀ rmse: the peak is 1; +∞ for rmse 0, NaN with rmse
  /// Mean structural similarity (Wang et al. 2004) of Rec.709 luminance: Gaussian windows of 11 × 11 px,
  /// σ 1.5 px, K₁ 0.01, K₂ 0.03, dynamic range 1. Over the windows that lie wholly within the image and hold
  /// no non-finite pixel, as in the paper; NaN if there is none.
  double ssim = 0.0;
  /// Mean FLIP at 67 pixels per degree, in [0, 1]: what an observer sees of the difference (flip.h). Over the
  /// pixels that no non-finite pixel reaches; NaN if there is none.
  double flip = 0.0;
  double max_abs = 0.0;              ///< largest |d| of a channel; NaN with rmse
  int max_abs_x = 0, max_abs_y = 0;  ///< its pixel on the film, the first in row order
  double share_over_1_255 = 0.0;     ///< of pixels with a channel more than 1/255 apart, in [0, 1]

  double alpha_rmse = 0.0, alpha_max_abs = 0.0;  ///< NaN with rmse
};

struct CompareOptions {
  bool crop_to_overlap = false;  ///< compare where the windows overlap, instead of insisting that they agree
};

/// Errors: an image that is not valid, windows or films that differ (field "window" or "film"), windows
/// that do not overlap.
[[nodiscard]] Result<ImageMetrics> compare_images(const Image& a, const Image& b,
                                                  const CompareOptions& options = {});

/// Whether compare_images would accept the windows and films of two images, whose arrays may be empty.
/// Errors: as there.
[[nodiscard]] Status check_windows(const Image& a, const Image& b, const CompareOptions& options = {});

/// scale · |a − b| per channel of RGB, alpha 1, over the same window as compare_images, which must have
/// accepted both. A pixel that is not finite in either image is `kNonfiniteMark`.
[[nodiscard]] Image difference_image(const Image& a, const Image& b, double scale,
                                     const CompareOptions& options = {});
inline constexpr float kNonfiniteMark[3] = {1.0f, 0.0f, 1.0f};

/// Mean SSIM of two luminance planes, rows of `width`; see ImageMetrics::ssim. Windows that touch a pixel
/// with a non-finite luminance in either plane are left out.
[[nodiscard]] double mean_ssim(const std::vector<double>& a, const std::vector<double>& b, int width,
                               int height);

}  // namespace swept
