#include "abuffer/mesh_layers.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "abuffer/sources/placed_triangle.h"

namespace swept {
namespace {

/// From object to world space, of normals, but for their length: the cofactors turn them as the matrix turns
/// what they are normal to.
Eigen::Matrix3d cofactors(const Eigen::Matrix3d& m) {
  Eigen::Matrix3d cofactors;
  for (int i = 0; i < 3; ++i) cofactors.col(i) = m.col((i + 1) % 3).cross(m.col((i + 2) % 3));
  return cofactors;
}

}  // namespace

MeshLayers::MeshLayers(const Scene& scene, const Object& object, const Instants& instants,
                       const Projection& film, Choice choice)
    : mesh_(scene, object, instants.middle.frame),
      film_(film),
      near_(scene.camera.near),
      choice_(choice),
      eye_(instants.middle.eye),
      along_(instants.middle.camera_from_world.row(2)),
      frames_forward_(instants.close.frame - instants.middle.frame),
      frames_backward_(instants.middle.frame - instants.open.frame),
      points_(object.cloud.size()) {
  boxes_.reserve(object.triangles.size());
  for (std::size_t t = 0; t < object.triangles.size(); ++t) boxes_.push_back(mesh_.box(t));
  const Eigen::Matrix3d turn = cofactors(instants.middle.world_from_object.linear());
  const auto for_all = [&](double frame, const auto& visit) {
    const SurfelsAt at(object.cloud, frame);
    for (std::size_t i = 0; i < points_.size(); ++i) visit(points_[i], at[i]);
  };
  if (choice_.normals)
    for_all(instants.middle.frame, [&](Point& point, const SurfelInstant& at) {
      point.world = instants.middle.world_from_object * at.position;
      const Eigen::Vector3d own = at.axis_u.stableNormalized().cross(at.axis_v.stableNormalized());
      point.normal = (turn * own.stableNormalized()).stableNormalized();
    });
  if (!choice_.motion) return;
  const auto place = [&](const Instant& instant, Eigen::Vector3d Point::*to) {
    for_all(instant.frame,
            [&](Point& point, const SurfelInstant& at) { point.*to = instant.to_camera(at.position); });
  };
  place(instants.open, &Point::open);
  place(instants.middle, &Point::middle);
  place(instants.close, &Point::close);
}

void MeshLayers::draw(const FilmBand& band, std::vector<MeshFront>& front) const {
  const MeshMath& math = mesh_maths().first[0];
  std::vector<NearestPlaces> nearest;
  std::vector<Drawn> drawn;
  const auto pixels = static_cast<std::size_t>(band.width) * static_cast<std::size_t>(band.height);
  for (std::size_t t = 0; t < boxes_.size(); ++t) {
    const std::optional<FilmBox>& box = boxes_[t];
    if (!box || box->y_max + 2.0 < band.y || box->y_min - 2.0 > band.y + band.height) continue;
    // Places lie up to half a pixel from the centre; the rest takes care of rounding.
    const auto pixel = [](double v, int begin, int end) {
      return static_cast<int>(std::clamp<double>(std::floor(v), begin, end));
    };
    const int x_end = pixel(box->x_max + 2.0, band.x, band.x + band.width),
              y_end = pixel(box->y_max + 2.0, band.y, band.y + band.height),
              x_begin = pixel(box->x_min - 1.0, band.x, x_end),
              y_begin = pixel(box->y_min - 1.0, band.y, y_end);
    if (x_begin == x_end || y_begin == y_end) continue;
    const std::optional<PlacedTriangle> placed = place_triangle(mesh_, t);
    if (!placed) continue;
    nearest.resize(pixels);
    const Linear& depth = placed->inverse_depth;
    for (int y = y_begin; y < y_end; ++y)
      for (int x = x_begin; x < x_end; ++x) {
        const std::uint32_t mask = math.inside(*placed, x + 0.5, y + 0.5);
        if (mask == 0) continue;
        NearestPlaces& places =
            nearest[static_cast<std::size_t>(y - band.y) * static_cast<std::size_t>(band.width) +
                    static_cast<std::size_t>(x - band.x)];
        for (std::size_t k = 0; k < pixel_places; ++k) {
          if ((mask >> k & 1) == 0) continue;
          const auto w = static_cast<float>(
              depth.at(x + 0.5 + double{places_in_pixel.x[k]}, y + 0.5 + double{places_in_pixel.y[k]}));
          if (!(w > places.inverse_depth[k])) continue;
          places.inverse_depth[k] = w;
          places.triangle[k] = static_cast<std::uint32_t>(drawn.size());
        }
      }
    drawn.push_back({*placed, static_cast<std::uint32_t>(t)});
  }
  for (std::size_t p = 0; p < nearest.size(); ++p) {
    const NearestPlaces& places = nearest[p];
    MeshFront sum;
    for (std::size_t k = 0; k < pixel_places; ++k)
      if (places.inverse_depth[k] > 0.0f) {
        ++sum.places;
        sum.depth += double{mesh_.depth_of(places.inverse_depth[k])};
      }
    if (sum.places == 0 || (front[p].places > 0 && !(sum.mean_depth() < front[p].mean_depth()))) continue;
    const double x = band.x + static_cast<int>(p % static_cast<std::size_t>(band.width)) + 0.5,
                 y = band.y + static_cast<int>(p / static_cast<std::size_t>(band.width)) + 0.5;
    for (std::size_t k = 0; k < pixel_places && (choice_.normals || choice_.motion); ++k)
      if (places.inverse_depth[k] > 0.0f)
        add(drawn[places.triangle[k]], x + double{places_in_pixel.x[k]}, y + double{places_in_pixel.y[k]},
            sum);
    front[p] = sum;
  }
}

/// Adds what a ray shows of a triangle.
void MeshLayers::add(const Drawn& drawn, double x, double y, MeshFront& sum) const {
  Eigen::Vector3d share;
  for (int i = 0; i < 3; ++i) {
    const auto corner = static_cast<std::size_t>(i);
    // What rounding puts outside lies on the edge.
    share[i] = std::max(0.0, drawn.placed.edge[corner].at(x, y)) * double{drawn.placed.weight[corner]};
  }
  if (!(share.sum() > 0.0)) share = {1.0, 0.0, 0.0};
  share /= share.sum();
  const Triangle& triangle = mesh_.object().triangles[drawn.triangle];
  if (choice_.normals) sum.normal += normal_at(triangle, share);
  if (!choice_.motion) return;
  const auto on_film = [&](Eigen::Vector3d Point::*where) -> std::optional<Eigen::Vector2d> {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) p += share[i] * (points_[triangle[static_cast<std::size_t>(i)]].*where);
    if (!(p.z() >= near_)) return std::nullopt;
    const double divisor = film_.divisor(p.z());
    return Eigen::Vector2d(film_.focal_px * p.x() / divisor, -film_.focal_px * p.y() / divisor);
  };
  const auto from = on_film(&Point::middle);
  const auto vector = [&](Eigen::Vector3d Point::*end, double frames) -> Eigen::Vector2d {
    const auto to = on_film(end);
    if (!from || !to) return Eigen::Vector2d::Zero();
    const Eigen::Vector2d way = (*to - *from) / frames;
    return way.allFinite() ? way : Eigen::Vector2d(Eigen::Vector2d::Zero());
  };
  sum.forward += vector(&Point::close, frames_forward_);
  sum.backward += vector(&Point::open, frames_backward_);
}

Eigen::Vector3d MeshLayers::normal_at(const Triangle& triangle, const Eigen::Vector3d& share) const {
  const Point &a = points_[triangle[0]], &b = points_[triangle[1]], &c = points_[triangle[2]];
  Eigen::Vector3d face = (b.world - a.world).stableNormalized().cross((c.world - a.world).stableNormalized());
  const Eigen::Vector3d ray = film_.orthographic ? along_ : Eigen::Vector3d(a.world - eye_);
  if (face.dot(ray) > 0.0) face = -face;
  const Eigen::Vector3d mixed = share[0] * a.normal + share[1] * b.normal + share[2] * c.normal;
  if (mixed.isZero(0.0)) return face.stableNormalized();
  const Eigen::Vector3d normal = mixed.stableNormalized();
  return normal.dot(face) < 0.0 ? Eigen::Vector3d(-normal) : normal;
}

}  // namespace swept
