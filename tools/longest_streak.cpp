#include "tools/longest_streak.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace swept {
namespace {

constexpr std::size_t instants = 9;

/// Where a point is on the film, and whether the window has it.
struct Place {
  Eigen::Vector2d pixel;
  bool in_window = false;
};

class Projector {
 public:
  Projector(const Scene& scene, const Object& object, double frame)
      : film_(scene.film),
        frame_(frame),
        near_(scene.camera.near),
        camera_(scene.camera.at(frame)),
        world_(object.transform.at(frame)),
        projection_(projection_of(film_, camera_)),
        lens_(lens_matrix(camera_, camera_)) {}

  /// None before the near plane.
  [[nodiscard]] std::optional<Place> place(const Object& object, std::size_t i) const {
    const Eigen::Vector3d world =
        world_ * (object.splats.size() > 0 ? object.splats.position_at(i, frame_)
                                           : surfel_at(object.cloud, i, frame_).position);
    const Eigen::Vector3d p = lens_ * (camera_.camera_from_world.linear() * (world - camera_.eye));
    if (!(p.z() >= near_)) return std::nullopt;
    const double divisor = projection_.divisor(p.z());
    Place place{{projection_.center_x + projection_.focal_px * p.x() / divisor,
                 projection_.center_y + projection_.focal_px * p.y() / divisor}};
    const double x = place.pixel.x() - film_.window_x(), y = place.pixel.y() - film_.window_y();
    place.in_window = x >= 0.0 && y >= 0.0 && x < film_.window_width() && y < film_.window_height();
    return place;
  }

 private:
  const Film& film_;
  double frame_, near_;
  CameraInstant camera_;
  Eigen::Affine3d world_;
  Projection projection_;
  Eigen::Matrix3d lens_;
};

}  // namespace

double longest_streak_px(const Scene& scene, const Object& object) {
  const double open = scene.frame + scene.shutter.open, close = scene.frame + scene.shutter.close;
  if (open == close) return 0.0;
  if (!object.cloud.moves() && !object.splats.moves() && object.transform.constant_over(open, close) &&
      scene.camera.constant_over(open, close)) {
    return 0.0;
  }
  std::vector<Projector> projectors;
  for (std::size_t k = 0; k < instants; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(instants - 1);
    projectors.emplace_back(scene, object, open + share * (close - open));
  }
  double longest = 0.0;
  for (std::size_t i = 0; i < std::max(object.cloud.size(), object.splats.size()); ++i) {
    double streak = 0.0;
    std::optional<Place> before;
    for (const Projector& projector : projectors) {
      const std::optional<Place> now = projector.place(object, i);
      if (before && now && (before->in_window || now->in_window))
        streak += (now->pixel - before->pixel).norm();
      before = now;
    }
    longest = std::max(longest, streak);
  }
  return longest;
}

}  // namespace swept
