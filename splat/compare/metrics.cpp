#include "splat/compare/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "splat/compare/flip.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

/// The part of the film that is compared.
struct Window {
  int left = 0, top = 0, right = 0, bottom = 0;  // right and bottom are past the end

  [[nodiscard]] bool empty() const { return right <= left || bottom <= top; }
  [[nodiscard]] int width() const { return right - left; }
  [[nodiscard]] int height() const { return bottom - top; }
  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
  }
  [[nodiscard]] std::string text() const {
    return std::to_string(width()) + "x" + std::to_string(height()) + "+" + std::to_string(left) + "+" +
           std::to_string(top);
  }
  bool operator==(const Window&) const = default;
};

Window window_of(const Image& image) {
  return {image.x, image.y, image.x + image.width, image.y + image.height};
}

Window overlap(const Window& a, const Window& b) {
  return {std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right),
          std::min(a.bottom, b.bottom)};
}

std::string film_text(const Image& image) {
  return std::to_string(image.film_width) + "x" + std::to_string(image.film_height);
}

/// Pixels are not looked at.
Result<Window> common_window(const Image& a, const Image& b, const CompareOptions& options) {
  if (film_text(a) != film_text(b)) {
    return Error{"", "film",
                 "the images are of films of " + film_text(a) + " and " + film_text(b) + " pixels"};
  }
  const Window window_a = window_of(a), window_b = window_of(b);
  if (window_a != window_b && !options.crop_to_overlap) {
    return Error{"", "window",
                 "the images cover " + window_a.text() + " and " + window_b.text() +
                     " of the film; only their overlap can be compared (--crop-to-overlap)"};
  }
  const Window window = overlap(window_a, window_b);
  if (window.empty()) {
    return Error{"", "window", "the images do not overlap: " + window_a.text() + " and " + window_b.text()};
  }
  return window;
}

const float* pixel_at(const Image& image, int x, int y) {
  const auto column = static_cast<std::size_t>(x - image.x), row = static_cast<std::size_t>(y - image.y);
  return &image.rgba[4 * (row * static_cast<std::size_t>(image.width) + column)];
}

bool finite(const float* rgba) {
  return std::all_of(rgba, rgba + 4, [](float value) { return std::isfinite(value); });
}

/// Rec.709, NaN where the pixel is not finite, so that no window of SSIM takes it in.
std::vector<double> luminance(const Image& image, const Window& window) {
  std::vector<double> plane;
  plane.reserve(window.pixels());
  for (int y = window.top; y < window.bottom; ++y) {
    for (int x = window.left; x < window.right; ++x) {
      const float* p = pixel_at(image, x, y);
      plane.push_back(finite(p) ? 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]
                                : std::numeric_limits<double>::quiet_NaN());
    }
  }
  return plane;
}

Image cropped(const Image& image, const Window& window) {
  Image part{window.left, window.top, window.width(), window.height(), image.film_width, image.film_height,
             {},          {}};
  part.rgba.reserve(4 * window.pixels());
  for (int y = window.top; y < window.bottom; ++y) {
    const float* row = pixel_at(image, window.left, y);
    part.rgba.insert(part.rgba.end(), row, row + 4 * window.width());
  }
  return part;
}

/// Sums over the pixels seen so far.
struct Tally {
  ImageMetrics metrics;
  double colour_squares = 0.0, alpha_squares = 0.0;
  std::size_t over = 0;
  bool equal = true;

  void add(const float* a, const float* b, int x, int y) {
    const bool finite_a = finite(a), finite_b = finite(b);
    metrics.nonfinite_a += finite_a ? 0 : 1;
    metrics.nonfinite_b += finite_b ? 0 : 1;
    if (!finite_a || !finite_b) {
      ++over;
      equal = false;
      return;
    }
    double worst = 0.0;
    for (int c = 0; c < 3; ++c) {
      const double difference = std::abs(double{a[c]} - double{b[c]});
      colour_squares += difference * difference;
      worst = std::max(worst, difference);
    }
    const double alpha = std::abs(double{a[3]} - double{b[3]});
    alpha_squares += alpha * alpha;
    metrics.alpha_max_abs = std::max(metrics.alpha_max_abs, alpha);
    if (metrics.finite_pixels++ == 0 || worst > metrics.max_abs) {
      metrics.max_abs = worst;
      metrics.max_abs_x = x;
      metrics.max_abs_y = y;
    }
    over += worst > 1.0 / 255.0 ? 1 : 0;
    equal = equal && worst == 0.0 && alpha == 0.0;
  }

  [[nodiscard]] ImageMetrics finish(std::size_t pixels) const {
    ImageMetrics result = metrics;
    result.pixels = pixels;
    result.identical = equal;
    result.share_over_1_255 = static_cast<double>(over) / static_cast<double>(pixels);
    const auto count = static_cast<double>(metrics.finite_pixels);
    // 0/0 where nothing is finite: the figures are NaN, as promised.
    result.rmse = std::sqrt(colour_squares / (3.0 * count));
    result.alpha_rmse = std::sqrt(alpha_squares / count);
    result.psnr_db = 0.0 - 20.0 * std::log10(result.rmse);
    if (metrics.finite_pixels == 0) {
      result.max_abs = result.alpha_max_abs = std::numeric_limits<double>::quiet_NaN();
    }
    return result;
  }
};

}  // namespace

Status check_windows(const Image& a, const Image& b, const CompareOptions& options) {
  return without_throwing("to compare the images", [&]() -> Status {
    const Result<Window> common = common_window(a, b, options);
    if (!common) return common.error();
    return Done{};
  });
}

Result<ImageMetrics> compare_images(const Image& a, const Image& b, const CompareOptions& options) {
  return without_throwing("to compare the images", [&]() -> Result<ImageMetrics> {
    for (const Image* image : {&a, &b}) {
      if (const Status status = image->validate(); !status) return status.error();
    }
    const Result<Window> common = common_window(a, b, options);
    if (!common) return common.error();
    const Window& window = *common;
    Tally tally;
    for (int y = window.top; y < window.bottom; ++y) {
      for (int x = window.left; x < window.right; ++x) tally.add(pixel_at(a, x, y), pixel_at(b, x, y), x, y);
    }
    ImageMetrics metrics = tally.finish(window.pixels());
    metrics.ssim = mean_ssim(luminance(a, window), luminance(b, window), window.width(), window.height());
    metrics.flip = mean_flip(cropped(a, window), cropped(b, window));
    return metrics;
  });
}

Image difference_image(const Image& a, const Image& b, double scale, const CompareOptions& options) {
  const Window window = *common_window(a, b, options);
  Image image{window.left, window.top, window.width(), window.height(), a.film_width, a.film_height, {}, {}};
  image.rgba.reserve(4 * window.pixels());
  for (int y = window.top; y < window.bottom; ++y) {
    for (int x = window.left; x < window.right; ++x) {
      const float *pa = pixel_at(a, x, y), *pb = pixel_at(b, x, y);
      const bool usable = finite(pa) && finite(pb);
      for (int c = 0; c < 3; ++c) {
        image.rgba.push_back(usable ? static_cast<float>(scale * std::abs(double{pa[c]} - double{pb[c]}))
                                    : kNonfiniteMark[c]);
      }
      image.rgba.push_back(1.0f);
    }
  }
  return image;
}

}  // namespace swept
