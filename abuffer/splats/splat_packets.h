// Gaussian splats as the engine keeps them: packets of sixteen neighbours in vectors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "abuffer/simd/splat_math.h"
#include "splat/exposure.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// Splats of one object that all stand still over an exposure, or that all may move.
struct SplatPackets {
  const Object* object = nullptr;
  bool moves = false;
  std::size_t splats = 0, count = 0;     ///< count: of packets
  std::vector<Eigen::Vector3d> origins;  ///< by packet, object space
  std::vector<float> offsets;            ///< 3 · 16 a packet
  std::vector<float> axes;               ///< 9 · 16, or empty where there are motions
  std::vector<float> velocities;         ///< 3 · 16, or empty
  std::vector<float> motions;            ///< 22 · 16 (posed_packet.h), or empty
  std::vector<float> opacities;          ///< 16
  std::vector<float> harmonics;          ///< coefficients · 3 · 16
  std::vector<std::uint32_t> lanes;      ///< that hold a splat, a bit each

  [[nodiscard]] SplatFields fields(std::size_t packet) const;
};

/// How many of them are placed anew at every instant.
[[nodiscard]] std::size_t moving_splats(const std::vector<SplatPackets>& sets);

/// Whether the splats of a scene can be blended into one picture.
[[nodiscard]] Status check_splats(const Scene& scene);

/// Bytes that pack_splats() keeps: 60 a splat and 12 a coefficient, 252 at degree 3; 12 more with velocities,
/// 52 more where they move by themselves.
[[nodiscard]] std::size_t packed_splat_bytes(const Scene& scene);

/// Packs every object's splats, those that can be seen at all, in an order that depends on their content and
/// on no order of the scene. Runs in the caller's task arena. `scene` must outlive the result.
[[nodiscard]] std::vector<SplatPackets> pack_splats(const Scene& scene, const Exposure& exposure,
                                                    bool only_standing = false);

/// What an object's packets share at a frame, and where one of them is.
class SplatPose {
 public:
  SplatPose(const Scene& scene, const SplatPackets& packets, double frame);

  [[nodiscard]] SplatOrigin origin(const SplatPackets& packets, std::size_t packet) const;

  SplatView view;
  double clip_time = 0.0;  ///< that of training, of splats that move by themselves

 private:
  Eigen::Affine3d world_from_object_;
  Eigen::Matrix3d camera_from_world_;
  Eigen::Vector3d eye_;
  double focal_x_, focal_y_, center_x_, center_y_;
  bool orthographic_;
};

}  // namespace swept
