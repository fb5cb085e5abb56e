// The time over which light is gathered, apart from the scene: the same scene is exposed whole, in parts, or
// at an instant.
#pragma once

#include <memory>

#include "splat/export.h"
#include "splat/shutter_curve.h"

namespace SWEPT_API swept {

/// Frames, shutter times and keys beyond ± this are refused: larger numbers round a frame away.
inline constexpr double most_frame = 1e9;

/// From `open` to `close`, in absolute frames; open ≤ close. open == close is an instant: a still image.
///
/// Shutter time is the share of the light that has come in. So if shutter time goes evenly from 0 to 1, every
/// instant has the weight that the shutter's curve gives it.
struct Exposure {
  double open = 0.0, close = 0.0;
  std::shared_ptr<const ShutterCurve> curve = {};  ///< null: even light
  /// The frames at which the curve begins and ends: those of the whole exposure, of which this may be a part.
  double curve_open = 0.0, curve_close = 0.0;
  /// Frames by which each row of the film is exposed later than the row above it (below 0: earlier). `open`
  /// and `close` are those of the top row.
  double row_delay = 0.0;

  [[nodiscard]] bool instant() const { return open == close; }
  /// Frame at shutter time `share` in [0, 1], 0 being open.
  [[nodiscard]] double at(double share) const {
    if (!curve) return open + (close - open) * share;
    const double first = curve_share(open), last = curve_share(close);
    return curve_open + (curve_close - curve_open) * curve->time(first + (last - first) * share);
  }
  /// Shutter time at `frame` between open and close; the inverse of at().
  [[nodiscard]] double share_at(double frame) const {
    if (!curve) return (frame - open) / (close - open);
    const double first = curve_share(open), last = curve_share(close);
    return last > first ? (curve_share(frame) - first) / (last - first) : 0.0;
  }
  [[nodiscard]] double middle() const { return 0.5 * (open + close); }
  /// The exposure of row `y` of the film, all of it at once.
  [[nodiscard]] Exposure of_row(int y) const {
    Exposure result = *this;
    const double later = row_delay * y;
    result.open += later;
    result.close += later;
    result.curve_open += later;
    result.curve_close += later;
    result.row_delay = 0.0;
    return result;
  }
  /// An evenly lit exposure from when the first of `rows` rows begins to be exposed until the last one ends.
  [[nodiscard]] Exposure of_all_rows(int rows) const {
    if (row_delay == 0.0) return *this;
    const double later = row_delay * (rows - 1);
    return {open + (later < 0.0 ? later : 0.0), close + (later > 0.0 ? later : 0.0)};
  }
  /// The exposure from shutter time `first` to `last`.
  [[nodiscard]] Exposure part(double first, double last) const {
    Exposure result = *this;
    if (first > 0.0) result.open = at(first);
    if (last < 1.0) result.close = at(last);
    return result;
  }
  /// The instant at shutter time `share`.
  [[nodiscard]] Exposure instant_at(double share) const {
    const double frame = at(share);
    return {frame, frame};
  }

 private:
  [[nodiscard]] double curve_share(double frame) const {
    return curve->share((frame - curve_open) / (curve_close - curve_open));
  }
};

}  // namespace swept
