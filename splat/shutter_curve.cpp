#include "splat/shutter_curve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "splat/scene.h"

namespace swept {

ShutterCurve::ShutterCurve(const Shutter& shutter) {
  if (shutter.curve == ShutterShape::gaussian) {
    delta_ = shutter.delta;
    return;
  }
  if (shutter.curve == ShutterShape::trapezoid) {
    times_ = {0.0, shutter.opening, 1.0 - shutter.closing, 1.0};
    rates_ = {0.0, 1.0, 1.0, 0.0};
  } else {
    const std::size_t last = shutter.rates.size() - 1;
    for (std::size_t i = 0; i <= last; ++i)
      times_.push_back(static_cast<double>(i) / static_cast<double>(last));
    rates_ = shutter.rates;
  }
  shares_.assign(1, 0.0);
  for (std::size_t i = 1; i < times_.size(); ++i)
    shares_.push_back(shares_.back() + 0.5 * (times_[i] - times_[i - 1]) * (rates_[i] + rates_[i - 1]));
  const double all = shares_.back();
  for (double& share : shares_) share /= all;
  for (double& rate : rates_) rate /= all;
  shares_.back() = 1.0;
}

double ShutterCurve::share(double time) const {
  time = std::clamp(time, 0.0, 1.0);
  if (delta_ > 0.0) {
    const double root = std::sqrt(delta_);
    return 0.5 + 0.5 * std::erf(root * (2.0 * time - 1.0)) / std::erf(root);
  }
  const auto above = std::upper_bound(times_.begin() + 1, times_.end() - 1, time);
  const auto i = static_cast<std::size_t>(above - times_.begin());
  const double length = times_[i] - times_[i - 1], x = time - times_[i - 1];
  if (!(length > 0.0)) return shares_[i - 1];
  return std::min(1.0,
                  shares_[i - 1] + x * (rates_[i - 1] + 0.5 * (rates_[i] - rates_[i - 1]) * (x / length)));
}

double ShutterCurve::time(double share) const {
  share = std::clamp(share, 0.0, 1.0);
  if (delta_ > 0.0) {
    // Newton's steps, kept between bounds that close in: erf is flat at the ends of a sharp curve.
    double low = 0.0, high = 1.0, time = share;
    for (int i = 0; i < 200 && low < high; ++i) {
      const double off = this->share(time) - share;
      (off < 0.0 ? low : high) = time;
      const double root = std::sqrt(delta_), y = 2.0 * time - 1.0;
      const double rate = 2.0 * root * std::exp(-delta_ * y * y) / (std::sqrt(M_PI) * std::erf(root));
      double next = time - off / rate;
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      if (next == time || next == low || next == high) break;
      time = next;
    }
    return time;
  }
  const auto reaches = std::lower_bound(shares_.begin() + 1, shares_.end() - 1, share);
  const auto i = static_cast<std::size_t>(reaches - shares_.begin());
  const double length = times_[i] - times_[i - 1], left = share - shares_[i - 1];
  if (!(left > 0.0)) return times_[i - 1];
  // rate x + slope x²/2 = left, by the root that does not cancel.
  const double rate = rates_[i - 1], slope = (rates_[i] - rates_[i - 1]) / length;
  const double x = 2.0 * left / (rate + std::sqrt(std::max(0.0, rate * rate + 2.0 * slope * left)));
  return times_[i - 1] + std::min(x, length);
}

}  // namespace swept
