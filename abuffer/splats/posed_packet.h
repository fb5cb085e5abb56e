// A packet of splats that move, turn and fade by themselves, as one instant has them.
//
// Source: model section 14.9; Li et al. 2024.
#pragma once

#include <array>
#include <cstddef>

#include "abuffer/splats/splat_packets.h"

namespace swept {

/// What a packet's splats are made of besides colours, lanes of SplatFields.
struct PosedPacket {
  static constexpr auto lanes = static_cast<std::size_t>(packet_size);
  std::array<float, 3 * lanes> offset;
  std::array<float, 9 * lanes> axes;
  std::array<float, lanes> opacity;
};

/// How a packet's splats move by themselves, as SplatPackets::motions has it, field by field of 16 numbers.
enum OwnMotion : std::size_t {
  own_center = 0,
  own_duration = 1,
  own_path = 2,       ///< x y z per time, then per time² and time³
  own_turn = 11,      ///< w x y z
  own_rotation = 15,  ///< w x y z
  own_scale = 19,
  own_numbers = 22,
};

/// The splats of a packet at the frame of `pose`: those of the set itself, or where they move by themselves
/// those in `memory`, which it fills. What has faded away has opacity 0.
[[nodiscard]] SplatFields fields_at(const SplatPackets& set, std::size_t packet, const SplatPose& pose,
                                    PosedPacket& memory);

}  // namespace swept
