#include "abuffer/resolve/sample_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace swept {
namespace {

/// Of squares whose fall was not seen: that of jumps.
constexpr double unseen_fall = 0.25;

}  // namespace

int first_instants(float motion_px, double max_error_db, double per_px) {
  if (!(motion_px > 0.0f)) return 1;
  const double rate = per_px * std::pow(10.0, (max_error_db - 60.0) / 40.0);
  const double wanted = std::max(2.0, rate * double{motion_px});
  // 2, 3, 4, 6, 8, 12, …
  int count = 2;
  while (count < wanted && count < (1 << 20)) {
    const int next = (count & (count - 1)) == 0 ? count + count / 2 : (count / 3) * 4;
    if (wanted < 0.5 * (count + next)) break;
    count = next;
  }
  return count;
}

double expected_fall(double before, double instants_per_px) {
  const double x = instants_per_px;
  // The mean goes on to 0.07; but frames at 75 dB, whose cells end here, then fell short of what they
  // expected.
  const double late = x > 0.7 ? 0.15 : 0.07;
  const double least = std::min(0.25, std::max({late, 0.025 / x, 0.07 * x}));
  const double most = std::min(1.0, std::max(0.14 / x, std::min(0.3, 0.12 * x)));
  return std::clamp(std::pow(before, 1.25), least, std::max(least, most));
}

double error_share(double px, std::size_t packets, int instants) {
  // An instant of a cell takes as long as so many packets, before it has any.
  constexpr double packets_of_a_cell = 20.0;
  return std::sqrt(px * (packets_of_a_cell + static_cast<double>(packets)) * instants);
}

double slack(double moving_cells, double max_error_db, bool lens) {
  const double fall_db = std::clamp(12.0 - 0.2 * (max_error_db - 60.0), 6.0, 12.0);
  const double mean = (1.0 - std::pow(10.0, -0.1 * fall_db)) / (0.1 * std::numbers::ln10 * fall_db);
  return 1.0 + (lens ? 1.25 : 1.0) * (1.0 / mean - 1.0) * moving_cells / (moving_cells + 24.0);
}

float typical_motion(const PacketBins& bins, std::span<const PacketRef> packets) {
  double squares = 0.0, count = 0.0;
  for (const PacketRef packet : packets) {
    const double motion = double{bins.motion_px(packet)};
    if (motion == 0.0) continue;
    // What a packet shows is shared among the cells that it comes by.
    const double share = 1.0 / std::max(1.0, double{bins.cells_touched(packet)});
    squares += share * motion * motion;
    count += share;
  }
  return count > 0.0 ? static_cast<float>(std::sqrt(squares / count)) : 0.0f;
}

InstantWeights estimating_weights(int i, int count) {
  const auto alternating = [](int k, int of) {
    return (k % 2 == 0 ? 1.0f : -1.0f) * (k == 0 || k == of - 1 ? 0.5f : 1.0f);
  };
  InstantWeights weights;
  weights.alternating = alternating(i, count);
  (i % 2 == 0 ? weights.even : weights.odd) = alternating(i / 2, i % 2 == 0 ? (count + 1) / 2 : count / 2);
  return weights;
}

void count_expected_error(double squares, double px, double worst_cell, Statistics& statistics) {
  const double rmse = std::sqrt(squares / (3.0 * std::max(1.0, px)));
  statistics.count("expected_rmse", rmse);
  statistics.count("expected_psnr_db", -20.0 * std::log10(rmse));
  statistics.count("expected_worst_cell_rmse", std::sqrt(worst_cell));
}

ErrorEstimate::ErrorEstimate(const SampledCell::Squares& squares, int count, const LeastFall& least_fall)
    : least_(least_fall) {
  begin(squares, count);
}

ErrorEstimate::ErrorEstimate(const SampledCell::Squares& squares, int count, float motion_px)
    : motion_px_(double{motion_px}) {
  begin(squares, count);
}

void ErrorEstimate::begin(const SampledCell::Squares& squares, int count) {
  const double scale = 1.0 / (double{1.0} * count * count);
  alternating_ = squares.alternating * scale;
  grey_ = squares.grey * scale;
  // Fewer instants than this show no second frequency: at 1/N the error is half of what they show.
  constexpr int least = 4;
  extrapolate(count < least || squares.quarter == 0.0 ? unseen_fall : 0.5 * squares.grey / squares.quarter,
              count);
}

void ErrorEstimate::refine(const SampledCell::Squares& squares, int count) {
  const double before = grey_, scale = 1.0 / (double{1.0} * count * count);
  alternating_ = squares.alternating * scale;
  grey_ = squares.grey * scale;
  extrapolate(before > 0.0 ? grey_ / before : unseen_fall, count);
}

void ErrorEstimate::foresee(double squares) {
  if (!(squares < squares_)) return;
  per_alternating_ *= squares / squares_;
  squares_ = squares;
}

/// `falls_by`: F²(N/2) over F²(N/4).
void ErrorEstimate::extrapolate(double falls_by, int count) {
  double fall = falls_by;
  if (motion_px_ == 0.0)
    fall = std::clamp(falls_by, count < least_.few ? least_.of_few : least_.of, least_.most);
  else if (falls_by != unseen_fall)
    fall = expected_fall(falls_by, count / motion_px_);
  squares_ = alternating_ * multiples * fall;
  per_alternating_ = multiples * fall / (double{1.0} * count * count);
}

}  // namespace swept
