// At how many instants a cell is looked at, and when that is enough.
//
// Source: model section 12. Where a pixel's signal is smooth the midpoint rule converges faster than any
// power until there is about one instant per pixel of motion; from there silhouettes lead, at 1/N.
#pragma once

#include <cstddef>
#include <span>

#include "abuffer/resolve/sampled_cell.h"
#include "abuffer/tiles/cells.h"
#include "splat/rendered.h"

namespace swept {

/// Instants are doubled at most to so many.
inline constexpr int most_chosen_instants = 1 << 14;

/// Instants a pixel of motion that cells begin with where 60 dB are asked for: of discs, whose errors are
/// foreseen by expected_fall(), and of all else.
inline constexpr double disc_instants_per_px = 0.25, other_instants_per_px = 0.35;

/// Instants a cell begins with, of a ladder of numbers, for motion across it and the frame's error in dB.
[[nodiscard]] int first_instants(float motion_px, double max_error_db, double per_px);

/// By how much the squares of what discs miss fall, in the mean, from half of `instants_per_px` to all of it,
/// where they fell by `before` from a quarter to half.
///
/// The filter and the discs take away frequencies the faster the higher these are, so that a fall is followed
/// by a greater one, up to about one instant a pixel of motion; from there jumps lead, which fall by 4.
/// Fitted to what cells of 20 random scenes miss at 2 to 192 instants, and found on 12 others.
[[nodiscard]] double expected_fall(double before, double instants_per_px);

/// How much of the error that a frame may have a cell of `px` pixels may have, relative to others.
///
/// What N instants miss falls as a power of N, so that all time together is least where each cell's error
/// goes with the time that it takes. But that is known badly before, and errors are seen by area: half of
/// each.
[[nodiscard]] double error_share(double px, std::size_t packets, int instants);

/// Doubling leaves most cells better than they need be, by half of what errors fall by at a time, so that
/// each may have so much more than its share. The fewer cells there are, the less can be relied on that.
///
/// Errors fall by some 12 dB from one number of instants to twice as many at 60 dB, and by 6 once jumps lead;
/// if any part of the last fall is as likely as any other, the squares are the mean of 10^(−u/10) over it.
[[nodiscard]] double slack(double moving_cells, double max_error_db, bool lens);

/// Motion that stands for all of a cell's.
[[nodiscard]] float typical_motion(const PacketBins& bins, std::span<const PacketRef> packets);

/// What is expected of an image: `squares` over its `px` pixels and R, G, B, and the mean of the worst cell.
void count_expected_error(double squares, double px, double worst_cell, Statistics& statistics);

/// Of the i-th of so many midpoints. Half weight at the ends leaves out of the alternating sums that the
/// signal does not end as it began, which the midpoint rule does not mind.
[[nodiscard]] InstantWeights estimating_weights(int i, int count);

/// What a cell of N instants is off by.
///
/// The midpoint rule takes the signal's frequencies N, 2N, … for its mean. The alternating sums show the
/// frequency N/2, those of every other instant N/4; what falls from there to there falls at least as much
/// again to N. With amplitudes F the alternating sums are √2 F(N/2) in the mean over phases, the others
/// F(N/4), and the error √2 F(N).
class ErrorEstimate {
 public:
  /// The least by which the squares are taken to fall, however fast they fell so far: what is smooth falls
  /// fast until jumps lead, which fall by 4; nothing seen tells when, and few instants least.
  struct LeastFall {
    int few;            ///< fewer instants than this
    double of_few, of;  ///< fall by so much, others by that
    double most;        ///< and at most by this
  };
  /// Of discs whose motion is uneven in the light's time.
  static constexpr LeastFall of_edges = {12, 0.25, 0.15, 1.0};
  /// Passing splats are bells, and fall faster and faster; those that change their order jump.
  static constexpr LeastFall of_splats = {4, 0.2, 0.15, 1.0};
  /// Halves of looks through a lens are each as good as so many looks are. With the square of their error
  /// falling by f when looks are doubled, that of half their difference falls short of it by 1 − f, and what
  /// is left is f / (1 − f) of it: 0.55 at the power 3/2 of edges in two dimensions (f = 0.35), 1 at worst.
  static constexpr LeastFall of_lens = {0, 0.55, 0.55, 0.55};

  ErrorEstimate(const SampledCell::Squares& squares, int count, const LeastFall& least);
  /// Of discs that move so far, evenly in the light's time: as expected_fall() has it.
  ErrorEstimate(const SampledCell::Squares& squares, int count, float motion_px);
  /// After the instants were doubled to `count`, and the alternating sums with them.
  void refine(const SampledCell::Squares& squares, int count);

  /// Takes `squares` for what is expected if that is less.
  void foresee(double squares);

  /// What half as many instants are off by, Σ over pixels and R, G, B.
  [[nodiscard]] double seen() const { return multiples * alternating_; }
  /// Expected, Σ over pixels and R, G, B.
  [[nodiscard]] double squares() const { return squares_; }
  /// How much of it there is for every square of an alternating sum.
  [[nodiscard]] double per_alternating() const { return per_alternating_; }

 private:
  // Of a jump all multiples of N count, Σ1/k² = π²/6, where the sums see the odd ones of N/2 and N/4, π²/8
  // each.
  static constexpr double multiples = 4.0 / 3.0;

  void begin(const SampledCell::Squares& squares, int count);
  void extrapolate(double falls_by, int count);

  LeastFall least_{};
  double motion_px_ = 0.0;  ///< of discs; 0: least_ holds
  double alternating_ = 0.0, grey_ = 0.0, squares_ = 0.0, per_alternating_ = 0.0;
};

}  // namespace swept
