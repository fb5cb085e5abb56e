// How far off the mean of so many stills will be, read from one still before the others are drawn.
//
// Source: model section 14. What moves draws its own picture through a pixel: along the way of what a still
// shows there, the still is the pixel's signal over the exposure. So an alternating sum of 2N places on that
// way has the frequency N in it, which N instants take for their mean.
#pragma once

#include <optional>
#include <vector>

#include "abuffer/splats/film_motion.h"
#include "abuffer/splats/splat_row.h"

namespace swept {

/// The film at an instant: linear red, green, blue and nothing, pixel by pixel.
struct FilmStill {
  int width = 0, height = 0;
  std::vector<float> rgba;
};

/// What is expected of a cell: mean squares over its pixels and R, G, B.
struct CellForecast {
  int count = 0;  ///< instants to begin with
  double at_half = 0.0, at_count = 0.0;

  /// What these instants are off by, where they turn out to be off by `seen` as half as many. Splats that
  /// change their order jump, by so much in all, perhaps.
  [[nodiscard]] double expected(double seen, double jumps) const;
};

class ErrorForecast {
 public:
  /// `still` and `motion` must outlive the forecast.
  ErrorForecast(const FilmStill& still, const FilmMotion& motion, double dilation_px2)
      : still_(still), motion_(motion), dilation_px2_(dilation_px2) {}

  /// The least instants that a cell, `index` of the grid, is expected to take to `allowed_mean_square`.
  /// Nothing where the ways leave the film, or where more than 161 would be wanted.
  [[nodiscard]] std::optional<CellForecast> of(const Cell& cell, std::size_t index,
                                               double allowed_mean_square) const;

 private:
  const FilmStill& still_;
  const FilmMotion& motion_;
  double dilation_px2_;
};

}  // namespace swept
