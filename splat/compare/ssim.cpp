// Wang, Bovik, Sheikh and Simoncelli: Image quality assessment: from error visibility to structural
// similarity (2004), equation 13 with the Gaussian weights of section III-C.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "splat/compare/metrics.h"

namespace swept {
namespace {

constexpr std::size_t kTaps = 11;
constexpr double kSigma = 1.5;
constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;  // (K L)² with L = 1

std::array<double, kTaps> gaussian_taps() {
  std::array<double, kTaps> taps{};
  double sum = 0.0;
  for (std::size_t i = 0; i < kTaps; ++i) {
    const double offset = static_cast<double>(i) - (kTaps - 1) / 2.0;
    taps[i] = std::exp(-offset * offset / (2.0 * kSigma * kSigma));
    sum += taps[i];
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

/// Sums of one window or one column of it: moments about the origin.
struct Moments {
  double a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;

  void add(double weight, const Moments& other) {
    a += weight * other.a;
    b += weight * other.b;
    aa += weight * other.aa;
    bb += weight * other.bb;
    ab += weight * other.ab;
  }
};

double ssim_of(const Moments& m) {
  // What rounding leaves of differences of large squares may be of either sign, but no variance is negative,
  // and no covariance beyond Cauchy and Schwarz.
  const double variance_a = std::max(0.0, m.aa - m.a * m.a), variance_b = std::max(0.0, m.bb - m.b * m.b);
  const double most = std::sqrt(variance_a) * std::sqrt(variance_b);
  const double covariance = std::clamp(m.ab - m.a * m.b, -most, most);
  return (2.0 * m.a * m.b + kC1) * (2.0 * covariance + kC2) /
         ((m.a * m.a + m.b * m.b + kC1) * (variance_a + variance_b + kC2));
}

}  // namespace

double mean_ssim(const std::vector<double>& a, const std::vector<double>& b, int width, int height) {
  const auto columns = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
  if (columns < kTaps || rows < kTaps) return std::numeric_limits<double>::quiet_NaN();
  const std::array<double, kTaps> taps = gaussian_taps();
  std::vector<Moments> column(columns);
  double sum = 0.0;
  std::size_t windows = 0;
  for (std::size_t top = 0; top + kTaps <= rows; ++top) {
    for (std::size_t x = 0; x < columns; ++x) {
      column[x] = {};
      for (std::size_t i = 0; i < kTaps; ++i) {
        const double va = a[(top + i) * columns + x], vb = b[(top + i) * columns + x];
        column[x].add(taps[i], {va, vb, va * va, vb * vb, va * vb});
      }
    }
    for (std::size_t left = 0; left + kTaps <= columns; ++left) {
      Moments window;
      for (std::size_t i = 0; i < kTaps; ++i) window.add(taps[i], column[left + i]);
      // A non-finite pixel has reached the moments by now.
      const double value = ssim_of(window);
      if (!std::isfinite(value)) continue;
      sum += value;
      ++windows;
    }
  }
  return windows == 0 ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(windows);
}

}  // namespace swept
