// A small scene for every hard case of model section 10: for the tests, and for tools/hard-cases.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "splat/scene.h"

namespace swept::oracle {

struct HardScene {
  std::string name;   ///< of files and tests: lower case, underscores
  std::string shows;  ///< what is to be seen
  /// 90, and 80 or 85 where discs, pixels or surfaces graze and where a passage takes less than the time
  /// between two stills.
  double required_db = 90.0;
  int samples = 1024;  ///< still images the reference needs for its own error to be well below that
  Scene (*make)() = nullptr;
  /// Relative, times alpha, root mean square: as for the random scenes, and more where what is behind a
  /// silhouette is a millionfold farther away, and as sensitive to the time it appears.
  double required_depth = 3e-4;

  friend void PrintTo(const HardScene& scene, std::ostream* out) { *out << scene.name; }
};

/// Film 48 × 36 px, focal length 36 px, near plane at 0.1; but for the far one, the world is camera space at
/// mid-shutter. The shutter is one frame, and velocities are therefore per exposure.
[[nodiscard]] const std::vector<HardScene>& hard_scenes();

}  // namespace swept::oracle
