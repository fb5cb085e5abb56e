#include "abuffer/splats/posed_packet.h"

#include <algorithm>
#include <cmath>

namespace swept {
namespace {

/// Farther away nothing is drawn, and squares are still finite in float.
constexpr double farthest = 1e18;

}  // namespace

SplatFields fields_at(const SplatPackets& set, std::size_t packet, const SplatPose& pose,
                      PosedPacket& memory) {
  SplatFields fields = set.fields(packet);
  if (set.motions.empty()) return fields;
  constexpr std::size_t lanes = PosedPacket::lanes;
  const float* const own = set.motions.data() + own_numbers * lanes * packet;
  const double time = pose.clip_time;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const auto number = [&](std::size_t which) { return double{own[which * lanes + lane]}; };
    const double t = time - number(own_center), share = t / number(own_duration);
    const double opacity = double{fields.opacity[lane]} * std::exp(-share * share);
    const bool seen = opacity >= double{pose.view.least_alpha};
    memory.opacity[lane] = seen ? static_cast<float>(opacity) : 0.0f;
    // What is not seen may be far beyond what float can say.
    const double at = seen ? t : 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double way =
          at * (number(own_path + k) + at * (number(own_path + 3 + k) + at * number(own_path + 6 + k)));
      memory.offset[k * lanes + lane] =
          static_cast<float>(std::clamp(double{fields.offset[k * lanes + lane]} + way, -farthest, farthest));
    }
    double w = number(own_rotation), x = number(own_rotation + 1), y = number(own_rotation + 2),
           z = number(own_rotation + 3);
    const double tw = w + at * number(own_turn), tx = x + at * number(own_turn + 1),
                 ty = y + at * number(own_turn + 2), tz = z + at * number(own_turn + 3);
    // By the largest first, so that no square overflows or vanishes.
    const double largest = std::max({std::abs(tw), std::abs(tx), std::abs(ty), std::abs(tz)});
    if (largest > 0.0) w = tw / largest, x = tx / largest, y = ty / largest, z = tz / largest;
    const double norm = w * w + x * x + y * y + z * z, two = 2.0 / norm;
    const double scale[3] = {number(own_scale), number(own_scale + 1), number(own_scale + 2)};
    const double turn[9] = {
        1.0 - two * (y * y + z * z), two * (x * y + w * z),       two * (x * z - w * y),
        two * (x * y - w * z),       1.0 - two * (x * x + z * z), two * (y * z + w * x),
        two * (x * z + w * y),       two * (y * z - w * x),       1.0 - two * (x * x + y * y)};
    for (std::size_t k = 0; k < 9; ++k)
      memory.axes[k * lanes + lane] = static_cast<float>(turn[k] * scale[k / 3]);
  }
  fields.offset = memory.offset.data();
  fields.axes = memory.axes.data();
  fields.opacity = memory.opacity.data();
  return fields;
}

}  // namespace swept
