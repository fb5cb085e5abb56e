// Points of one object in packets of sixteen neighbours, as the sampled engine reads them. Those whose paths
// call for more than others have packets of their own (path_groups.h).
//
// Coordinates are floats from an origin of the packet's own, which is a double: survey coordinates keep their
// digits. The order depends on what the points are, never on the order in which they came.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "abuffer/simd/sampled_math.h"
#include "abuffer/unset_array.h"
#include "splat/scene.h"

namespace swept {

struct ObjectInstant;

/// A packet's points at an instant, where they are not read from the packets as they lie there.
struct PacketScratch {
  float offset[3 * packet_size], axes[6 * packet_size];
};

/// What the points of packets look like at a frame.
struct LookOfPackets {
  double frame;
  UnsetArray<float> colors;  ///< as PointPackets has them
};

/// Object space. From one of `frames` to the next points follow Bézier curves of one degree, of which the
/// poses are the control points: pose j · degree + k is control point k of stretch j, and the last of one
/// stretch is the first of the next.
struct PointPackets {
  const Object* object = nullptr;
  std::size_t count = 0;       ///< packets
  std::size_t size = 0;        ///< points
  std::size_t degree = 1;      ///< 1: straight lines, as linear keys and velocities have it
  bool spins = false;          ///< discs turn at rates of their own, which the poses do not have
  bool mortal = false;         ///< points come or go
  std::vector<double> frames;  ///< where stretches begin and end, increasing; one: nothing moves
  std::vector<std::vector<Eigen::Vector3d>> origins;  ///< by pose and packet
  std::vector<UnsetArray<float>> offsets;             ///< by pose; 3 · 16 a packet
  std::vector<UnsetArray<float>> axes;                ///< by pose, or of all poses; 6 · 16 a packet
  UnsetArray<float> colors;          ///< red, green, blue times opacity, opacity; 4 · 16 a packet
  std::vector<LookOfPackets> looks;  ///< not empty: in place of `colors`, which change from one to the next
  std::vector<float> radius;         ///< of the sphere about the origin that holds the discs
  std::vector<std::uint32_t> lanes;  ///< that hold a point, a bit each
  std::vector<std::uint32_t> oriented;  ///< likewise, and whose front and back are told apart; empty: none
  std::vector<std::uint32_t> points;    ///< index of each lane in the object's cloud

  /// Packet `p`. What is returned may lie in `scratch`.
  [[nodiscard]] PacketPoints at(std::size_t p, const ObjectInstant& instant, PacketScratch& scratch) const;
  /// Puts its colours at an instant into `placed`.
  void color(std::size_t p, const ObjectInstant& instant, PlacedPacket& placed) const;
};

/// Bytes that pack_points() keeps: 56 a point that stands still, 70 with a velocity, 36 for each further
/// pose, 16 for each look beyond the first. Where only some of an object's points curve, those of all if they
/// did, which is more.
[[nodiscard]] std::size_t packed_bytes(const Scene& scene, const Exposure& exposure);

/// Packs every object of `scene` over `exposure`, or those that stand still in it, each group of its points
/// by itself. They come in an order that depends on their content, too; equal ones are interchangeable. Runs
/// in the caller's task arena. `scene` must outlive the result.
[[nodiscard]] std::vector<PointPackets> pack_points(const Scene& scene, const Exposure& exposure,
                                                    bool only_standing = false);

}  // namespace swept
