// A ball with a checkered or beach-ball texture.
#include "datasets/paint.h"
#include "datasets/sampling.h"

namespace swept::datasets {
namespace {

Result<SurfelCloud> build(const Request& request) {
  const double radius = request.number("radius");
  const int sectors = request.whole("sectors"), rings = request.whole("rings");
  const Eigen::Vector3d light = srgb(0xf7f3e8);
  const Eigen::Vector3d dark[3] = {srgb(0xd7263d), srgb(0x1b6ca8), srgb(0xf2a71b)};

  CloudBuilder builder(request);
  builder.add_patch(request.points(), CloudBuilder::Sides::outer, [&](double u, double v) {
    const double y = 1.0 - 2.0 * u, s = std::sqrt(std::max(0.0, 1.0 - y * y)), phi = 2.0 * kPi * v;
    const Eigen::Vector3d normal(s * std::sin(phi), y, s * std::cos(phi));
    const Eigen::Vector3d south(y * std::sin(phi), -s, y * std::cos(phi));
    const Eigen::Vector3d east(std::cos(phi), 0.0, -std::sin(phi));
    const double side = 2.0 * std::sqrt(kPi) * radius;  // a unit of (u, v) is the whole area, 4πr²
    const int sector = cell(v * sectors, sectors),
              ring = std::min(rings - 1, int(rings * std::acos(y) / kPi));
    const bool checked = ((sector + ring) & 1) == 0;
    return SurfaceSample{radius * normal, side * south, side * east,
                         checked ? light : dark[(sector / 2) % 3]};
  });
  return builder.take();
}

}  // namespace

Shape sphere_shape() {
  return {"sphere",
          {{"radius", 1, 1e-3, 1e3, false, "object units"},
           {"sectors", 12, 1, 1000, true, "colours around the y axis"},
           {"rings", 6, 1, 1000, true, "bands from pole to pole"}},
          build};
}

}  // namespace swept::datasets
