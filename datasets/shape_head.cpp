// A head on a neck: the sculpted skull, two eyes, two ears and a bust, each a closed patch.
#include <Eigen/Geometry>

#include "datasets/head_form.h"
#include "datasets/paint.h"
#include "datasets/sampling.h"

namespace swept::datasets {
namespace {

// The unit sphere's chart: position and two unit tangents, south × east = outwards.
struct OnSphere {
  Eigen::Vector3d normal, south, east;
  OnSphere(double u, double v) {
    const double y = 1.0 - 2.0 * u, s = std::sqrt(std::max(0.0, 1.0 - y * y)), phi = 2.0 * kPi * v;
    normal = {s * std::sin(phi), y, s * std::cos(phi)};
    south = {y * std::sin(phi), -s, y * std::cos(phi)};
    east = {std::cos(phi), 0.0, -std::sin(phi)};
  }
};
const double kSphereSide = 2.0 * std::sqrt(kPi);  // of the square with the unit sphere's area

// The form's differential carries the sphere's even discs over to the head: ellipses where it stretches.
template <class Paint>
auto sculpted(const Paint& paint) {
  return [=](double u, double v) {
    const OnSphere at(u, v);
    constexpr double h = 1e-5;
    const auto along = [&](const Eigen::Vector3d& t) -> Eigen::Vector3d {
      return kSphereSide * (head_form(at.normal + h * t) - head_form(at.normal - h * t)) / (2.0 * h);
    };
    return SurfaceSample{head_form(at.normal), along(at.south), along(at.east), paint(at.normal)};
  };
}

template <class Paint>
auto ellipsoid(const Eigen::Vector3d& center, const Eigen::Matrix3d& form, const Paint& paint) {
  return [=](double u, double v) {
    const OnSphere at(u, v);
    return SurfaceSample{center + form * at.normal, kSphereSide * form * at.south,
                         kSphereSide * form * at.east, paint(at.normal)};
  };
}

// Neck and shoulders: a surface of revolution, closed below. `share` runs along the profile.
struct Bust {
  static constexpr double kTop = -0.45, kBottom = -1.55;
  static double radius(double y) {
    const double flare = smoothstep(-0.98, -1.5, y);
    return 0.33 + 0.04 * smoothstep(-0.7, -0.5, y) + 0.34 * flare * flare;
  }
  static SurfaceSample at(double u, double v, const Eigen::Vector3d& skin, const Eigen::Vector3d& shirt) {
    constexpr double h = 1e-5;
    const double y = kTop + (kBottom - kTop) * u, phi = 2.0 * kPi * v, r = radius(y);
    const double slope = (radius(y + h) - radius(y - h)) / (2.0 * h);
    const Eigen::Vector3d around(std::sin(phi), 0.0, std::cos(phi));
    const double forward = -0.08;
    const Eigen::Vector3d position(r * around.x(), y, r * around.z() + forward);
    Eigen::Vector3d down = (kBottom - kTop) * Eigen::Vector3d(slope * around.x(), 1.0, slope * around.z());
    Eigen::Vector3d east = 2.0 * kPi * r * Eigen::Vector3d(std::cos(phi), 0.0, -std::sin(phi));
    even_out(down, east);
    const double collar = -1.0 - 0.18 * smoothstep(0.2, 1.0, around.z());
    const bool rim = y < collar && y > collar - 0.05;
    return {position, down, east, y < collar ? (rim ? Eigen::Vector3d(1.6 * shirt) : shirt) : skin};
  }
  static SurfaceSample bottom(double u, double v, const Eigen::Vector3d& shirt) {
    const double r = radius(kBottom) * std::sqrt(u), phi = 2.0 * kPi * v,
                 side = std::sqrt(kPi) * radius(kBottom);
    const Eigen::Vector3d out(std::sin(phi), 0.0, std::cos(phi)), east(std::cos(phi), 0.0, -std::sin(phi));
    return {{r * out.x(), kBottom, r * out.z() - 0.08}, side * east, side * out, shirt};
  }
};

template <class Chart>
double area_of(const Chart& chart) {
  constexpr int n = 64;
  double sum = 0.0;
  for (int i = 0; i < n * n; ++i) {
    const int row = i / n, column = i % n;
    const SurfaceSample s = chart((row + 0.5) / n, (column + 0.5) / n);
    sum += s.tangent_u.cross(s.tangent_v).norm();
  }
  return sum / (n * n);
}

Result<SurfelCloud> build(const Request& request) {
  const Eigen::Vector3d skin = mix(srgb(0xf3c9a5), srgb(0x6f4427), request.number("skin"));
  const Eigen::Vector3d hair = mix(srgb(0xd9a441), srgb(0x1d130e), request.number("hair"));
  const Eigen::Vector3d shirt = srgb(0x2f6db5);
  const unsigned irises[4] = {0x2f6f9f, 0x3f7d3a, 0x5b3a1a, 0x6a6f78};
  const Eigen::Vector3d iris = srgb(irises[request.whole("eyes")]);

  const auto eye_paint = [=](const Eigen::Vector3d& d) -> Eigen::Vector3d {
    const double off = std::hypot(d.x(), d.y() + 0.04);
    if (d.z() < 0.0 || off > 0.56) return srgb(0xf6f4f0);
    if (std::hypot(d.x() - 0.16, d.y() - 0.16) < 0.1) return srgb(0xffffff);
    if (off < 0.26) return srgb(0x08080a);
    return off > 0.48 ? Eigen::Vector3d(0.3 * iris) : iris;
  };
  const auto skin_paint = [=](const Eigen::Vector3d&) -> Eigen::Vector3d { return 0.92 * skin; };
  const Eigen::Matrix3d eye = 0.125 * Eigen::Matrix3d::Identity();
  const auto ear = [](double side) -> Eigen::Matrix3d {
    return (Eigen::AngleAxisd(side * 0.55, Eigen::Vector3d::UnitY()) *
            Eigen::AngleAxisd(-0.15, Eigen::Vector3d::UnitX()))
               .toRotationMatrix() *
           Eigen::Vector3d(0.055, 0.20, 0.125).asDiagonal();
  };

  const auto head = sculpted([=](const Eigen::Vector3d& d) { return head_color(d, skin, hair); });
  const auto eye_left = ellipsoid({0.215, 0.105, 0.585}, eye, eye_paint);
  const auto eye_right = ellipsoid({-0.215, 0.105, 0.585}, eye, eye_paint);
  const auto ear_left = ellipsoid({0.775, 0.02, -0.03}, ear(-1.0), skin_paint);
  const auto ear_right = ellipsoid({-0.775, 0.02, -0.03}, ear(1.0), skin_paint);
  const auto bust = [=](double u, double v) { return Bust::at(u, v, 0.9 * skin, shirt); };
  const auto bottom = [=](double u, double v) { return Bust::bottom(u, v, shirt); };

  const std::vector<std::size_t> counts =
      apportion(request.points(), {area_of(head), area_of(eye_left), area_of(eye_right), area_of(ear_left),
                                   area_of(ear_right), area_of(bust), area_of(bottom)});
  CloudBuilder builder(request);
  const auto outer = CloudBuilder::Sides::outer;
  builder.add_patch(counts[0], outer, head);
  builder.add_patch(counts[1], outer, eye_left);
  builder.add_patch(counts[2], outer, eye_right);
  builder.add_patch(counts[3], outer, ear_left);
  builder.add_patch(counts[4], outer, ear_right);
  builder.add_patch(counts[5], outer, bust);
  builder.add_patch(counts[6], outer, bottom);
  return builder.take();
}

}  // namespace

Shape head_shape() {
  return {"head",
          {{"skin", 0.1, 0, 1, false, "from light to dark"},
           {"hair", 0.7, 0, 1, false, "from blond to black"},
           {"eyes", 0, 0, 3, true, "blue, green, brown, grey"}},
          build};
}

}  // namespace swept::datasets
