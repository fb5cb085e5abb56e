// Rectangles: the checkered ground and the box.
#include "datasets/paint.h"
#include "datasets/sampling.h"

namespace swept::datasets {
namespace {

// A square wave of period 2, +1 on [0, 1) and -1 on [1, 2), whose edges are `soft` wide.
double stripes(double x, double soft) {
  const double within = x - 2.0 * std::floor(0.5 * x);
  const double from_edge = 0.5 - std::abs(std::abs(within - 1.0) - 0.5);  // to the nearest whole number
  const double height = std::min(1.0, 2.0 * from_edge / soft);
  return within < 1.0 ? height : -height;
}

// Rows get closer towards +z, where the camera is, so that the points go where the pixels are: density is
// linear in z and at the near edge `grade` times that of the far edge.
Result<SurfelCloud> build_plane(const Request& request) {
  const double width = request.number("width"), depth = request.number("depth");
  const double tile = request.number("tile"), grade = request.number("grade"), fade = request.number("fade");
  const double contrast = request.number("contrast");
  const Eigen::Vector3d middle = mix(srgb(0x8b93a7), srgb(0x2a3145), 0.5);
  const Eigen::Vector3d light = mix(middle, srgb(0x8b93a7), contrast),
                        dark = mix(middle, srgb(0x2a3145), contrast);

  CloudBuilder builder(request);
  builder.add_patch(request.points(), CloudBuilder::Sides::both, [&](double u, double v) {
    // Density 1 + (grade - 1) t over t in [0, 1]; u is its normalised integral, solved for t.
    const double slope = grade - 1.0, half = 1.0 + 0.5 * slope;
    const double root = std::sqrt(1.0 + 2.0 * slope * half * u);
    const double t = 2.0 * half * u / (1.0 + root);
    const double x = width * (v - 0.5), z = depth * (t - 0.5);
    Eigen::Vector3d along_z(0.0, 0.0, depth * half / root), along_x(width, 0.0, 0.0);
    even_out(along_z, along_x);
    // Seen at a shallow angle, so the edges of tiles are softened to what the sampling can hold.
    const double spacing = along_z.norm() / std::sqrt(static_cast<double>(request.points()));
    const double check = stripes(x / tile, spacing / tile) * stripes(z / tile, spacing / tile);
    const double r = std::hypot(2.0 * x / width, 2.0 * z / depth);
    const double shown = 1.0 - fade * smoothstep(0.15, 1.0, r);
    return SurfaceSample{{x, 0.0, z}, along_z, along_x, shown * mix(dark, light, 0.5 + 0.5 * check)};
  });
  return builder.take();
}

Result<SurfelCloud> build_box(const Request& request) {
  const Eigen::Vector3d size(request.number("width"), request.number("height"), request.number("depth"));
  const int checks = request.whole("checks");
  const Eigen::Vector3d light = srgb(0xf3efe2);
  const Eigen::Vector3d dark[3] = {srgb(0x2f6f9f), srgb(0xc8503c), srgb(0x3d8b5f)};

  std::vector<double> areas;
  for (int face = 0; face < 6; ++face) areas.push_back(size[(face / 2 + 1) % 3] * size[(face / 2 + 2) % 3]);
  const std::vector<std::size_t> counts = apportion(request.points(), areas);

  CloudBuilder builder(request);
  for (int face = 0; face < 6; ++face) {
    const int n = face / 2, a = (n + 1) % 3, b = (n + 2) % 3;
    const double sign = face % 2 == 0 ? 1.0 : -1.0;
    builder.add_patch(counts[static_cast<std::size_t>(face)], CloudBuilder::Sides::outer,
                      [&, n, a, b, sign](double u, double v) {
                        Eigen::Vector3d position = Eigen::Vector3d::Zero();
                        position[n] = 0.5 * sign * size[n];
                        position[a] = size[a] * (u - 0.5);
                        position[b] = size[b] * (v - 0.5);
                        Eigen::Vector3d along_u = sign * size[a] * Eigen::Vector3d::Unit(a);
                        Eigen::Vector3d along_v = size[b] * Eigen::Vector3d::Unit(b);
                        even_out(along_u, along_v);
                        const bool checked = ((cell(u * checks, 2) + cell(v * checks, 2)) & 1) == 0;
                        return SurfaceSample{position, along_u, along_v, checked ? light : dark[n]};
                      });
  }
  return builder.take();
}

}  // namespace

Shape plane_shape() {
  return {"plane",
          {{"width", 4, 1e-3, 1e4, false, "along x, object units"},
           {"depth", 4, 1e-3, 1e4, false, "along z, object units"},
           {"tile", 0.5, 1e-4, 1e4, false, "side of a tile, object units"},
           {"grade", 1, 1, 100, false, "density of points at the +z edge over that at the -z edge"},
           {"contrast", 1, 0, 1, false, "between light and dark tiles; 0: one colour"},
           {"fade", 0, 0, 1, false, "how much darker the rim is than the middle"}},
          build_plane};
}

Shape box_shape() {
  return {"box",
          {{"width", 1, 1e-3, 1e3, false, "along x, object units"},
           {"height", 1, 1e-3, 1e3, false, "along y, object units"},
           {"depth", 1, 1e-3, 1e3, false, "along z, object units"},
           {"checks", 4, 1, 1000, true, "tiles along every edge"}},
          build_box};
}

}  // namespace swept::datasets
