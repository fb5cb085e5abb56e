#include "abuffer/sources/mesh_instant.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "splat/motion/instant.h"

namespace swept {

std::optional<FilmBox> film_box(const Eigen::Vector3d (&corner)[3], const Projection& projection,
                                double near) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  FilmBox box{infinity, -infinity, infinity, -infinity};
  const auto include = [&](const Eigen::Vector3d& p) {
    const double divisor = projection.divisor(p.z());
    const double x = projection.center_x + projection.focal_px * (p.x() / divisor),
                 y = projection.center_y + projection.focal_px * (p.y() / divisor);
    box = {std::min(box.x_min, x), std::max(box.x_max, x), std::min(box.y_min, y), std::max(box.y_max, y)};
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d &a = corner[i], &b = corner[(i + 1) % 3];
    if (a.z() >= near) include(a);
    // Where the edge meets the near plane.
    if ((a.z() < near) != (b.z() < near)) {
      Eigen::Vector3d met = a + (near - a.z()) / (b.z() - a.z()) * (b - a);
      met.z() = near;
      include(met);
    }
  }
  if (!(box.x_min <= box.x_max && box.y_min <= box.y_max)) return std::nullopt;
  return box;
}

CellRange cells_of(const FilmBox& box, double margin, const CellGrid& grid) {
  if (!(box.x_max + margin > 0.0 && box.x_min - margin < grid.film.width && box.y_max + margin > 0.0 &&
        box.y_min - margin < grid.film.height))
    return {};
  const auto cell = [](double px, std::size_t count) {
    return std::min(static_cast<std::size_t>(std::max(0.0, std::min(px, 1e9))) / cell_px, count - 1);
  };
  return {cell(box.x_min - margin, grid.columns), cell(box.x_max + margin, grid.columns) + 1,
          cell(box.y_min - margin, grid.rows), cell(box.y_max + margin, grid.rows) + 1};
}

MeshInstant::MeshInstant(const Scene& scene, const Object& object, double frame)
    : object_(&object),
      projection_(projection_of(scene.film, scene.camera.at(frame))),
      near_(scene.camera.near),
      frame_(frame) {
  const Instant instant = instant_at(scene, object, {frame, frame}, 0.0);
  mirrored_ = (instant.camera_from_world * instant.world_from_object.linear()).determinant() < 0.0;
  const SurfelsAt at(object.cloud, frame);
  points_.reserve(object.cloud.size());
  for (std::size_t i = 0; i < object.cloud.size(); ++i) points_.push_back(instant.to_camera(at.position(i)));
  if (projection_.orthographic) {
    double farthest = 0.0;
    for (const Eigen::Vector3d& p : points_)
      if (std::isfinite(p.z())) farthest = std::max(farthest, std::abs(p.z()));
    behind_ = (1.0 + 0x1p-10) * farthest;
  }
}

void MeshInstant::share_out(const CellGrid& grid, const std::vector<char>& wanted) {
  std::vector<CellRange> touched(object_->triangles.size());
  starts_.assign(grid.size() + 1, 0);
  const auto for_each_cell = [&](const CellRange& range, const auto& visit) {
    for (std::size_t y = range.y_begin; y < range.y_end; ++y)
      for (std::size_t x = range.x_begin; x < range.x_end; ++x)
        if (wanted[y * grid.columns + x]) visit(y * grid.columns + x);
  };
  for (std::size_t t = 0; t < touched.size(); ++t) {
    // Places lie up to half a pixel from the centre; the rest takes care of rounding.
    if (const std::optional<FilmBox> found = box(t)) touched[t] = cells_of(*found, 1.0, grid);
    for_each_cell(touched[t], [&](std::size_t c) { ++starts_[c + 1]; });
  }
  for (std::size_t c = 0; c < grid.size(); ++c) starts_[c + 1] += starts_[c];
  entries_.resize(starts_.back());
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t t = 0; t < touched.size(); ++t)
    for_each_cell(touched[t], [&](std::size_t c) { entries_[next[c]++] = static_cast<std::uint32_t>(t); });
}

}  // namespace swept
