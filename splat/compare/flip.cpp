// Source: flip.h. Section and symbol names are the paper's. Every filter is a sum of separable ones.
#include "splat/compare/flip.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/LU>

namespace swept {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Taps = std::vector<double>;  // odd count, the middle one at the pixel itself

constexpr double kPi = std::numbers::pi;

// Colour differences are raised to q_c; up to the share p_c of the largest one they take up p_t of [0, 1].
constexpr double kQc = 0.7, kPc = 0.4, kPt = 0.95;
constexpr double kQf = 0.5;
/// Distance in degrees between the two peaks of the edge detector.
constexpr double kFeatureWidth = 0.082;

/// a √(π/b) exp(−π² d²/b), d in degrees: one term of a contrast sensitivity function, as a filter.
struct Sensitivity {
  double a, b;
};
constexpr Sensitivity kAchromatic{1.0, 0.0047}, kRedGreen{1.0, 0.0053};
constexpr Sensitivity kBlueYellow[2] = {{34.1, 0.04}, {13.5, 0.025}};
/// The widest of them, which sets the radius of all.
constexpr double kWidest = 0.04;

/// Linear RGB to X, Y and Z, each in units of the white's own.
const Matrix3d& relative_xyz_from_rgb() {
  static const Matrix3d matrix = [] {
    const auto xyz = [](double x, double y) { return Vector3d(x / y, 1.0, (1.0 - x - y) / y); };
    Matrix3d primaries;
    primaries << xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06);
    const Vector3d white = xyz(0.3127, 0.3290);
    const Vector3d shares = primaries.inverse() * white;
    return Matrix3d(white.cwiseInverse().asDiagonal() * primaries * shares.asDiagonal());
  }();
  return matrix;
}

const Matrix3d& rgb_from_relative_xyz() {
  static const Matrix3d matrix = relative_xyz_from_rgb().inverse();
  return matrix;
}

/// The opponent space in which the eye's blur is applied: linear, unlike CIELab.
Vector3d ycxcz_from_rgb(const Vector3d& rgb) {
  const Vector3d xyz = relative_xyz_from_rgb() * rgb;
  return {116.0 * xyz.y() - 16.0, 500.0 * (xyz.x() - xyz.y()), 200.0 * (xyz.y() - xyz.z())};
}

Vector3d rgb_from_ycxcz(const Vector3d& c) {
  const double y = (c.x() + 16.0) / 116.0;
  return rgb_from_relative_xyz() * Vector3d(y + c.y() / 500.0, y, y - c.z() / 200.0);
}

/// CIELab with the Hunt effect: chroma counts for less where it is dark.
Vector3d hunt_lab_from_rgb(const Vector3d& rgb) {
  const auto f = [](double t) {
    constexpr double delta = 6.0 / 29.0;
    return t > delta * delta * delta ? std::cbrt(t) : t / (3.0 * delta * delta) + 4.0 / 29.0;
  };
  const Vector3d xyz = relative_xyz_from_rgb() * rgb;
  const double x = f(xyz.x()), y = f(xyz.y()), z = f(xyz.z()), lightness = 116.0 * y - 16.0;
  return {lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)};
}

double hyab(const Vector3d& a, const Vector3d& b) {
  return std::abs(a.x() - b.x()) + std::hypot(a.y() - b.y(), a.z() - b.z());
}

/// From a distance of colours to [0, 1].
double redistribute(double distance) {
  // Green and blue are the two colours farthest apart.
  static const double largest =
      std::pow(hyab(hunt_lab_from_rgb(Vector3d::UnitY()), hunt_lab_from_rgb(Vector3d::UnitZ())), kQc);
  const double knee = kPc * largest, error = std::pow(distance, kQc);
  return error < knee ? kPt / knee * error
                      : std::min(1.0, kPt + (error - knee) / (largest - knee) * (1.0 - kPt));
}

/// One value per pixel, rows of `width`.
struct Plane {
  std::size_t width, height;
  std::vector<double> values;

  Plane(std::size_t w, std::size_t h) : width(w), height(h), values(w * h) {}
};

/// Filters along x with one set of taps and along y with the other. Work grows with the sum of their lengths.
Plane filtered(const Plane& in, const Taps& along_x, const Taps& along_y) {
  Plane rows(in.width, in.height), out(in.width, in.height);
  const std::size_t radius_x = along_x.size() / 2, radius_y = along_y.size() / 2;
  std::vector<double> padded(in.width + 2 * radius_x);
  for (std::size_t y = 0; y < in.height; ++y) {
    const double* row = &in.values[y * in.width];
    std::fill_n(padded.begin(), radius_x, row[0]);
    std::copy_n(row, in.width, padded.begin() + static_cast<std::ptrdiff_t>(radius_x));
    std::fill_n(padded.end() - static_cast<std::ptrdiff_t>(radius_x), radius_x, row[in.width - 1]);
    double* to = &rows.values[y * in.width];
    for (std::size_t i = 0; i < along_x.size(); ++i) {
      for (std::size_t x = 0; x < in.width; ++x) to[x] += along_x[i] * padded[x + i];
    }
  }
  for (std::size_t y = 0; y < in.height; ++y) {
    double* to = &out.values[y * in.width];
    for (std::size_t i = 0; i < along_y.size(); ++i) {
      const std::size_t from = y + i < radius_y ? 0 : std::min(y + i - radius_y, in.height - 1);
      const double* row = &rows.values[from * in.width];
      for (std::size_t x = 0; x < in.width; ++x) to[x] += along_y[i] * row[x];
    }
  }
  return out;
}

/// shape(x) at whole x of [−radius, radius].
template <class Shape>
Taps taps_of(double reach, const Shape& shape) {
  const int radius = static_cast<int>(std::ceil(reach));
  Taps taps;
  for (int x = -radius; x <= radius; ++x) taps.push_back(shape(static_cast<double>(x)));
  return taps;
}

double sum_of(const Taps& taps) {
  double sum = 0.0;
  for (const double tap : taps) sum += tap;
  return sum;
}

Taps sensitivity_taps(const Sensitivity& term, double pixels_per_degree) {
  return taps_of(3.0 * std::sqrt(kWidest / (2.0 * kPi * kPi)) * pixels_per_degree, [&](double x) {
    const double degrees = x / pixels_per_degree;
    return std::exp(-kPi * kPi * degrees * degrees / term.b);
  });
}

/// The sum of two round terms: separable one by one. Scaled so that the whole filter sums to 1.
template <std::size_t N>
Plane blurred(const Plane& in, const std::array<Sensitivity, N>& terms, double pixels_per_degree) {
  std::array<Taps, N> taps;
  std::array<double, N> weights;
  double total = 0.0;
  for (std::size_t i = 0; i < N; ++i) {
    taps[i] = sensitivity_taps(terms[i], pixels_per_degree);
    const double sum = sum_of(taps[i]);
    for (double& tap : taps[i]) tap /= sum;
    weights[i] = terms[i].a * std::sqrt(kPi / terms[i].b) * sum * sum;
    total += weights[i];
  }
  Plane out(in.width, in.height);
  for (std::size_t i = 0; i < N; ++i) {
    const Plane part = filtered(in, taps[i], taps[i]);
    for (std::size_t p = 0; p < out.values.size(); ++p) out.values[p] += weights[i] / total * part.values[p];
  }
  return out;
}

/// Scales what is positive to sum to 1, and what is negative to −1.
void balance(Taps& taps) {
  double positive = 0.0, negative = 0.0;
  for (const double tap : taps) (tap > 0.0 ? positive : negative) += tap;
  for (double& tap : taps) tap /= tap > 0.0 ? positive : -negative;
}

/// How much of an edge and of a point each pixel is: lengths of the first and second derivatives of a
/// blurred luminance.
struct Features {
  Plane edges, points;
};

Features features_of(const Plane& luminance, double pixels_per_degree) {
  const double sigma = 0.5 * kFeatureWidth * pixels_per_degree;
  const auto gaussian = [&](double x) { return std::exp(-x * x / (2.0 * sigma * sigma)); };
  Taps smooth = taps_of(3.0 * sigma, gaussian);
  const double sum = sum_of(smooth);
  for (double& tap : smooth) tap /= sum;
  Taps first = taps_of(3.0 * sigma, [&](double x) { return -x * gaussian(x); });
  Taps second = taps_of(3.0 * sigma, [&](double x) { return (x * x / (sigma * sigma) - 1.0) * gaussian(x); });
  balance(first);
  balance(second);
  const auto length = [&](const Taps& derivative) {
    Plane x = filtered(luminance, derivative, smooth);
    const Plane y = filtered(luminance, smooth, derivative);
    for (std::size_t p = 0; p < x.values.size(); ++p) x.values[p] = std::hypot(x.values[p], y.values[p]);
    return x;
  };
  return {length(first), length(second)};
}

/// All that is asked of one image.
struct Seen {
  std::vector<Vector3d> lab;  ///< blurred, Hunt-adjusted
  Features features;
};

Seen seen(const Image& image, double pixels_per_degree) {
  const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
  Plane y(width, height), cx(width, height), cz(width, height), luminance(width, height);
  for (std::size_t p = 0; p < image.pixel_count(); ++p) {
    const float* rgba = &image.rgba[4 * p];
    const bool finite = std::all_of(rgba, rgba + 4, [](float value) { return std::isfinite(value); });
    const Vector3d rgb = Eigen::Map<const Eigen::Vector3f>(rgba).cast<double>();
    const Vector3d c = finite ? ycxcz_from_rgb(rgb.cwiseMax(0.0).cwiseMin(1.0))
                              : Vector3d(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    y.values[p] = c.x();
    cx.values[p] = c.y();
    cz.values[p] = c.z();
    luminance.values[p] = (c.x() + 16.0) / 116.0;
  }
  y = blurred<1>(y, {kAchromatic}, pixels_per_degree);
  cx = blurred<1>(cx, {kRedGreen}, pixels_per_degree);
  cz = blurred<2>(cz, {kBlueYellow[0], kBlueYellow[1]}, pixels_per_degree);
  Seen result{std::vector<Vector3d>(image.pixel_count()), features_of(luminance, pixels_per_degree)};
  for (std::size_t p = 0; p < image.pixel_count(); ++p) {
    Vector3d rgb = rgb_from_ycxcz({y.values[p], cx.values[p], cz.values[p]});
    for (int c = 0; c < 3; ++c) rgb[c] = std::clamp(rgb[c], 0.0, 1.0);  // a NaN stays one
    result.lab[p] = hunt_lab_from_rgb(rgb);
  }
  return result;
}

}  // namespace

std::vector<double> flip_map(const Image& a, const Image& b, double pixels_per_degree) {
  assert(a.validate().ok() && b.validate().ok() && a.width == b.width && a.height == b.height);
  assert(pixels_per_degree >= 1.0 && pixels_per_degree <= 1e4);
  const Seen of_a = seen(a, pixels_per_degree), of_b = seen(b, pixels_per_degree);
  std::vector<double> map(a.pixel_count());
  for (std::size_t p = 0; p < map.size(); ++p) {
    const double distance = hyab(of_a.lab[p], of_b.lab[p]);
    // The blur reaches farther than the detectors, so this catches all. pow() would not: NaN⁰ is 1.
    if (std::isnan(distance)) {
      map[p] = distance;
      continue;
    }
    const double edges = std::abs(of_a.features.edges.values[p] - of_b.features.edges.values[p]);
    const double points = std::abs(of_a.features.points.values[p] - of_b.features.points.values[p]);
    const double feature = std::pow(std::max(edges, points) / std::numbers::sqrt2, kQf);
    map[p] = std::pow(redistribute(distance), 1.0 - std::min(feature, 1.0));
  }
  return map;
}

double mean_flip(const std::vector<double>& map) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const double value : map) {
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return sum / static_cast<double>(count);  // 0/0 where no pixel has a value
}

double mean_flip(const Image& a, const Image& b, double pixels_per_degree) {
  return mean_flip(flip_map(a, b, pixels_per_degree));
}

}  // namespace swept
