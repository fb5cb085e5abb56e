#include "abuffer/sources/object_instant.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <Eigen/SVD>

namespace swept {
namespace {

/// As the reference has it: beyond it a disc touches the frame with its rim only, if at all.
constexpr double guard_band = 1.3;

PacketBounds whole_plane(double nearest) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {-infinity, infinity, -infinity, infinity, nearest};
}

/// The whole pixels whose centres may lie in [low, high], within ±2²⁰.
void pixel_range(double low, double high, int& begin, int& end) {
  constexpr double most = 1 << 20;
  begin = static_cast<int>(std::clamp(std::ceil(low - 0.5), -most, most));
  end = static_cast<int>(std::clamp(std::floor(high - 0.5) + 1.0, -most, most));
}

}  // namespace

ObjectInstant::ObjectInstant(const Scene& scene, const PointPackets& packets, double frame)
    : instant(instant_at(scene, *packets.object, {frame, frame}, 0.0)),
      projection(projection_of(scene.film, scene.camera.at(frame))) {
  const Eigen::Matrix3d linear = instant.camera_from_world * instant.world_from_object.linear();
  for (int i = 0; i < 9; ++i) place.linear[i] = static_cast<float>(linear(i / 3, i % 3));
  place.mirrored = linear.determinant() < 0.0 ? -1.0f : 1.0f;
  place.one_sided = !packets.object->two_sided;
  place.focal_px = static_cast<float>(projection.focal_px);
  place.near = static_cast<float>(scene.camera.near);
  place.filter_px = static_cast<float>(scene.model.filter_radius_px);
  place.max_tangent_x = static_cast<float>(guard_band * largest_tangent(scene.film, projection, 0));
  place.max_tangent_y = static_cast<float>(guard_band * largest_tangent(scene.film, projection, 1));
  place.depth_tolerance = static_cast<float>(scene.model.depth_tolerance);
  place.film_width = scene.film.width;
  place.film_height = scene.film.height;
  place.orthographic = projection.orthographic;
  enlarges = linear.allFinite() ? linear.jacobiSvd().singularValues()[0] * (1.0 + 1e-9)
                                : std::numeric_limits<double>::infinity();
  if (scene.camera.aperture.radius > 0.0) {
    lens_px = scene.camera.aperture.radius * projection.focal_px;
    per_focus = 1.0 / scene.camera.at(frame).lens.focus;
  }
  if (!packets.looks.empty()) look = look_place(packets.looks, frame);
  const auto after = std::upper_bound(packets.frames.begin(), packets.frames.end(), frame);
  const std::size_t stretch =
      after == packets.frames.begin() ? 0 : static_cast<std::size_t>(after - packets.frames.begin()) - 1;
  pose = stretch * packets.degree;
  if (packets.spins) surfels.emplace(packets.object->cloud, frame);
  if (stretch + 1 == packets.frames.size()) return;
  const double first = packets.frames[stretch], last = packets.frames[stretch + 1];
  blend = std::clamp((frame - first) / (last - first), 0.0, 1.0);
  if (packets.degree == 1) return;
  bernstein.assign(packets.degree + 1, 0.0);
  bernstein[0] = 1.0;
  for (std::size_t level = 0; level < packets.degree; ++level)
    for (std::size_t k = level + 2; k-- > 0;)
      bernstein[k] = (1.0 - blend) * bernstein[k] + (k > 0 ? blend * bernstein[k - 1] : 0.0);
  bernstein.erase(bernstein.begin());
}

Eigen::Vector3d ObjectInstant::center(const PointPackets& packets, std::size_t p) const {
  const Eigen::Vector3d& origin = packets.origins[pose][p];
  if (!(blend > 0.0)) return instant.to_camera(origin);
  if (packets.degree == 1) return instant.to_camera(origin + blend * (packets.origins[pose + 1][p] - origin));
  Eigen::Vector3d sum = origin;
  for (std::size_t k = 1; k <= packets.degree; ++k)
    sum += bernstein[k - 1] * (packets.origins[pose + k][p] - origin);
  return instant.to_camera(sum);
}

PacketBounds ObjectInstant::bounds(const Eigen::Vector3d& center, double radius) const {
  const double near = double{place.near}, reach = radius * enlarges;
  const double low = center.z() - reach, high = center.z() + reach;
  if (high < near) return {0.0, -1.0, 0.0, -1.0, high};
  if (!(low > near || projection.orthographic) || !center.allFinite())
    return whole_plane(std::max(near, low));  // near where low is not a number
  // In front of the near plane x/z is monotonic in x and in z. The filter widens a disc by its radius where
  // the disc's centre is, which perspective enlarges towards the eye.
  double margin = double{place.filter_px} * high / low + 1.0;
  // Through the lens each point is spread by half its circle of confusion.
  if (lens_px > 0.0)
    margin += lens_px * std::max(std::abs(1.0 / low - per_focus), std::abs(1.0 / high - per_focus));
  const double focal = projection.focal_px;
  if (projection.orthographic) {
    const double across = focal * reach + double{place.filter_px} + 1.0;
    const double x = projection.center_x + focal * center.x(), y = projection.center_y + focal * center.y();
    return {x - across, x + across, y - across, y + across, low};
  }
  const auto least = [&](double v) { return v - reach >= 0.0 ? (v - reach) / high : (v - reach) / low; };
  const auto most = [&](double v) { return v + reach >= 0.0 ? (v + reach) / low : (v + reach) / high; };
  return {projection.center_x + focal * least(center.x()) - margin,
          projection.center_x + focal * most(center.x()) + margin,
          projection.center_y + focal * least(center.y()) - margin,
          projection.center_y + focal * most(center.y()) + margin, low};
}

PacketPlace ObjectInstant::on_film(const Eigen::Vector3d& center) const {
  const double divisor = projection.divisor(center.z());
  const double tangent_x = center.x() / divisor, tangent_y = center.y() / divisor;
  // Far off the film every lane takes the general form; a whole number there need only exist.
  const auto whole = [](double v) { return std::abs(v) <= 1e9 ? std::floor(v) : 1e9; };
  const double x = projection.center_x + projection.focal_px * tangent_x, whole_x = whole(x);
  const double y = projection.center_y + projection.focal_px * tangent_y, whole_y = whole(y);
  return {static_cast<float>(center.z()), static_cast<float>(tangent_x), static_cast<float>(tangent_y),
          static_cast<int>(whole_x),      static_cast<int>(whole_y),     static_cast<float>(x - whole_x),
          static_cast<float>(y - whole_y)};
}

std::optional<GeneralDisc> GeneralDisc::make(const Scene& scene, const Object& object,
                                             const ObjectInstant& at, std::uint32_t point) {
  if (!object.cloud.exists(point, at.instant.frame)) return std::nullopt;
  const SurfelInstant surfel = surfel_at(object.cloud, point, at.instant.frame);
  const Eigen::Vector3d axis_u = at.instant.to_camera_direction(surfel.axis_u);
  const Eigen::Vector3d axis_v = at.instant.to_camera_direction(surfel.axis_v);
  const Projection& projection = at.projection;
  const PixelFilter filter{scene.model.filter_radius_px / projection.focal_px,
                           guard_band * largest_tangent(scene.film, projection, 0),
                           guard_band * largest_tangent(scene.film, projection, 1), scene.camera.near,
                           projection.orthographic};
  MovingKernel kernel;
  kernel.center = at.instant.to_camera(surfel.position);
  kernel.velocity.setZero();
  const FilteredDisc disc = filter_disc(kernel.center, axis_u, axis_v, filter);
  kernel.axis_u = disc.axis_u.cast<float>();
  kernel.axis_v = disc.axis_v.cast<float>();
  kernel.weight = static_cast<float>(disc.weight);
  kernel.depth_tolerance = static_cast<float>(scene.model.depth_tolerance * disc.size);
  kernel.facing.setZero();
  const Eigen::Vector3f outside =
      (double{at.place.mirrored} * axis_u.cross(axis_v).stableNormalized()).cast<float>();
  if (!object.two_sided) kernel.facing = outside;
  if (object.cloud.is_oriented(point)) kernel.outside = outside;
  constexpr float largest = 1e30f;
  if (!(kernel.weight > 0.0f) || !kernel.center.allFinite() || !kernel.axis_u.allFinite() ||
      !kernel.axis_v.allFinite() || !(kernel.depth_tolerance <= largest))
    return std::nullopt;
  Octagon octagon;
  if (!screen_bounds(kernel, projection, scene.camera.near, octagon)) return std::nullopt;
  GeneralDisc general(kernel, projection.orthographic);
  const PixelBox box = octagon.box();
  pixel_range(box.x_min, box.x_max, general.x_begin, general.x_end);
  pixel_range(box.y_min, box.y_max, general.y_begin, general.y_end);
  general.tolerance = kernel.depth_tolerance;
  const Eigen::Vector4f rgba = LooksAt(object.cloud, at.instant.frame)[point];
  for (int c = 0; c < 4; ++c) general.rgba[c] = rgba[c];
  general.projection_ = projection;
  general.near_ = scene.camera.near;
  general.delta_ = scene.model.delta;
  return general;
}

std::optional<GeneralDisc::Fragment> GeneralDisc::meet(int x, int y) const {
  const double ray_x = (x + 0.5 - projection_.center_x) / projection_.focal_px;
  const double ray_y = (y + 0.5 - projection_.center_y) / projection_.focal_px;
  if (!plane_.faces(ray_x, ray_y)) return std::nullopt;
  const RayCoordinates<double> at = plane_.along(ray_x, ray_y);
  const double radius_squared = at.u * at.u + at.v * at.v;
  constexpr double largest = 1e30;
  if (!(radius_squared <= 1.0) || !(at.z >= near_) || !(at.z <= largest)) return std::nullopt;
  const auto weight = static_cast<float>(weight_ * std::exp(-delta_ * radius_squared));
  if (!(weight > 0.0f)) return std::nullopt;
  const float side = !plane_.oriented() ? 0.0f : plane_.shows_back(ray_x, ray_y) ? -1.0f : 1.0f;
  return Fragment{static_cast<float>(at.z), weight, side};
}

}  // namespace swept
