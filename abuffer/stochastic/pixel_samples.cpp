#include "abuffer/stochastic/pixel_samples.h"

#include <algorithm>
#include <cmath>

#include "splat/lens_points.h"

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

}  // namespace

double LensReach::tangent(double reach, double z) const {
  return reach * std::max(std::abs(1.0 / z - least_inverse_focus), std::abs(1.0 / z - most_inverse_focus));
}

SampleSource::SampleSource(const Scene& scene, const Exposure& exposure, int samples, int times)
    : exposure_(exposure), samples_(samples), times_(times), aperture_(scene.camera.aperture) {
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
        std::uint32_t sobol[3];
        directions_.at(index, sobol);
        out.x[k] = unit_interval(
            scrambled(index, seed[0]));  // the first dimension is the index with its digits reversed
        out.y[k] = unit_interval(scrambled(reversed_digits(sobol[0]), seed[1]));
        double share = (i + double{unit_interval(mixed(seed[2] + index))}) / samples_;
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
        const Eigen::Vector2d place =
            point_on_lens(aperture_, double{unit_interval(scrambled(reversed_digits(sobol[1]), seed[3]))},
                          double{unit_interval(scrambled(reversed_digits(sobol[2]), seed[4]))});
        out.lens_x[k] = static_cast<float>(lens.x * place.x());
        out.lens_y[k] = static_cast<float>(lens.y * place.y());
        out.toward_x[k] = static_cast<float>(lens.x * place.x() * lens.inverse_focus);
        out.toward_y[k] = static_cast<float>(lens.y * place.y() * lens.inverse_focus);
      }
    }
}

}  // namespace swept::stochastic
