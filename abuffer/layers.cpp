// Two passes over the discs at one instant, as splatting does it: the first finds the nearest of each pixel,
// the second adds up what is within its tolerance (model section 1, front surface).
#include "abuffer/layers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "abuffer/mesh_layers.h"
#include "abuffer/parallel.h"
#include "abuffer/render_valid.h"
#include "splat/kernel/ray_kernel.h"
#include "splat/kernel/screen_bounds.h"
#include "splat/motion/instant.h"
#include "splat/overscan.h"

namespace swept {
namespace {

constexpr int band_height = 32;  // px

/// An object at the middle of the exposure, and at both ends.
struct Placed {
  const Object* object;
  Instant open, middle, close;
  Eigen::Matrix3d world_normals;  ///< from object space, but for the length
  double side;                    ///< −1: mirrored
};

/// A disc as its pixels see it.
struct SeenDisc {
  KernelPlane<double> plane;
  double weight, tolerance;
  int x_begin, x_end, y_begin, y_end;  ///< px of the film
};

struct Pixel {
  double depth = std::numeric_limits<double>::infinity(), tolerance = 0.0;  ///< of the nearest
  int side = 0;  ///< likewise: 1 front, −1 back, 0 not known
  double weight = 0.0, weighted_depth = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Vector2d forward = Eigen::Vector2d::Zero(), backward = Eigen::Vector2d::Zero();
};

/// The exposure whose ends the vectors lead to.
Exposure exposure_of_vectors(const Scene& scene) {
  Exposure exposure = scene.exposure();
  constexpr double instant = 0x1p-11;  // frames
  if (exposure.instant()) exposure = {exposure.open - instant, exposure.close + instant};
  return exposure;
}

class LayerRenderer {
 public:
  LayerRenderer(const Scene& scene, const LayerChoice& choice)
      : scene_(scene),
        choice_(choice),
        window_(blank_image(scene.film)),
        exposure_(exposure_of_vectors(scene)),
        film_(projection_of(scene.film, scene.camera.at(exposure_.middle()))),
        filter_{scene.model.filter_radius_px / film_.focal_px, 1.3 * largest_tangent(scene.film, film_, 0),
                1.3 * largest_tangent(scene.film, film_, 1), scene.camera.near, film_.orthographic},
        bands_(static_cast<std::size_t>((window_.height + band_height - 1) / band_height)) {
    for (const Object& object : scene.objects) {
      const Instant middle = instant_at(scene, object, exposure_, 0.5);
      const Eigen::Matrix3d linear = middle.world_from_object.linear();
      // The cofactors turn normals as the matrix turns what they are normal to, mirrors and all.
      Eigen::Matrix3d cofactors;
      for (int i = 0; i < 3; ++i) cofactors.col(i) = linear.col((i + 1) % 3).cross(linear.col((i + 2) % 3));
      placed_.push_back({&object, instant_at(scene, object, exposure_, 0.0), middle,
                         instant_at(scene, object, exposure_, 1.0), cofactors,
                         linear.determinant() < 0.0 ? -1.0 : 1.0});
      if (!object.triangles.empty())
        meshes_.emplace_back(scene, object,
                             MeshLayers::Instants{placed_.back().open, middle, placed_.back().close}, film_,
                             MeshLayers::Choice{choice.normal, choice.motion});
    }
  }

  std::vector<ImageChannel> render(const std::stop_token& stop) {
    bin();
    name_channels();
    parallel_for_each_index(bands_.size(), [&](std::size_t index) {
      throw_if_stopped(stop);
      const int y = static_cast<int>(index) * band_height;
      Band band{window_.y + y, std::min(band_height, window_.height - y), {}};
      band.pixels.resize(static_cast<std::size_t>(band.height) * static_cast<std::size_t>(window_.width));
      for (const Ref& ref : bands_[index]) find_nearest(ref, band);
      for (const Ref& ref : bands_[index]) add(ref, band);
      std::vector<MeshFront> meshes;
      if (!meshes_.empty()) meshes.resize(band.pixels.size());
      for (const MeshLayers& mesh : meshes_) {
        throw_if_stopped(stop);
        mesh.draw({window_.x, band.y, window_.width, band.height}, meshes);
      }
      store(band, meshes);
    });
    return std::move(channels_);
  }

 private:
  struct Ref {
    std::uint32_t object, point;
  };
  struct Band {
    int y, height;  ///< px of the film
    std::vector<Pixel> pixels;
  };

  [[nodiscard]] std::optional<SeenDisc> disc_of(const Ref& ref) const {
    const Placed& placed = placed_[ref.object];
    if (!placed.object->cloud.exists(ref.point, placed.middle.frame)) return std::nullopt;
    const SurfelInstant surfel = surfel_at(placed.object->cloud, ref.point, placed.middle.frame);
    const Eigen::Vector3d axis_u = placed.middle.to_camera_direction(surfel.axis_u);
    const Eigen::Vector3d axis_v = placed.middle.to_camera_direction(surfel.axis_v);
    MovingKernel kernel;
    kernel.center = placed.middle.to_camera(surfel.position);
    kernel.velocity.setZero();
    const FilteredDisc disc = filter_disc(kernel.center, axis_u, axis_v, filter_);
    kernel.axis_u = disc.axis_u.cast<float>();
    kernel.axis_v = disc.axis_v.cast<float>();
    kernel.facing.setZero();
    const Eigen::Vector3f outside = (placed.side * axis_u.cross(axis_v).stableNormalized()).cast<float>();
    if (!placed.object->two_sided) kernel.facing = outside;
    if (placed.object->cloud.is_oriented(ref.point)) kernel.outside = outside;
    const double tolerance = scene_.model.depth_tolerance * disc.size;
    constexpr double largest = 1e30;
    Octagon octagon;
    if (!(static_cast<float>(disc.weight) > 0.0f) || !kernel.center.allFinite() ||
        !kernel.axis_u.allFinite() || !kernel.axis_v.allFinite() || !(tolerance <= largest) ||
        !screen_bounds(kernel, film_, scene_.camera.near, octagon))
      return std::nullopt;
    const PixelBox box = octagon.box();
    const auto whole = [](double v, int low, int high) {
      return static_cast<int>(std::clamp(v, static_cast<double>(low), static_cast<double>(high)));
    };
    const int right = window_.x + window_.width, bottom = window_.y + window_.height;
    return SeenDisc{KernelPlane<double>(kernel, film_.orthographic),
                    disc.weight,
                    tolerance,
                    whole(std::ceil(box.x_min - 0.5), window_.x, right),
                    whole(std::floor(box.x_max - 0.5) + 1.0, window_.x, right),
                    whole(std::ceil(box.y_min - 0.5), window_.y, bottom),
                    whole(std::floor(box.y_max - 0.5) + 1.0, window_.y, bottom)};
  }

  /// Points into the bands that they may be seen in, in their own order.
  void bin() {
    constexpr std::size_t run = 4096;
    for (std::uint32_t object = 0; object < placed_.size(); ++object) {
      const std::size_t points = placed_[object].object->discs(), runs = (points + run - 1) / run;
      // By run, first and last band of each point; last < first: not seen.
      std::vector<std::vector<std::pair<int, int>>> found(runs);
      parallel_for_each_index(runs, [&](std::size_t r) {
        for (std::size_t p = r * run; p < std::min(points, (r + 1) * run); ++p) {
          const auto disc = disc_of({object, static_cast<std::uint32_t>(p)});
          const bool seen = disc && disc->x_begin < disc->x_end && disc->y_begin < disc->y_end;
          found[r].emplace_back(seen ? (disc->y_begin - window_.y) / band_height : 0,
                                seen ? (disc->y_end - 1 - window_.y) / band_height : -1);
        }
      });
      std::uint32_t point = 0;
      for (const auto& rows : found)
        for (const auto& [first, last] : rows) {
          for (int band = first; band <= last; ++band)
            bands_[static_cast<std::size_t>(band)].push_back({object, point});
          ++point;
        }
    }
  }

  /// Calls visit(pixel, disc, point in camera space, side that is seen, weight) where the disc of `ref` is
  /// met in the band.
  template <class Visit>
  void meet(const Ref& ref, Band& band, const Visit& visit) const {
    const auto disc = disc_of(ref);
    if (!disc) return;
    for (int y = std::max(disc->y_begin, band.y); y < std::min(disc->y_end, band.y + band.height); ++y)
      for (int x = disc->x_begin; x < disc->x_end; ++x) {
        const double ray_x = (x + 0.5 - film_.center_x) / film_.focal_px;
        const double ray_y = (y + 0.5 - film_.center_y) / film_.focal_px;
        if (!disc->plane.faces(ray_x, ray_y)) continue;
        const RayCoordinates<double> at = disc->plane.along(ray_x, ray_y);
        const double radius_squared = at.u * at.u + at.v * at.v;
        if (!(radius_squared <= 1.0) || !(at.z >= scene_.camera.near) || !std::isfinite(at.z)) continue;
        const double weight = disc->weight * std::exp(-scene_.model.delta * radius_squared);
        if (!(weight > 0.0)) continue;
        const auto pixel = static_cast<std::size_t>(y - band.y) * static_cast<std::size_t>(window_.width) +
                           static_cast<std::size_t>(x - window_.x);
        const int side = !disc->plane.oriented() ? 0 : disc->plane.shows_back(ray_x, ray_y) ? -1 : 1;
        const double across = film_.orthographic ? 1.0 : at.z;
        visit(band.pixels[pixel], *disc, Eigen::Vector3d(across * ray_x, across * ray_y, at.z), side, weight);
      }
  }

  void find_nearest(const Ref& ref, Band& band) const {
    meet(ref, band, [](Pixel& pixel, const SeenDisc& disc, const Eigen::Vector3d& at, int side, double) {
      // Of equally near ones the front leads, and of these the most tolerant.
      if (at.z() > pixel.depth) return;
      if (at.z() == pixel.depth &&
          (side < pixel.side || (side == pixel.side && disc.tolerance <= pixel.tolerance)))
        return;
      pixel.depth = at.z();
      pixel.tolerance = disc.tolerance;
      pixel.side = side;
    });
  }

  /// Where `p`, camera space, is on the unfiltered disc at the middle of the exposure: (u, v), at most 1
  /// long.
  [[nodiscard]] Eigen::Vector2d place_on_disc(const Placed& placed, const Ref& ref,
                                              const Eigen::Vector3d& p) const {
    const SurfelInstant surfel = surfel_at(placed.object->cloud, ref.point, placed.middle.frame);
    const Eigen::Vector3d axis_u = placed.middle.to_camera_direction(surfel.axis_u);
    const Eigen::Vector3d axis_v = placed.middle.to_camera_direction(surfel.axis_v);
    const Eigen::Vector3d normal = axis_u.cross(axis_v);
    const Eigen::Vector3d from = p - placed.middle.to_camera(surfel.position);
    const Eigen::Vector2d uv =
        Eigen::Vector2d(axis_v.cross(normal).dot(from), normal.cross(axis_u).dot(from)) /
        normal.squaredNorm();
    if (!uv.allFinite()) return Eigen::Vector2d::Zero();
    return uv / std::max(1.0, uv.norm());
  }

  /// From the middle to `end`, px per frame, of the place (u, v) of a disc.
  [[nodiscard]] Eigen::Vector2d vector_to(const Instant& end, const Placed& placed, const Ref& ref,
                                          const Eigen::Vector2d& uv) const {
    const auto on_film = [&](const Instant& instant) -> std::optional<Eigen::Vector2d> {
      const SurfelInstant surfel = surfel_at(placed.object->cloud, ref.point, instant.frame);
      const Eigen::Vector3d p =
          instant.to_camera(surfel.position + (uv[0] * surfel.axis_u + uv[1] * surfel.axis_v));
      if (!(p.z() >= scene_.camera.near)) return std::nullopt;
      const double divisor = film_.divisor(p.z());
      return Eigen::Vector2d(film_.focal_px * p.x() / divisor, -film_.focal_px * p.y() / divisor);
    };
    const auto from = on_film(placed.middle), to = on_film(end);
    if (!from || !to) return Eigen::Vector2d::Zero();
    const Eigen::Vector2d vector = (*to - *from) / std::abs(end.frame - placed.middle.frame);
    return vector.allFinite() ? vector : Eigen::Vector2d::Zero();
  }

  void add(const Ref& ref, Band& band) const {
    const Placed& placed = placed_[ref.object];
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    if (choice_.normal) {
      const SurfelInstant surfel = surfel_at(placed.object->cloud, ref.point, placed.middle.frame);
      const Eigen::Vector3d own = surfel.axis_u.cross(surfel.axis_v).stableNormalized();
      normal = (placed.world_normals * own).stableNormalized();
      const Eigen::Vector3d from_eye = placed.middle.world_from_object * surfel.position - placed.middle.eye;
      const Eigen::Vector3d ray =
          film_.orthographic ? Eigen::Vector3d(placed.middle.camera_from_world.row(2)) : from_eye;
      if (normal.dot(ray) > 0.0) normal = -normal;
    }
    meet(ref, band, [&](Pixel& pixel, const SeenDisc&, const Eigen::Vector3d& at, int side, double weight) {
      if (at.z() > pixel.depth + pixel.tolerance || side * pixel.side < 0) return;
      pixel.weight += weight;
      pixel.weighted_depth += weight * at.z();
      pixel.normal += weight * normal;
      if (!choice_.motion) return;
      const Eigen::Vector2d uv = place_on_disc(placed, ref, at);
      pixel.forward += weight * vector_to(placed.close, placed, ref, uv);
      pixel.backward += weight * vector_to(placed.open, placed, ref, uv);
    });
  }

  void name_channels() {
    const auto name = [&](bool wanted, std::initializer_list<const char*> names) {
      for (const char* channel : names)
        if (wanted) channels_.push_back({channel, std::vector<float>(window_.pixel_count())});
    };
    name(choice_.normal, {"normal.x", "normal.y", "normal.z"});
    name(choice_.motion, {"forward.u", "forward.v", "backward.u", "backward.v"});
    name(choice_.coverage, {"coverage"});
  }

  void store(const Band& band, const std::vector<MeshFront>& meshes) {
    std::size_t to = static_cast<std::size_t>(band.y - window_.y) * static_cast<std::size_t>(window_.width);
    for (std::size_t p = 0; p < band.pixels.size(); ++p, ++to) {
      const Pixel& pixel = band.pixels[p];
      // A mesh is before the discs' surface that is deeper (model section 15).
      if (!meshes.empty() && meshes[p].places > 0 &&
          (!(pixel.weight > 0.0) || meshes[p].mean_depth() < pixel.weighted_depth / pixel.weight)) {
        const MeshFront& mesh = meshes[p];
        put(to, mesh.normal, mesh.forward / mesh.places, mesh.backward / mesh.places,
            static_cast<double>(mesh.places) / pixel_places);
      } else if (pixel.weight > 0.0) {
        put(to, pixel.normal, pixel.forward / pixel.weight, pixel.backward / pixel.weight,
            scene_.model.coverage == Coverage::hard ? 1.0
                                                    : std::min(1.0, pixel.weight / scene_.model.edge_weight));
      }
    }
  }

  void put(std::size_t to, const Eigen::Vector3d& normal, const Eigen::Vector2d& forward,
           const Eigen::Vector2d& backward, double coverage) {
    auto channel = channels_.begin();
    const auto next = [&](double value) { (channel++)->values[to] = static_cast<float>(value); };
    if (choice_.normal)
      for (const double value : Eigen::Vector3d(normal.stableNormalized())) next(value);
    if (choice_.motion)
      for (const Eigen::Vector2d* vector : {&forward, &backward})
        for (const double value : *vector) next(value);
    if (choice_.coverage) next(coverage);
  }

  const Scene& scene_;
  LayerChoice choice_;
  Image window_;
  Exposure exposure_;
  Projection film_;
  PixelFilter filter_;
  std::vector<Placed> placed_;
  std::vector<MeshLayers> meshes_;
  std::vector<std::vector<Ref>> bands_;
  std::vector<ImageChannel> channels_;
};

}  // namespace

Result<std::vector<ImageChannel>> render_layers(const Scene& scene, const LayerChoice& choice,
                                                const RenderControl& control) {
  using Layers = Result<std::vector<ImageChannel>>;
  return without_throwing("for the layers", [&]() -> Layers {
    if (Status status = control.validate(); !status) return status.error();
    if (Status status = scene.validate(); !status) return status.error();
    if (!choice.any()) return std::vector<ImageChannel>();
    if (Status status = refuse_splats(scene, "the pass of the layers"); !status) return status.error();
    if (Status status = refuse_row_delay(scene, "the pass of the layers"); !status) return status.error();
    return run_in_arena(
        control,
        [&]() -> Layers {
          if (!scene.film.has_overscan()) return LayerRenderer(scene, choice).render(control.stop);
          const Scene wide = widened(scene);
          return LayerRenderer(wide, choice).render(control.stop);
        },
        "for the layers");
  });
}

}  // namespace swept
