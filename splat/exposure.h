// The time over which light is gathered, apart from the scene: the same scene is exposed whole, in parts, or
// at an instant.
#pragma once

namespace swept {

/// Frames, shutter times and keys beyond this either way are refused: a frame is lost in the rounding of
/// larger numbers.
inline constexpr double most_frame = 1e9;

/// From `open` to `close`, in absolute frames; open ≤ close. open == close is an instant: a still image.
struct Exposure {
  double open = 0.0, close = 0.0;

  [[nodiscard]] bool instant() const { return open == close; }
  /// Frame at shutter time `share` in [0, 1], 0 being open.
  [[nodiscard]] double at(double share) const { return open + (close - open) * share; }
  [[nodiscard]] double middle() const { return 0.5 * (open + close); }
};

}  // namespace swept
