// A ribbon along x that waves and twists.
#include <Eigen/Geometry>

#include "datasets/paint.h"
#include "datasets/sampling.h"

namespace swept::datasets {
namespace {

Result<SurfelCloud> build(const Request& request) {
  const double length = request.number("length"), width = request.number("width");
  const double wave = request.number("wave"), twist = 2.0 * kPi * request.number("twists");
  const int stripes = request.whole("stripes");
  const Eigen::Vector3d light = srgb(0xfff3d6), dark = srgb(0xd81e5b), edge = srgb(0xffc145);

  CloudBuilder builder(request);
  builder.add_patch(request.points(), CloudBuilder::Sides::both, [&](double u, double v) {
    // One and a half waves; the cross direction turns about the spine's tangent from the z axis.
    const double k = 3.0 * kPi, w = width * (v - 0.5);
    const double slope = wave * k / length * std::cos(k * u), bend = -wave * k * k / length * std::sin(k * u);
    const Eigen::Vector3d center(length * (u - 0.5), wave * std::sin(k * u), 0.0);
    const double speed = std::sqrt(1.0 + slope * slope);
    const Eigen::Vector3d tangent(1.0 / speed, slope / speed, 0.0), normal(-tangent.y(), tangent.x(), 0.0);
    const double angle = twist * u, turning = bend / (speed * speed);  // of the tangent, per unit of u
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d across = std::cos(angle) * z + std::sin(angle) * normal;
    // d normal/du = -turning · tangent
    const Eigen::Vector3d across_du =
        twist * (std::cos(angle) * normal - std::sin(angle) * z) - std::sin(angle) * turning * tangent;
    Eigen::Vector3d along = length * speed * tangent + w * across_du, cross = width * across;
    even_out(along, cross);
    const bool rim = std::abs(v - 0.5) > 0.4;
    return SurfaceSample{center + w * across, along, cross,
                         rim ? edge : (cell(u * stripes, 2) == 0 ? light : dark)};
  });
  return builder.take();
}

}  // namespace

Shape ribbon_shape() {
  return {"ribbon",
          {{"length", 3, 1e-3, 1e3, false, "along x, object units"},
           {"width", 0.3, 1e-3, 1e3, false, "object units"},
           {"wave", 0.2, 0, 10, false, "height of the waves, object units"},
           {"twists", 1, -20, 20, false, "turns about its own length"},
           {"stripes", 40, 1, 10000, true, "stripes across"}},
          build};
}

}  // namespace swept::datasets
