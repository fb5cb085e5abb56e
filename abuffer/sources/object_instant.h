// An object at one instant: where its packets are on the film, and the general form of a disc that the fast
// one leaves out.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "abuffer/sources/point_packets.h"
#include "splat/kernel/moving_kernel.h"
#include "splat/kernel/ray_kernel.h"
#include "splat/kernel/screen_bounds.h"
#include "splat/motion/instant.h"
#include "splat/motion/look.h"

namespace swept {

/// A square of film and the depth in front of which nothing of a packet lies.
struct PacketBounds {
  double x_min, x_max, y_min, y_max;  ///< px; x_min > x_max: nothing is seen
  double nearest;

  [[nodiscard]] bool empty() const { return !(x_min <= x_max && y_min <= y_max); }
};

struct ObjectInstant {
  Instant instant;
  Projection projection;
  ObjectPlace place;
  double enlarges = 1.0;  ///< most that a length grows from object to camera space
  std::size_t pose = 0;   ///< first of the stretch of PointPackets, and how far on it is in it
  double blend = 0.0;
  LookPlace look;                    ///< among PointPackets::looks
  std::vector<double> bernstein;     ///< of the other control points of the stretch; empty where degree is 1
  std::optional<SurfelsAt> surfels;  ///< where discs spin
  /// Of a scene with a lens: radius times focal length, and 1 / focus. bounds() contains what any point of
  /// the lens sees then.
  double lens_px = 0.0, per_focus = 0.0;

  /// At `frame`, the projection being that of this very instant.
  ObjectInstant(const Scene& scene, const PointPackets& packets, double frame);

  /// Centre of packet `p`'s sphere, camera space.
  [[nodiscard]] Eigen::Vector3d center(const PointPackets& packets, std::size_t p) const;
  /// The whole plane where it cannot be told.
  [[nodiscard]] PacketBounds bounds(const Eigen::Vector3d& center, double radius) const;
  [[nodiscard]] PacketPlace on_film(const Eigen::Vector3d& center) const;
};

/// A disc at an instant by the formulas of ray_kernel.h, in double: one that reaches the near plane or the
/// eye, lies far off the film, is seen partly from behind, or has numbers out of a float's range.
class GeneralDisc {
 public:
  /// Nothing if it cannot be seen. `point` is an index into the object's cloud.
  static std::optional<GeneralDisc> make(const Scene& scene, const Object& object, const ObjectInstant& at,
                                         std::uint32_t point);

  struct Fragment {
    float depth, weight;
    float side;  ///< as side_number()
  };
  /// At the centre of the film's pixel (x, y).
  [[nodiscard]] std::optional<Fragment> meet(int x, int y) const;

  /// Pixels [x_begin, x_end) × [y_begin, y_end) of the film contain it.
  int x_begin, x_end, y_begin, y_end;
  float tolerance;
  float rgba[4];  ///< premultiplied

 private:
  GeneralDisc(const MovingKernel& kernel, bool orthographic)
      : plane_(kernel, orthographic), weight_(kernel.weight) {}

  KernelPlane<double> plane_;
  Projection projection_;
  double near_ = 0.0, delta_ = 0.0, weight_;
};

}  // namespace swept
