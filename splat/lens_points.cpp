// Points on the lens: the spiral of Vogel 1979, "A better way to construct the sunflower head": radii of
// equal areas, and the golden angle from one to the next.
#include "splat/lens_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "splat/motion/instant.h"

namespace swept {
namespace {

/// Points for each pixel of the largest circle of confusion: of a moving scene 256 for 18 px are 60 dB, 64
/// are 46 dB.
constexpr double per_px = 8.0;
constexpr int least_chosen = 64, most_chosen = 1024;

/// Of turns, that of the golden angle.
constexpr double golden = 0.38196601125010515;

}  // namespace

Eigen::Vector2d point_on_lens(const Aperture& aperture, double area_share, double turns) {
  const auto on_circle = [&](double of_circle) {
    const double angle = 2.0 * std::numbers::pi * of_circle + aperture.rotation_radians;
    return Eigen::Vector2d(std::cos(angle), std::sin(angle));
  };
  const double radius = aperture.radius * std::sqrt(area_share);
  if (aperture.blades == 0) return radius * on_circle(turns);
  // Evenly along the edges: a triangle from the middle to an edge is filled evenly then.
  const double along = turns * aperture.blades, corner = std::floor(along);
  const Eigen::Vector2d a = on_circle(corner / aperture.blades),
                        b = on_circle((corner + 1) / aperture.blades);
  return radius * (a + (along - corner) * (b - a));
}

std::vector<Eigen::Vector2d> lens_points(const Aperture& aperture, int count) {
  std::vector<Eigen::Vector2d> points;
  if (count == 1) return {Eigen::Vector2d::Zero()};
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    points.push_back(point_on_lens(aperture, (i + 0.5) / count, i * golden - std::floor(i * golden)));
  return points;
}

double circle_of_confusion_px(double aperture, double focal_px, double focus, double z) {
  return aperture * focal_px * std::abs(1.0 / z - 1.0 / focus);
}

int lens_point_count(const Scene& scene) {
  const Aperture& aperture = scene.camera.aperture;
  if (!(aperture.radius > 0.0)) return 1;
  if (aperture.samples > 0) return aperture.samples;
  const Exposure exposure = scene.exposure();
  const CameraInstant camera = scene.camera.at(exposure.middle());
  const Projection projection = projection_of(scene.film, camera);
  double widest = 0.0;
  const auto look = [&](const Eigen::Vector3d& at) {
    if (!(at.z() >= scene.camera.near)) return;
    const double px =
        circle_of_confusion_px(2.0 * aperture.radius, projection.focal_px, camera.lens.focus, at.z());
    const double x = projection.center_x + projection.focal_px * at.x() / at.z();
    const double y = projection.center_y + projection.focal_px * at.y() / at.z();
    // Only what can be seen.
    if (x > -0.5 * px && x < scene.film.width + 0.5 * px && y > -0.5 * px && y < scene.film.height + 0.5 * px)
      widest = std::max(widest, px);
  };
  for (const Object& object : scene.objects) {
    const Instant middle = instant_at(scene, object, exposure, 0.5);
    const SurfelsAt surfels(object.cloud, middle.frame);
    for (std::size_t i = 0; i < object.cloud.size(); ++i) look(middle.to_camera(surfels.position(i)));
    for (std::size_t i = 0; i < object.splats.size(); ++i)
      look(middle.to_camera(object.splats.position_at(i, middle.frame)));
  }
  const double area = 0.25 * std::numbers::pi * widest * widest;
  return static_cast<int>(std::clamp(std::ceil(per_px * area), double{least_chosen}, double{most_chosen}));
}

Status refuse_lens(const Scene& scene, std::string_view renderer) {
  if (!(scene.camera.aperture.radius > 0.0)) return Done{};
  return Error{"", "/camera/lens",
               "the lens blurs what is out of focus, which " + std::string(renderer) + " does not do",
               ErrorKind::unsupported};
}

}  // namespace swept
