#include "abuffer/resolve/sample_plan.h"

#include <algorithm>
#include <cmath>

namespace swept {

int first_instants(float motion_px, double max_error_db) {
  if (!(motion_px > 0.0f)) return 1;
  const double rate = 0.35 * std::pow(10.0, (max_error_db - 60.0) / 40.0);
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

float typical_motion(const PacketBins& bins, std::span<const PacketRef> packets) {
  double squares = 0.0, count = 0.0;
  for (const PacketRef packet : packets) {
    const double motion = double{bins.motion_px(packet)};
    if (motion == 0.0) continue;
    squares += motion * motion;
    count += 1.0;
  }
  return count > 0.0 ? static_cast<float>(std::sqrt(squares / count)) : 0.0f;
}

}  // namespace swept
