// What a frame of splats knows of one of its cells while instants are added.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>

#include "abuffer/lens_looks.h"
#include "abuffer/resolve/sample_plan.h"
#include "abuffer/splats/error_forecast.h"
#include "abuffer/splats/splat_cell.h"

namespace swept {

/// Shutter time numerator / denominator; through a lens look `numerator` of `denominator` 1.
struct RoundInstant {
  int numerator, denominator;

  [[nodiscard]] double time() const { return static_cast<double>(numerator) / denominator; }
  [[nodiscard]] bool operator<(const RoundInstant& other) const {
    return std::int64_t{numerator} * other.denominator < std::int64_t{other.numerator} * denominator;
  }
  [[nodiscard]] bool operator==(const RoundInstant& other) const {
    return !(*this < other) && !(other < *this);
  }
};

/// A cell of the film's window on its way to the image. Its instants are N midpoints of strata of the
/// exposure; doubled, those half-way between and at both ends too, at half weight there: the trapezoid's
/// rule; doubled again, those half-way between. Through a lens they are looks of a sequence, and doubled the
/// next as many.
struct CellWork {
  std::size_t index = 0;  ///< in the grid
  Cell cell;
  int count = 1;  ///< of the rule, after this round
  bool moves = false;
  bool lens = false;       ///< instants are looks through one
  bool adaptive = false;   ///< its number of instants is chosen
  bool estimated = false;  ///< its error is
  bool done = false;       ///< it is in the image
  bool waiting = false;    ///< for whether there is time to double it
  int doublings = 0;
  int instants = 0;         ///< looked at in all
  int next = 0;             ///< of this round
  bool has_middle = false;  ///< the sums have the instant in the middle; its number of instants is odd
  std::optional<CellForecast> forecast;  ///< of the first round
  double expected_squares = 0.0;
  double seconds = 0.0;                ///< that the last round took
  std::unique_ptr<CellOfSplats> sums;  ///< while it is not done
  std::unique_ptr<ErrorEstimate> estimate;

  [[nodiscard]] int round_size() const {
    if (done || waiting) return 0;
    return doublings == 0 ? count : doublings == 1 && !lens ? count / 2 + 1 : count / 2;
  }
  /// In the order of time.
  [[nodiscard]] RoundInstant instant(int i) const {
    if (lens) return {doublings == 0 ? i : count / 2 + i, 1};
    if (doublings == 0) return {2 * i + 1, 2 * count};
    return doublings == 1 ? RoundInstant{i, count / 2} : RoundInstant{2 * i + 1, count};
  }
  [[nodiscard]] InstantWeights weights(int i) const {
    if (!estimated) return {};
    if (lens) return {1.0f, doublings == 0 ? half_of_looks(i, count) : -1.0f, 0.0f, 0.0f};
    if (doublings == 0) return estimating_weights(i, count);
    const float w = doublings == 1 && (i == 0 || i == count / 2) ? 0.5f : 1.0f;
    return {w, -w, 0.0f, 0.0f};
  }

  /// Whether the i-th instant of this round is in the sums already.
  [[nodiscard]] bool has(int i) const { return has_middle && doublings == 0 && 2 * i + 1 == count; }

  /// Estimates the error of the instants so far. `near_jumps`: as FilmMotion has them of this cell.
  void judge(double near_jumps) {
    const SampledCell::Squares squares = sums->squares(cell);
    if (estimate == nullptr)
      estimate = std::make_unique<ErrorEstimate>(squares, count,
                                                 lens ? ErrorEstimate::of_lens : ErrorEstimate::of_splats);
    else
      estimate->refine(squares, count);
    if (forecast && doublings == 0) {
      // Of what jumps besides splats that change their order: trained scenes that were tried begin to show it
      // from some 62 dB on.
      constexpr double jumps = 5.6e-7;
      const double values = 3.0 * cell.width * cell.height;
      estimate->foresee(forecast->expected(estimate->seen() / values, jumps) * values);
    }
    // Where all pixels jump at once they do not make up for each other.
    expected_squares = std::max(estimate->squares(),
                                near_jumps * 3.0 * cell.width * cell.height / (double{1.0} * count * count));
  }

  void double_instants() {
    sums->alternate_from_sums();
    count *= 2;
    ++doublings;
    waiting = false;
  }
  /// Squared error that it may lose for a second's work; 0 where it is as good as a picture can show.
  [[nodiscard]] double gain() const {
    constexpr double unseen = 1e-12;  // of the mean square: 120 dB
    if (!waiting || count >= most_chosen_instants ||
        expected_squares <= unseen * 3.0 * cell.width * cell.height)
      return 0.0;
    return expected_squares / std::max(seconds, 1e-9);
  }
};

}  // namespace swept
