// A mesh at one instant: its points in camera space, and which of its triangles come by each cell of the
// film.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "abuffer/tiles/cells.h"
#include "splat/camera.h"
#include "splat/scene.h"

namespace swept {

/// Film coordinates, px, of what lies in front of the near plane.
struct FilmBox {
  double x_min, x_max, y_min, y_max;
};

/// Columns and rows of the film's cells.
struct CellRange {
  std::size_t x_begin = 0, x_end = 0, y_begin = 0, y_end = 0;
};
/// Those that a box with so many pixels around it comes by.
[[nodiscard]] CellRange cells_of(const FilmBox& box, double margin, const CellGrid& grid);

/// Of a triangle in camera space. Nothing of one that lies nearer than `near` throughout, or is not finite.
[[nodiscard]] std::optional<FilmBox> film_box(const Eigen::Vector3d (&corner)[3],
                                              const Projection& projection, double near);

class MeshInstant {
 public:
  MeshInstant(const Scene& scene, const Object& object, double frame);

  /// Fills triangles() of the cells that are `wanted`.
  void share_out(const CellGrid& grid, const std::vector<char>& wanted);

  [[nodiscard]] const Object& object() const { return *object_; }
  [[nodiscard]] const Projection& projection() const { return projection_; }
  /// Of an orthographic camera a depth behind all of it, and otherwise 0.
  [[nodiscard]] double behind() const { return behind_; }
  /// From PlacedTriangle::inverse_depth.
  [[nodiscard]] float depth_of(float inverse_depth) const {
    return projection_.orthographic ? static_cast<float>(behind_ - double{inverse_depth})
                                    : 1.0f / inverse_depth;
  }
  [[nodiscard]] double near() const { return near_; }
  [[nodiscard]] double frame() const { return frame_; }
  /// Whether object and camera mirror the mesh, so that its front is where it looks clockwise.
  [[nodiscard]] bool mirrored() const { return mirrored_; }
  /// Of a triangle, camera space.
  [[nodiscard]] const Eigen::Vector3d& corner(std::size_t triangle, std::size_t i) const {
    return points_[object_->triangles[triangle][i]];
  }
  /// Those that may be seen in a cell, in the mesh's order.
  [[nodiscard]] std::span<const std::uint32_t> triangles(std::size_t cell) const {
    if (starts_.empty()) return {};
    return std::span(entries_).subspan(starts_[cell], starts_[cell + 1] - starts_[cell]);
  }
  [[nodiscard]] std::optional<FilmBox> box(std::size_t triangle) const {
    return film_box({corner(triangle, 0), corner(triangle, 1), corner(triangle, 2)}, projection_, near_);
  }

 private:
  const Object* object_;
  Projection projection_;
  double behind_ = 0.0;
  double near_, frame_;
  bool mirrored_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<std::size_t> starts_;
  std::vector<std::uint32_t> entries_;
};

}  // namespace swept
