#include "splat/compare/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/LU>

#include "splat/compare/metrics.h"

namespace swept {
namespace {

using Colour = std::array<double, 3>;

const double kPi = std::acos(-1.0);

Image painted(int width, int height, const std::function<Colour(int, int)>& colour) {
  Image image{0, 0, width, height, width, height, {}, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const double c : colour(x, y)) image.rgba.push_back(static_cast<float>(c));
      image.rgba.push_back(1.0f);
    }
  }
  return image;
}

Image flat(const Colour& colour) {
  return painted(24, 20, [&](int, int) { return colour; });
}

Image noise(int width, int height, unsigned seed) {
  std::mt19937 generator(seed);
  const auto next = [&] { return static_cast<double>(generator() >> 8) * 0x1p-24; };
  return painted(width, height, [&](int, int) { return Colour{next(), next(), next()}; });
}

float& at(Image& image, int x, int y, int channel) {
  return image.rgba[static_cast<std::size_t>(4 * (y * image.width + x) + channel)];
}

double value_at(const std::vector<double>& map, int width, int x, int y) {
  return map[static_cast<std::size_t>(y * width + x)];
}

// The published formulas once more, as plainly as they stand there: whole two-dimensional filters, the exact
// sRGB matrix of CSS Color 4 (the rational numbers that the primaries give), nothing shared.

Colour xyz_of(const Colour& c) {
  const auto row = [&](double r, double g, double b) { return r * c[0] + g * c[1] + b * c[2]; };
  return {row(506752.0 / 1228815, 87881.0 / 245763, 12673.0 / 70218),
          row(87098.0 / 409605, 175762.0 / 245763, 12673.0 / 175545),
          row(7918.0 / 409605, 87881.0 / 737289, 1001167.0 / 1053270)};
}

const Colour kWhite = xyz_of({1, 1, 1});

Colour opponent_of(const Colour& rgb) {
  const Colour c = xyz_of(rgb);
  const double x = c[0] / kWhite[0], y = c[1] / kWhite[1], z = c[2] / kWhite[2];
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

/// What the blur, which differs from channel to channel, has left within sRGB.
Colour clamped_rgb(const Colour& opponent) {
  Eigen::Matrix3d from_rgb;
  for (int c = 0; c < 3; ++c) {
    const Colour primary = opponent_of({c == 0 ? 1.0 : 0.0, c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0});
    from_rgb.col(c) << primary[0] + 16, primary[1], primary[2];
  }
  const Eigen::Vector3d target(opponent[0] + 16, opponent[1], opponent[2]);
  const Eigen::Vector3d rgb = from_rgb.fullPivLu().solve(target).cwiseMax(0.0).cwiseMin(1.0);
  return {rgb.x(), rgb.y(), rgb.z()};
}

Colour hunt_of(const Colour& rgb) {
  const auto f = [](double t) {
    return t > 216.0 / 24389 ? std::pow(t, 1.0 / 3) : t * 841.0 / 108 + 4.0 / 29;
  };
  const Colour c = xyz_of(rgb);
  const double x = f(c[0] / kWhite[0]), y = f(c[1] / kWhite[1]), z = f(c[2] / kWhite[2]);
  const double lightness = 116 * y - 16;
  return {lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)};
}

double colour_error(const Colour& a, const Colour& b) {
  const auto raised = [](const Colour& p, const Colour& q) {
    return std::pow(std::abs(p[0] - q[0]) + std::sqrt(std::pow(p[1] - q[1], 2) + std::pow(p[2] - q[2], 2)),
                    0.7);
  };
  const double largest = raised(hunt_of({0, 1, 0}), hunt_of({0, 0, 1})), error = raised(a, b);
  return error < 0.4 * largest ? 0.95 * error / (0.4 * largest)
                               : 0.95 + 0.05 * (error - 0.4 * largest) / (0.6 * largest);
}

using Weight = std::function<double(double, double)>;

/// Σ of a channel about (x, y) over a square; positive and negative weights are scaled apart if `balanced`,
/// otherwise to a sum of 1.
double weighted(const std::vector<Colour>& image, int width, int height, int x, int y, int channel,
                int radius, bool balanced, const Weight& weight) {
  double positive = 0, negative = 0, weight_positive = 0, weight_negative = 0;
  for (int j = -radius; j <= radius; ++j) {
    for (int i = -radius; i <= radius; ++i) {
      const double w = weight(i, j);
      const int px = std::min(std::max(x + i, 0), width - 1), py = std::min(std::max(y + j, 0), height - 1);
      const double value =
          image[static_cast<std::size_t>(py * width + px)][static_cast<std::size_t>(channel)];
      (w > 0 ? positive : negative) += w * value;
      (w > 0 ? weight_positive : weight_negative) += w;
    }
  }
  return balanced ? positive / weight_positive - negative / weight_negative
                  : (positive + negative) / (weight_positive + weight_negative);
}

struct PlainPixel {
  Colour lab;
  double edge, point;
};

PlainPixel plain_pixel(const std::vector<Colour>& opponent, int width, int height, int x, int y, double ppd) {
  const int blur = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * kPi * kPi)) * ppd));
  const auto term = [&](double a, double b, double i, double j) {
    return a * std::sqrt(kPi / b) * std::exp(-kPi * kPi * (i * i + j * j) / (ppd * ppd) / b);
  };
  const double cy = weighted(opponent, width, height, x, y, 0, blur, false,
                             [&](double i, double j) { return term(1, 0.0047, i, j); });
  const double cx = weighted(opponent, width, height, x, y, 1, blur, false,
                             [&](double i, double j) { return term(1, 0.0053, i, j); });
  const double cz = weighted(opponent, width, height, x, y, 2, blur, false, [&](double i, double j) {
    return term(34.1, 0.04, i, j) + term(13.5, 0.025, i, j);
  });
  PlainPixel out;
  out.lab = hunt_of(clamped_rgb({cy, cx, cz}));

  const double sigma = 0.5 * 0.082 * ppd;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const auto gauss = [&](double i, double j) { return std::exp(-(i * i + j * j) / (2 * sigma * sigma)); };
  const auto feature = [&](const Weight& along_x, const Weight& along_y) {
    return std::hypot(weighted(opponent, width, height, x, y, 0, radius, true, along_x) / 116,
                      weighted(opponent, width, height, x, y, 0, radius, true, along_y) / 116);
  };
  out.edge = feature([&](double i, double j) { return -i * gauss(i, j); },
                     [&](double i, double j) { return -j * gauss(i, j); });
  out.point = feature([&](double i, double j) { return (i * i / sigma / sigma - 1) * gauss(i, j); },
                      [&](double i, double j) { return (j * j / sigma / sigma - 1) * gauss(i, j); });
  return out;
}

double plain_flip(const PlainPixel& a, const PlainPixel& b) {
  const double difference = std::max(std::abs(a.edge - b.edge), std::abs(a.point - b.point));
  return std::pow(colour_error(a.lab, b.lab), 1 - std::sqrt(difference / std::sqrt(2.0)));
}

std::vector<Colour> opponents(const Image& image) {
  std::vector<Colour> out;
  for (std::size_t p = 0; p < image.pixel_count(); ++p) {
    out.push_back(opponent_of({image.rgba[4 * p], image.rgba[4 * p + 1], image.rgba[4 * p + 2]}));
  }
  return out;
}

// A feature is the root of a difference of sums of weights 1 and −1 over values in [0, 1]. Rounding leaves a
// difference of some 20 ulp(1)/2 = 2.2e-15 where there should be none, whose root is 4.7e-8; and c^(1−f)
// changes by at most |c ln c| ≤ 1/e of that, 1.8e-8. All else is smooth and off by some 1e-14.
constexpr double kRounding = 2e-8;

TEST(Flip, EqualImagesDifferNowhere) {
  const Image image = noise(40, 30, 1);
  const std::vector<double> map = flip_map(image, image);
  ASSERT_EQ(map.size(), 1200u);
  EXPECT_TRUE(std::all_of(map.begin(), map.end(), [](double value) { return value == 0.0; }));
  EXPECT_EQ(mean_flip(image, image), 0.0);
}

TEST(Flip, IsSymmetric) {
  const Image a = noise(30, 22, 2), b = noise(30, 22, 3);
  EXPECT_EQ(flip_map(a, b), flip_map(b, a));
}

TEST(Flip, UniformImagesHaveTheirColoursDistance) {
  const Colour black{0, 0, 0}, white{1, 1, 1};
  // 100^0.7 = 25.119 of at most 41.276: 0.95 + 0.05 (25.119 − 16.510) / 24.766.
  EXPECT_NEAR(mean_flip(flat(black), flat(white)), 0.96738, 5e-6);
  const std::vector<std::array<Colour, 2>> pairs = {{black, white},
                                                    {Colour{0, 1, 0}, Colour{0, 0, 1}},
                                                    {Colour{0.5, 0.25, 0.125}, Colour{0.25, 0.5, 0.125}},
                                                    {Colour{0.5, 0.5, 0.5}, Colour{0.515625, 0.5, 0.5}},
                                                    {Colour{0.0078125, 0, 0}, Colour{0, 0.00390625, 0}}};
  for (const auto& [a, b] : pairs) {
    EXPECT_NEAR(mean_flip(flat(a), flat(b)), colour_error(hunt_of(a), hunt_of(b)), kRounding);
  }
  // Nothing is farther apart than green and blue.
  EXPECT_NEAR(mean_flip(flat({0, 1, 0}), flat({0, 0, 1})), 1.0, kRounding);
}

TEST(Flip, EveryPixelFollowsThePublishedFormulas) {
  constexpr int kWidth = 17, kHeight = 13;
  const Image a = noise(kWidth, kHeight, 4), b = noise(kWidth, kHeight, 5);
  for (const double ppd : {67.0, 20.0}) {
    const std::vector<double> map = flip_map(a, b, ppd);
    const std::vector<Colour> of_a = opponents(a), of_b = opponents(b);
    double mean = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double expected = plain_flip(plain_pixel(of_a, kWidth, kHeight, x, y, ppd),
                                           plain_pixel(of_b, kWidth, kHeight, x, y, ppd));
        EXPECT_NEAR(value_at(map, kWidth, x, y), expected, kRounding) << x << ", " << y << " at " << ppd;
        mean += expected / (kWidth * kHeight);
      }
    }
    EXPECT_NEAR(mean_flip(a, b, ppd), mean, kRounding);
    EXPECT_GT(mean, 0.05);
  }
}

TEST(Flip, IsWithinZeroAndOneAndClampsColours) {
  std::mt19937 generator(6);
  const auto corner = [&](int, int) {
    const auto bits = generator() >> 7;
    return Colour{bits & 1 ? 1.0 : 0.0, bits & 2 ? 1.0 : 0.0, bits & 4 ? 1.0 : 0.0};
  };
  const Image a = painted(40, 40, corner), b = painted(40, 40, corner);
  for (const double ppd : {1.0, 4.0, 67.0}) {
    const std::vector<double> map = flip_map(a, b, ppd);
    EXPECT_TRUE(std::all_of(map.begin(), map.end(), [](double v) { return v >= 0.0 && v <= 1.0; })) << ppd;
  }
  Image beyond = a;
  for (float& value : beyond.rgba) value = value == 1.0f ? 3.0f : -2.0f;
  EXPECT_EQ(mean_flip(a, beyond), 0.0);
}

TEST(Flip, AShiftedEdgeIsSeenBeforeNoiseOfTheSameError) {
  const auto edge = [](int at_x) {
    return painted(1024, 24, [=](int x, int) {
      return x < at_x ? Colour{0.3, 0.3, 0.3} : Colour{0.8, 0.8, 0.8};
    });
  };
  const Image image = edge(512), shifted = edge(513);
  // One column in 1024 is off by 0.5: the RMSE of 0.5 / 32 in every pixel.
  std::mt19937 generator(7);
  Image noisy = image;
  for (std::size_t p = 0; p < noisy.pixel_count(); ++p) {
    const float step = generator() >> 31 ? 0.015625f : -0.015625f;
    for (std::size_t c = 0; c < 3; ++c) noisy.rgba[4 * p + c] += step;
  }
  ASSERT_NEAR(compare_images(image, shifted)->rmse, compare_images(image, noisy)->rmse, 1e-7);
  // Where the edge is, not in the mean: noise is everywhere.
  const std::vector<double> of_shift = flip_map(image, shifted), of_noise = flip_map(image, noisy);
  EXPECT_GT(*std::max_element(of_shift.begin(), of_shift.end()),
            2.0 * *std::max_element(of_noise.begin(), of_noise.end()));
}

TEST(Flip, AnObserverFartherAwaySeesLess) {
  const auto checks = [](int odd) {
    return painted(40, 40, [=](int x, int y) {
      const double value = (x + y) % 2 == odd ? 0.75 : 0.25;
      return Colour{value, value, value};
    });
  };
  const Image a = checks(0), b = checks(1);
  const double near = mean_flip(a, b, 10), middle = mean_flip(a, b, 30), far = mean_flip(a, b, 120);
  EXPECT_GT(near, middle);
  EXPECT_GT(middle, far);
}

TEST(Flip, TheOutermostPixelsRepeatBeyondTheBorder) {
  constexpr int kWidth = 20, kHeight = 16, kMargin = 12;
  const Image a = noise(kWidth, kHeight, 8), b = noise(kWidth, kHeight, 9);
  const auto extended = [&](const Image& image) {
    return painted(kWidth + 2 * kMargin, kHeight + 2 * kMargin, [&](int x, int y) {
      const int px = std::clamp(x - kMargin, 0, kWidth - 1), py = std::clamp(y - kMargin, 0, kHeight - 1);
      const float* p = &image.rgba[static_cast<std::size_t>(4 * (py * kWidth + px))];
      return Colour{p[0], p[1], p[2]};
    });
  };
  const std::vector<double> map = flip_map(a, b), wide = flip_map(extended(a), extended(b));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_EQ(value_at(map, kWidth, x, y), value_at(wide, kWidth + 2 * kMargin, x + kMargin, y + kMargin));
    }
  }
}

TEST(Flip, PixelsThatAreNotFiniteTakeTheirSurroundingsOut) {
  constexpr int kWidth = 60, kHeight = 50, kReach = 10;  // ⌈0.13505 · 67⌉
  const Image a = noise(kWidth, kHeight, 10);
  const Image b = noise(kWidth, kHeight, 11);
  const std::vector<double> clean = flip_map(a, b);
  Image holed_a = a, holed_b = b;
  at(holed_a, 30, 25, 1) = std::numeric_limits<float>::infinity();
  at(holed_b, 5, 48, 3) = std::nanf("");
  const std::vector<double> map = flip_map(holed_a, holed_b);
  double sum = 0;
  int count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool reached = (std::abs(x - 30) <= kReach && std::abs(y - 25) <= kReach) ||
                           (std::abs(x - 5) <= kReach && std::abs(y - 48) <= kReach);
      EXPECT_EQ(std::isnan(value_at(map, kWidth, x, y)), reached) << x << ", " << y;
      if (reached) continue;
      EXPECT_EQ(value_at(map, kWidth, x, y), value_at(clean, kWidth, x, y));
      sum += value_at(map, kWidth, x, y);
      ++count;
    }
  }
  EXPECT_EQ(mean_flip(holed_a, holed_b), sum / count);
  EXPECT_TRUE(std::isnan(mean_flip(flat({std::nan(""), 0, 0}), flat({0, 0, 0}))));
}

TEST(Flip, IsAmongTheMetricsOfTheComparedWindow) {
  const Image a = noise(40, 30, 12), b = noise(40, 30, 13);
  EXPECT_EQ(compare_images(a, b)->flip, mean_flip(a, b));
  EXPECT_EQ(compare_images(a, a)->flip, 0.0);

  Image crop{10, 5, 20, 15, 40, 30, {}, {}}, same_crop = crop;
  for (int y = 5; y < 20; ++y) {
    const auto row = [&](const Image& image) { return image.rgba.begin() + 4 * (40 * y + 10); };
    crop.rgba.insert(crop.rgba.end(), row(a), row(a) + 80);
    same_crop.rgba.insert(same_crop.rgba.end(), row(b), row(b) + 80);
  }
  EXPECT_EQ(compare_images(crop, b, {true})->flip, mean_flip(crop, same_crop));
}

}  // namespace
}  // namespace swept
