#include "splat/compare/metrics.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace swept {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
const float kNan = std::nanf("");

Image flat(int width, int height, float value, float alpha = 1.0f) {
  Image image{0, 0, width, height, width, height, {}, {}};
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    for (const float c : {value, value, value, alpha}) image.rgba.push_back(c);
  }
  return image;
}

Image noise(int width, int height) {
  Image image = flat(width, height, 0.0f);
  std::mt19937 generator(3);
  for (float& value : image.rgba) value = static_cast<float>(generator() >> 8) * 0x1p-24f;
  return image;
}

float& at(Image& image, int x, int y, int channel) {
  return image.rgba[static_cast<std::size_t>(4 * (y * image.width + x) + channel)];
}

ImageMetrics compared(const Image& a, const Image& b, const CompareOptions& options = {}) {
  const Result<ImageMetrics> result = compare_images(a, b, options);
  if (!result) {
    ADD_FAILURE() << result.error().message();
    return {};
  }
  return *result;
}

TEST(Metrics, AnImageEqualsItself) {
  const Image image = noise(40, 30);
  const ImageMetrics m = compared(image, image);
  EXPECT_TRUE(m.identical);
  EXPECT_EQ(m.pixels, 1200u);
  EXPECT_EQ(m.finite_pixels, 1200u);
  EXPECT_EQ(m.rmse, 0.0);
  EXPECT_EQ(m.psnr_db, std::numeric_limits<double>::infinity());
  EXPECT_EQ(m.ssim, 1.0);  // numerator and denominator are the same sums
  EXPECT_EQ(m.max_abs, 0.0);
  EXPECT_EQ(m.share_over_1_255, 0.0);
  EXPECT_EQ(m.alpha_rmse, 0.0);
}

TEST(Metrics, AConstantOffsetHasItsClosedForm) {
  // Powers of two: the differences and their squares are exact.
  const ImageMetrics m = compared(flat(32, 16, 0.5f), flat(32, 16, 0.25f));
  EXPECT_FALSE(m.identical);
  EXPECT_EQ(m.rmse, 0.25);
  EXPECT_DOUBLE_EQ(m.psnr_db, -20.0 * std::log10(0.25));
  EXPECT_EQ(m.max_abs, 0.25);
  EXPECT_EQ(m.max_abs_x, 0);
  EXPECT_EQ(m.max_abs_y, 0);
  EXPECT_EQ(m.share_over_1_255, 1.0);
  // Without variance SSIM is its luminance term. The 22 weights and sums round the moments, all below 1/4, by
  // at most 22 ulp(1/4) < 2e-15, which the variances hold against C₂ = 9e-4: below 1e-11 of the value.
  constexpr double kC1 = 1e-4;
  EXPECT_NEAR(m.ssim, (2 * 0.5 * 0.25 + kC1) / (0.25 + 0.0625 + kC1), 1e-11);
}

TEST(Metrics, OneWrongChannelOfOnePixel) {
  const Image a = flat(20, 12, 0.5f);
  Image b = a;
  at(b, 13, 7, 1) = 0.75f;
  const ImageMetrics m = compared(a, b);
  EXPECT_DOUBLE_EQ(m.rmse, 0.25 / std::sqrt(3.0 * 240));
  EXPECT_DOUBLE_EQ(m.psnr_db, -20.0 * std::log10(0.25 / std::sqrt(720.0)));
  EXPECT_EQ(m.max_abs, 0.25);
  EXPECT_EQ(m.max_abs_x, 13);
  EXPECT_EQ(m.max_abs_y, 7);
  EXPECT_DOUBLE_EQ(m.share_over_1_255, 1.0 / 240);
  EXPECT_EQ(m.alpha_rmse, 0.0);
  // The same the other way round.
  EXPECT_EQ(compared(b, a).rmse, m.rmse);
  EXPECT_EQ(compared(b, a).ssim, m.ssim);
}

TEST(Metrics, TheWorstPixelIsOnTheFilmAndTheFirstOfEquals) {
  Image a = flat(20, 10, 0.5f);
  a.x = 100;
  a.y = 200;
  a.film_width = a.film_height = 1000;
  Image b = a;
  at(b, 19, 2, 0) = 0.25f;
  at(b, 3, 8, 2) = 0.75f;
  at(b, 4, 8, 2) = 0.625f;
  const ImageMetrics m = compared(a, b);
  EXPECT_EQ(m.max_abs_x, 119);
  EXPECT_EQ(m.max_abs_y, 202);
}

TEST(Metrics, OverOneLevelIsCountedByPixelAndStrictly) {
  const Image a = flat(4, 4, 0.0f);
  const float level = 1.0f / 255.0f;
  Image b = a;
  at(b, 0, 0, 0) = std::nextafter(level, 0.0f);
  EXPECT_EQ(compared(a, b).share_over_1_255, 0.0);
  // Two channels of one pixel, one of another.
  at(b, 1, 1, 0) = at(b, 1, 1, 2) = at(b, 2, 3, 1) = std::nextafter(level, 1.0f);
  EXPECT_EQ(compared(a, b).share_over_1_255, 2.0 / 16);
}

TEST(Metrics, AlphaIsApart) {
  const ImageMetrics m = compared(flat(16, 16, 0.5f, 1.0f), flat(16, 16, 0.5f, 0.75f));
  EXPECT_FALSE(m.identical);
  EXPECT_EQ(m.rmse, 0.0);
  EXPECT_EQ(m.max_abs, 0.0);
  EXPECT_EQ(m.alpha_rmse, 0.25);
  EXPECT_EQ(m.alpha_max_abs, 0.25);
}

TEST(Metrics, PixelsThatAreNotFiniteAreCountedAndLeftOut) {
  const Image clean = flat(24, 24, 0.5f);
  Image a = clean, b = flat(24, 24, 0.25f);
  at(a, 2, 2, 1) = kNan;
  at(b, 2, 2, 3) = kInf;  // the same pixel, but alpha
  at(b, 20, 20, 0) = -kInf;
  const ImageMetrics m = compared(a, b);
  EXPECT_EQ(m.nonfinite_a, 1u);
  EXPECT_EQ(m.nonfinite_b, 2u);
  EXPECT_EQ(m.finite_pixels, 24u * 24u - 2u);
  EXPECT_EQ(m.rmse, 0.25);
  EXPECT_EQ(m.max_abs, 0.25);
  EXPECT_EQ(m.share_over_1_255, 1.0);

  // Equal infinities are no equality, and count as wrong pixels.
  a = b = clean;
  at(a, 5, 5, 0) = at(b, 5, 5, 0) = kInf;
  const ImageMetrics same = compared(a, b);
  EXPECT_FALSE(same.identical);
  EXPECT_EQ(same.rmse, 0.0);
  EXPECT_EQ(same.share_over_1_255, 1.0 / (24 * 24));

  const ImageMetrics none = compared(flat(12, 12, kNan), flat(12, 12, 0.5f));
  EXPECT_EQ(none.finite_pixels, 0u);
  for (const double figure :
       {none.rmse, none.psnr_db, none.ssim, none.max_abs, none.alpha_rmse, none.alpha_max_abs}) {
    EXPECT_TRUE(std::isnan(figure));
  }
}

TEST(Metrics, WindowsMustAgree) {
  const Image whole = noise(40, 30);
  Image crop{10, 5, 20, 15, 40, 30, {}, {}};
  for (int y = 0; y < 15; ++y) {
    for (int x = 0; x < 20; ++x) {
      const auto from = static_cast<std::ptrdiff_t>(4 * ((y + 5) * 40 + x + 10));
      crop.rgba.insert(crop.rgba.end(), whole.rgba.begin() + from, whole.rgba.begin() + from + 4);
    }
  }
  const Result<ImageMetrics> refused = compare_images(whole, crop);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "window");
  const ImageMetrics same = compared(whole, crop, {true});
  EXPECT_EQ(same.pixels, 300u);
  EXPECT_TRUE(same.identical);

  at(crop, 19, 14, 0) += 1.0f;
  const ImageMetrics corner = compared(crop, whole, {true});
  EXPECT_EQ(corner.max_abs_x, 29);
  EXPECT_EQ(corner.max_abs_y, 19);

  Image elsewhere = crop;
  elsewhere.x = 30;
  EXPECT_EQ(compare_images(crop, elsewhere, {true}).error().field, "window");  // they touch
  Image other_film = crop;
  other_film.film_width = 41;
  EXPECT_EQ(compare_images(crop, other_film, {true}).error().field, "film");
  Image broken = crop;
  broken.rgba.pop_back();
  EXPECT_EQ(compare_images(crop, broken).error().field, "rgba");
}

TEST(Ssim, OppositeCheckerboardsHaveTheirClosedForm) {
  // a = m + s χ, b = m − s χ with χ = ±1 a checkerboard. The window's mean of χ is ±q, q = (Σ (−1)ⁱ gᵢ)², so
  // both variances are s² (1 − q²) and the covariance is its negative. SSIM is even in q: every window
  // agrees.
  constexpr double kMean = 0.5, kSwing = 0.25, kC1 = 1e-4, kC2 = 9e-4;
  double sum = 0, alternating = 0;
  for (int i = -5; i <= 5; ++i) {
    const double g = std::exp(-i * i / 4.5);
    sum += g;
    alternating += i % 2 == 0 ? g : -g;
  }
  const double q = std::pow(alternating / sum, 2);
  const double variance = kSwing * kSwing * (1 - q * q), high = kMean + kSwing * q, low = kMean - kSwing * q;
  const double expected = (2 * high * low + kC1) * (-2 * variance + kC2) /
                          ((high * high + low * low + kC1) * (2 * variance + kC2));

  constexpr int kWidth = 19, kHeight = 13;
  std::vector<double> a, b;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double swing = (x + y) % 2 == 0 ? kSwing : -kSwing;
      a.push_back(kMean + swing);
      b.push_back(kMean - swing);
    }
  }
  // Moments below 1 rounded by at most 22 ulp(1) = 5e-15, against variances of 0.06: below 1e-12.
  EXPECT_NEAR(mean_ssim(a, b, kWidth, kHeight), expected, 1e-12);
}

TEST(Ssim, OnlyWholeWindowsWithoutHolesCount) {
  const double nan = std::nan("");
  const std::vector<double> small(10 * 11, 0.5);
  EXPECT_TRUE(std::isnan(mean_ssim(small, small, 10, 11)));
  EXPECT_TRUE(std::isnan(mean_ssim(small, small, 11, 10)));

  // Two windows side by side; a hole in the first column leaves the second, where the images are equal.
  std::vector<double> a(12 * 11, 0.5), b = a;
  b[0] = 0.0;
  EXPECT_LT(mean_ssim(a, b, 12, 11), 1.0);
  b[0] = nan;
  EXPECT_EQ(mean_ssim(a, b, 12, 11), 1.0);
  b[5] = nan;
  EXPECT_TRUE(std::isnan(mean_ssim(a, b, 12, 11)));
}

TEST(Ssim, SeesLuminanceInRec709) {
  // A colour change that keeps Rec.709 luminance, up to the rounding of floats, is invisible to SSIM.
  Image a = flat(16, 16, 0.5f), b = a;
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; x += 2) {
      at(b, x, y, 0) += 0.25f;
      at(b, x, y, 1) -= static_cast<float>(0.25 * 0.2126 / 0.7152);
    }
  }
  // Luminance is off by at most 0.7152 · 2⁻²⁵ (green rounded to float) < 3e-8, whose effect on SSIM is
  // quadratic in the variance term (1e-15 / C₂) and at most 2 · 3e-8 / 0.5 in the other.
  EXPECT_NEAR(compared(a, b).ssim, 1.0, 2e-7);
  EXPECT_GT(compared(a, b).rmse, 0.05);
  // The same change of red alone is not.
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; x += 2) at(b, x, y, 1) = 0.5f;
  }
  EXPECT_LT(compared(a, b).ssim, 0.9);
}

TEST(Difference, IsScaledAbsoluteAndMarksWhatIsNotFinite) {
  Image a = flat(3, 1, 0.5f), b = a;
  at(b, 0, 0, 0) = 0.75f;
  at(b, 0, 0, 2) = 0.25f;
  at(b, 1, 0, 3) = 0.0f;
  at(a, 2, 0, 1) = kNan;
  const Image difference = difference_image(a, b, 2.0);
  EXPECT_TRUE(difference.validate().ok());
  const std::vector<float> expected = {0.5f, 0, 0.5f, 1, 0, 0, 0, 1, 1, 0, 1, 1};
  EXPECT_EQ(difference.rgba, expected);
}

}  // namespace
}  // namespace swept
