// Sparks: particles thrown from the origin about +y that fall in an arc, each with its own velocity.
#include <Eigen/Geometry>

#include "datasets/paint.h"
#include "datasets/sampling.h"

namespace swept::datasets {
namespace {

Result<SurfelCloud> build(const Request& request) {
  const double speed = request.number("speed"), spread = request.number("spread") * kPi / 180.0;
  const Eigen::Vector3d gravity(0.0, -request.number("gravity"), 0.0);
  const double life = request.number("life");
  // All discs together cover `cover`, so that more of them are smaller.
  const double radius = std::sqrt(request.number("cover") / (kPi * static_cast<double>(request.points())));

  CloudBuilder builder(request);
  for (std::size_t i = 0; i < request.points(); ++i) {
    const auto random = [&](std::uint64_t stream) { return random_unit(request.seed(), stream + 1, i); };
    const double tilt = spread * std::sqrt(random(0)), phi = 2.0 * kPi * random(1);
    const Eigen::Vector3d aim(std::sin(tilt) * std::cos(phi), std::cos(tilt), std::sin(tilt) * std::sin(phi));
    const double age = life * random(2), push = speed * (0.7 + 0.3 * random(3));
    const Eigen::Vector3d velocity = push * aim + age * gravity;
    const Eigen::Vector3d position = age * push * aim + 0.5 * age * age * gravity;

    // Discs look at +z within 60°, so that few are edge-on.
    const double lean = std::acos(1.0 - 0.5 * random(4)), around = 2.0 * kPi * random(5);
    const Eigen::Vector3d normal(std::sin(lean) * std::cos(around), std::sin(lean) * std::sin(around),
                                 std::cos(lean));
    const Eigen::Vector3d axis_u = normal.unitOrthogonal(), axis_v = normal.cross(axis_u);
    const double size = radius * (0.6 + 0.8 * random(6));
    const double heat = 1.0 - age / life;
    const Eigen::Vector3d color = mix(Eigen::Vector3d(1.6, 0.25, 0.03), Eigen::Vector3d(4.0, 2.6, 1.0), heat);
    builder.add_particle(position, size * axis_u, size * axis_v, velocity, color);
  }
  return builder.take();
}

}  // namespace

Shape sparks_shape() {
  return {"sparks",
          {{"speed", 0.15, 0, 1e3, false, "at the start, object units per frame"},
           {"spread", 25, 0, 180, false, "largest angle from the y axis, degrees"},
           {"gravity", 0.006, 0, 1e3, false, "object units per frame squared"},
           {"life", 24, 1e-3, 1e4, false, "age of the oldest, frames"},
           {"cover", 0.1, 1e-9, 1e4, false, "area of all discs together, object units squared"}},
          build,
          false};
}

}  // namespace swept::datasets
