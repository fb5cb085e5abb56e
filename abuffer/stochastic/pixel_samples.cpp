#include "abuffer/stochastic/pixel_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace swept::stochastic {
namespace {

constexpr std::size_t lens_times = 1025;  // lines between them: focus is keyed, and changes slowly

std::uint32_t mixed(std::uint32_t v) {
  v ^= v >> 16;
  v *= 0x7feb352dU;
  v ^= v >> 15;
  v *= 0x846ca68bU;
  return v ^ v >> 16;
}

std::uint32_t reversed(std::uint32_t v) {
  v = v >> 16 | v << 16;
  v = (v & 0xff00ff00U) >> 8 | (v & 0x00ff00ffU) << 8;
  v = (v & 0xf0f0f0f0U) >> 4 | (v & 0x0f0f0f0fU) << 4;
  v = (v & 0xccccccccU) >> 2 | (v & 0x33333333U) << 2;
  return (v & 0xaaaaaaaaU) >> 1 | (v & 0x55555555U) << 1;
}

/// Every digit flipped or not as the digits before it say. From the digits in reverse and back to their
/// order.
std::uint32_t scrambled(std::uint32_t reversed_digits, std::uint32_t seed) {
  std::uint32_t v = reversed_digits + seed;
  v ^= v * 0x6c50b47cU;
  v ^= v * 0xb82f1e52U;
  v ^= v * 0xc7afe638U;
  v ^= v * 0x8d22f6e6U;
  return reversed(v);
}

/// In [0, 1).
float unit(std::uint32_t v) { return static_cast<float>(v >> 8) * 0x1p-24f; }

/// Joe and Kuo 2008: a polynomial's degree s, its inner coefficients a, and the first s numbers m.
void fill_directions(int s, std::uint32_t a, std::initializer_list<std::uint32_t> m, std::uint32_t (&v)[32]) {
  int i = 0;
  for (const std::uint32_t first : m) v[i] = first << (31 - i), ++i;
  for (; i < 32; ++i) {
    v[i] = v[i - s] ^ v[i - s] >> s;
    for (int k = 1; k < s; ++k)
      if ((a >> (s - 1 - k) & 1U) != 0) v[i] ^= v[i - k];
  }
}

}  // namespace

double LensReach::tangent(double reach, double z) const {
  return reach * std::max(std::abs(1.0 / z - least_inverse_focus), std::abs(1.0 / z - most_inverse_focus));
}

SampleSource::SampleSource(const Scene& scene, const Exposure& exposure, int samples, int times)
    : exposure_(exposure), samples_(samples), times_(times), aperture_(scene.camera.aperture) {
  fill_directions(1, 0, {1}, directions_[0]);
  fill_directions(2, 1, {1, 3}, directions_[1]);
  fill_directions(3, 1, {1, 3, 1}, directions_[2]);
  if (!(aperture_.radius > 0.0)) return;
  const CameraInstant middle = scene.camera.at(exposure.middle());
  const bool constant = exposure.instant() || scene.camera.constant_over(exposure.open, exposure.close);
  const std::size_t count = constant ? 1 : lens_times;
  for (std::size_t i = 0; i < count; ++i) {
    const double time = constant ? 0.5 : static_cast<double>(i) / static_cast<double>(count - 1);
    const CameraInstant camera = scene.camera.at(exposure.open + (exposure.close - exposure.open) * time);
    const Eigen::Matrix3d lens = lens_matrix(camera, middle);
    lens_.push_back({1.0 / camera.lens.focus, lens(0, 0), lens(1, 1)});
  }
  reach_.least_inverse_focus = reach_.most_inverse_focus = lens_.front().inverse_focus;
  for (const LensAt& at : lens_) {
    // Samples are floats: what rounding adds is far less than this.
    reach_.x = std::max(reach_.x, 1.000001 * aperture_.radius * std::abs(at.x));
    reach_.y = std::max(reach_.y, 1.000001 * aperture_.radius * std::abs(at.y));
    reach_.least_inverse_focus = std::min(reach_.least_inverse_focus, at.inverse_focus);
    reach_.most_inverse_focus = std::max(reach_.most_inverse_focus, at.inverse_focus);
  }
}

SampleSource::LensAt SampleSource::lens_at(double time) const {
  if (lens_.size() == 1) return lens_[0];
  const double at = time * static_cast<double>(lens_.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(at), lens_.size() - 2);
  const double t = at - static_cast<double>(i);
  const LensAt &a = lens_[i], &b = lens_[i + 1];
  return {a.inverse_focus + t * (b.inverse_focus - a.inverse_focus), a.x + t * (b.x - a.x),
          a.y + t * (b.y - a.y)};
}

/// As lens_points() spreads them.
Eigen::Vector2d SampleSource::place_on_lens(double radius_share, double turn) const {
  const auto on_circle = [&](double turns) {
    const double angle = 2.0 * std::numbers::pi * turns + aperture_.rotation_radians;
    return Eigen::Vector2d(std::cos(angle), std::sin(angle));
  };
  const double radius = aperture_.radius * std::sqrt(radius_share);
  if (aperture_.blades == 0) return radius * on_circle(turn);
  const double along = turn * aperture_.blades, corner = std::floor(along);
  const Eigen::Vector2d a = on_circle(corner / aperture_.blades),
                        b = on_circle((corner + 1) / aperture_.blades);
  return radius * (a + (along - corner) * (b - a));
}

float SampleSource::time_of(double share) const {
  if (!exposure_.curve || exposure_.instant()) return static_cast<float>(share);
  const double time = (exposure_.at(share) - exposure_.open) / (exposure_.close - exposure_.open);
  return static_cast<float>(std::clamp(time, 0.0, 1.0));
}

void SampleSource::fill(const Window& window, BlockSamples& out) const {
  out.window = window;
  out.per_pixel = samples_;
  const std::size_t count = static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height) *
                            static_cast<std::size_t>(samples_);
  out.x.resize(count), out.y.resize(count), out.share.resize(count), out.time.resize(count);
  out.instant.resize(times_ > 0 ? count : 0);
  for (std::vector<float>* lens : {&out.lens_x, &out.lens_y, &out.toward_x, &out.toward_y})
    lens->resize(lens_.empty() ? 0 : count);
  std::size_t k = 0;
  for (int y = window.y; y < window.y + window.height; ++y)
    for (int x = window.x; x < window.x + window.width; ++x) {
      const std::uint32_t pixel = mixed(static_cast<std::uint32_t>(x) + mixed(static_cast<std::uint32_t>(y)));
      const std::uint32_t seed[5] = {mixed(pixel ^ 1U), mixed(pixel ^ 2U), mixed(pixel ^ 3U),
                                     mixed(pixel ^ 4U), mixed(pixel ^ 5U)};
      for (int i = 0; i < samples_; ++i, ++k) {
        const auto index = static_cast<std::uint32_t>(i);
        std::uint32_t sobol[3] = {0, 0, 0};
        for (std::uint32_t bits = index, d = 0; bits != 0; bits >>= 1, ++d)
          if ((bits & 1U) != 0)
            for (int dimension = 0; dimension < 3; ++dimension) sobol[dimension] ^= directions_[dimension][d];
        out.x[k] =
            unit(scrambled(index, seed[0]));  // the first dimension is the index with its digits reversed
        out.y[k] = unit(scrambled(reversed(sobol[0]), seed[1]));
        double share = (i + double{unit(mixed(seed[2] + index))}) / samples_;
        if (times_ > 0) {
          const int instant = std::min(static_cast<int>(share * times_), times_ - 1);
          out.instant[k] = static_cast<std::uint16_t>(instant);
          out.share[k] = instant_share(instant);
        } else {
          out.share[k] = std::min(static_cast<float>(share), 1.0f - 0x1p-24f);
        }
        out.time[k] = time_of(double{out.share[k]});
        if (lens_.empty()) continue;
        const LensAt lens = lens_at(double{out.time[k]});
        const Eigen::Vector2d place = place_on_lens(double{unit(scrambled(reversed(sobol[1]), seed[3]))},
                                                    double{unit(scrambled(reversed(sobol[2]), seed[4]))});
        out.lens_x[k] = static_cast<float>(lens.x * place.x());
        out.lens_y[k] = static_cast<float>(lens.y * place.y());
        out.toward_x[k] = static_cast<float>(lens.x * place.x() * lens.inverse_focus);
        out.toward_y[k] = static_cast<float>(lens.y * place.y() * lens.inverse_focus);
      }
    }
}

}  // namespace swept::stochastic
