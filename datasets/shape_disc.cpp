// Things that spin within their own plane, z = 0, facing +z: the record, the colour wheel and the fan.
#include "datasets/paint.h"
#include "datasets/sampling.h"

namespace swept::datasets {
namespace {

const unsigned kWheel[6] = {0xe63946, 0xf4a236, 0xf7e14c, 0x3fb56b, 0x2a7fd4, 0x8a4fbf};

// A ring sector from angle `from`, `span` radians wide, between radii `hole` and `radius`.
template <class Paint>
auto sector_chart(double hole, double radius, double from, double span, const Paint& paint) {
  return [=](double u, double v) {
    const double r = std::sqrt(hole * hole + u * (radius * radius - hole * hole)), phi = from + span * v;
    const Eigen::Vector3d outwards(std::cos(phi), std::sin(phi), 0.0),
        along(-outwards.y(), outwards.x(), 0.0);
    const double side = std::sqrt(0.5 * span * (radius * radius - hole * hole));
    return SurfaceSample{r * outwards, side * outwards, side * along, paint(r / radius, phi)};
  };
}

Eigen::Vector3d wheel_color(double r, double phi, int sectors, int rings) {
  const int sector = cell(phi / (2.0 * kPi) * sectors, sectors), ring = int(r * rings);
  if (r < 0.12) return srgb(0x20232b);
  return (sector + ring) % 2 == 0 ? srgb(kWheel[(sector / 2) % 6]) : srgb(0xfaf6ea);
}

Eigen::Vector3d record_color(double r, double phi, int sectors, int rings) {
  const double turn = phi / (2.0 * kPi);
  if (r < 0.05) return srgb(0xd8d8d8);
  if (r < 0.36) {
    if (r > 0.33) return srgb(0xf5ead0);
    const bool light = cell(turn * sectors, 2) == 0;
    return light ? srgb(0xf5ead0) : srgb(0xd1342f);
  }
  // The band between tracks, and two glints that stand for the light on the grooves.
  if (cell(r * rings, rings) != cell((r + 0.012) * rings, rings)) return srgb(0x4a4d55);
  const double glint = std::pow(std::abs(std::cos(phi - 0.8)), 40.0);
  return mix(srgb(0x16171b), srgb(0x9aa3b5), glint);
}

Result<SurfelCloud> build_disc(const Request& request) {
  const double radius = request.number("radius"), hole = request.number("hole") * radius;
  const int sectors = request.whole("sectors"), rings = request.whole("rings");
  const bool record = request.whole("record") == 1;
  CloudBuilder builder(request);
  builder.add_patch(request.points(), CloudBuilder::Sides::both,
                    sector_chart(hole, radius, 0.0, 2.0 * kPi, [=](double r, double phi) {
                      return record ? record_color(r, phi, sectors, rings)
                                    : wheel_color(r, phi, sectors, rings);
                    }));
  return builder.take();
}

Result<SurfelCloud> build_fan(const Request& request) {
  const double radius = request.number("radius"), hub = request.number("hub") * radius;
  const int blades = request.whole("blades");
  const double span = 2.0 * kPi * request.number("fill") / blades;

  std::vector<double> areas(static_cast<std::size_t>(blades), 0.5 * span * (radius * radius - hub * hub));
  areas.push_back(kPi * hub * hub);
  const std::vector<std::size_t> counts = apportion(request.points(), areas);

  CloudBuilder builder(request);
  for (int blade = 0; blade < blades; ++blade) {
    const Eigen::Vector3d color = srgb(kWheel[blade % 6]), stripe = srgb(0xfaf6ea);
    const double from = 2.0 * kPi * blade / blades - 0.5 * span;
    builder.add_patch(counts[static_cast<std::size_t>(blade)], CloudBuilder::Sides::both,
                      sector_chart(hub, radius, from, span,
                                   [=](double r, double) { return r > 0.8 && r < 0.9 ? stripe : color; }));
  }
  builder.add_patch(counts.back(), CloudBuilder::Sides::both,
                    sector_chart(0.0, hub, 0.0, 2.0 * kPi,
                                 [](double r, double) { return srgb(r < 0.4 ? 0xd8d8d8 : 0x30343d); }));
  return builder.take();
}

}  // namespace

Shape disc_shape() {
  return {"disc",
          {{"radius", 1, 1e-3, 1e3, false, "object units"},
           {"hole", 0, 0, 0.95, false, "radius of the hole, as a share of the radius"},
           {"sectors", 12, 1, 1000, true, "sectors of the wheel, or of the record's label"},
           {"rings", 1, 1, 1000, true, "rings of the wheel, or tracks of the record"},
           {"record", 0, 0, 1, true, "0: a colour wheel; 1: a gramophone record"}},
          build_disc};
}

Shape fan_shape() {
  return {"fan",
          {{"radius", 1, 1e-3, 1e3, false, "object units"},
           {"hub", 0.15, 0.01, 0.9, false, "radius of the hub, as a share of the radius"},
           {"blades", 3, 1, 1000, true, "blades, evenly spread; the first points to +x"},
           {"fill", 0.4, 0.001, 1, false, "share of the circle that is blade"}},
          build_fan};
}

}  // namespace swept::datasets
