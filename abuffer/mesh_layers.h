// What the layers show of meshes: what the places of a pixel meet first of each, at one instant (model
// section 13).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "abuffer/simd/mesh_math.h"
#include "abuffer/sources/mesh_instant.h"
#include "splat/motion/instant.h"
#include "splat/scene.h"

namespace swept {

/// Sums over the places of a pixel that meet a mesh.
struct MeshFront {
  int places = 0;
  double depth = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();                                       ///< world space
  Eigen::Vector2d forward = Eigen::Vector2d::Zero(), backward = Eigen::Vector2d::Zero();  ///< px per frame

  [[nodiscard]] double mean_depth() const { return depth / places; }
};

/// Rows of the film, of all of its window's columns.
struct FilmBand {
  int x, y, width, height;  ///< px of the film
};

class MeshLayers {
 public:
  struct Choice {
    bool normals, motion;
  };
  struct Instants {
    Instant open, middle, close;
  };
  /// Scene and object must outlive it. `film` is the projection that the instants' camera space belongs to.
  MeshLayers(const Scene& scene, const Object& object, const Instants& instants, const Projection& film,
             Choice choice);

  /// Lets front[] show this mesh in the band's pixels in which it is nearer than what is there.
  void draw(const FilmBand& band, std::vector<MeshFront>& front) const;

 private:
  struct Point {
    Eigen::Vector3d world, normal;        ///< unit or zero
    Eigen::Vector3d open, middle, close;  ///< camera space
  };
  struct NearestPlaces {
    float inverse_depth[pixel_places] = {};     ///< 0: none
    std::uint32_t triangle[pixel_places] = {};  ///< of those drawn in the band
  };
  struct Drawn {
    PlacedTriangle placed;
    std::uint32_t triangle;
  };

  void add(const Drawn& drawn, double x, double y, MeshFront& sum) const;
  [[nodiscard]] Eigen::Vector3d normal_at(const Triangle& triangle, const Eigen::Vector3d& share) const;

  MeshInstant mesh_;
  Projection film_;
  double near_;
  Choice choice_;
  Eigen::Vector3d eye_, along_;  ///< where rays begin, and where parallel ones go, world space
  double frames_forward_, frames_backward_;
  std::vector<Point> points_;
  std::vector<std::optional<FilmBox>> boxes_;  ///< of the triangles
};

}  // namespace swept
