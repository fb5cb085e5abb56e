// A moving triangle as the rays through places of the film meet it: intervals of time. Source: Gribel et al.
// 2013, sections 3 and 5.
//
// A ray is inside where all three edge functions have one sign; shares of the corners are e over their sum
// (Eq. 10), and the depth is Σe·z / Σe (Eq. 11 with w for z): rational functions of time that are kept as
// they are, so that no depth is linearised.
#pragma once

#include <cstdint>
#include <vector>

#include "abuffer/simd/edge_math.h"
#include "abuffer/sources/moving_mesh.h"
#include "splat/interval/edge_function.h"
#include "splat/interval/pixel_places.h"

namespace swept {

/// Rays (x, y, 1) through the places of a pixel.
struct RaysOfPixel {
  const double *x, *y;  ///< pixel_places of each
  [[nodiscard]] Eigen::Vector3d operator[](std::size_t place) const { return {x[place], y[place], 1.0}; }
};

/// When a place of a pixel sees a triangle, of all the exposure; and between which depths.
struct PlaceInterval {
  std::uint32_t place;   ///< the caller's number of the ray
  std::uint32_t source;  ///< of the TriangleStretch
  double begin, end;
  float nearest, farthest;
};

class TriangleStretch {
 public:
  TriangleStretch(const MovingMesh& mesh, std::uint32_t mesh_index, std::size_t stretch, std::size_t triangle,
                  double near, bool orthographic = false);

  std::uint32_t mesh, triangle;
  double begin, end;                 ///< of the stretch
  bool one_color;                    ///< all corners have it, at all times
  bool plain, opaque;                ///< so has all of it; no light comes through
  bool even_alpha;                   ///< light comes through alike, anywhere and at any time
  float least_alpha;                 ///< anywhere on it, at any time
  float rgba[3][4];                  ///< premultiplied, as the stretch begins
  float more[3][4];                  ///< and by how much more as it ends
  const Texture* texture = nullptr;  ///< multiplies them
  float uv[3][2];                    ///< the corners' places on it

  /// Whether no ray within (±half_x, ±half_y) of `ray` meets it. It may say no where that is so, but never
  /// yes where it is not.
  [[nodiscard]] bool misses(const Eigen::Vector3d& ray, double half_x, double half_y) const;
  /// At which places of a pixel, bit by bit, a ray may meet it; at others none does.
  [[nodiscard]] std::uint32_t may_meet(const RaysOfPixel& rays) const;
  /// Appends when `ray` meets it between `from` and `to`.
  void meet(const Eigen::Vector3d& ray, double from, double to, std::uint32_t place, std::uint32_t source,
            std::vector<PlaceInterval>& out) const;

  /// Whether EdgeMath may look at all places of a pixel at once.
  [[nodiscard]] bool straight() const { return degree_ == 1 && !cut_; }
  [[nodiscard]] StraightEdges straight_edges() const {
    return {{edge_[0].normal(0).data(), edge_[1].normal(0).data(), edge_[2].normal(0).data()},
            shows_above_,
            shows_below_};
  }
  /// What meet() appends, of place `k` of a pixel of which EdgeMath has found when it meets this.
  void keep(const Eigen::Vector3d& ray, double from, double to, const MetPlaces& met, std::uint32_t k,
            std::uint32_t place, std::uint32_t source, std::vector<PlaceInterval>& out) const;

  /// The depth over the stretch as a quotient, `above` of 3n + 1 coefficients in Bernstein form and `below`
  /// of 2n + 1; returns n, the degree of the paths.
  int depth(const Eigen::Vector3d& ray, double* above, double* below) const {
    const auto at = [&](const Eigen::Vector3d& of) { return of.x() * ray.x() + (of.y() * ray.y() + of.z()); };
    for (int k = 0; k <= 3 * degree_; ++k) above[k] = at(above_[k]);
    for (int k = 0; k <= 2 * degree_; ++k) below[k] = at(below_[k]);
    return degree_;
  }
  [[nodiscard]] bool on_lines() const { return degree_ == 1; }
  /// Of the paths.
  [[nodiscard]] int degree() const { return degree_; }
  /// The same for paths of degree 1, into one lane of these.
  void depth(const Eigen::Vector3d& ray, int lane, DepthChords& chords) const {
    const double x = ray.x(), y = ray.y();
    const auto at = [&](const Eigen::Vector3d& of) { return of.x() * x + (of.y() * y + of.z()); };
    for (int k = 0; k < 4; ++k) chords.above[k][lane] = at(above_[k]);
    for (int k = 0; k < 3; ++k) chords.below[k][lane] = at(below_[k]);
  }
  [[nodiscard]] double local(double time) const { return (time - begin) / (end - begin); }

  struct Look {
    double depth;
    double rgba[4];
  };
  /// What the ray sees of it at a time at which it meets it.
  [[nodiscard]] Look look(const Eigen::Vector3d& ray, double time) const;
  /// Where on the texture, in texels, less half of one: whole numbers are where it is not smooth.
  struct OnTexture {
    double x, y;
  };
  [[nodiscard]] OnTexture on_texture(const Eigen::Vector3d& ray, double time) const;

  /// The ray's edge functions over the stretch, of 2n + 1 coefficients in Bernstein form; returns n.
  int edges(const Eigen::Vector3d& ray, double (&e)[3][2 * most_path_degree + 1]) const {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k <= 2 * degree_; ++k) {
        const Eigen::Vector3d& normal = edge_[i].normal(static_cast<std::size_t>(k));
        e[i][k] = normal.x() * ray.x() + (normal.y() * ray.y() + normal.z());
      }
    return degree_;
  }
  /// Where on the texture the ray meets it over the stretch: columns and rows as on_texture() has them are
  /// quotients of the first two by the third, of 2n + 1 coefficients in Bernstein form, n being degree().
  void way_over_texels(const Eigen::Vector3d& ray, double (&way)[3][2 * most_path_degree + 1]) const;
  /// What look() and on_texture() see where edge functions have these values, at a share `t` of the stretch.
  void color(const double (&e)[3], double t, double (&rgba)[4]) const;
  [[nodiscard]] OnTexture texels(const double (&e)[3]) const;

 private:
  template <int n>
  [[nodiscard]] bool misses_of(const Eigen::Vector3d& ray, double half_x, double half_y) const;
  template <int n>
  [[nodiscard]] std::uint32_t may_meet_of(const RaysOfPixel& rays) const;
  template <int n>
  void meet_of(const Eigen::Vector3d& ray, double from, double to, std::uint32_t place, std::uint32_t source,
               std::vector<PlaceInterval>& out) const;
  template <int n>
  void keep_of(const Eigen::Vector3d& ray, double from, double to, double first, double last,
               std::uint32_t place, std::uint32_t source, std::vector<PlaceInterval>& out) const;
  template <int n>
  [[nodiscard]] Look look_of(const Eigen::Vector3d& ray, double time) const;

  template <int n>
  void set_depth();
  /// By edge functions that are none of them below 0, and their sum.
  void mix(const double (&e)[3], double weight, double t, double (&rgba)[4]) const;

  int degree_;
  double near_;
  EdgeFunction edge_[3];
  /// Σe·z and Σe of a ray are these times it: the depth at any ray without its edge functions.
  Eigen::Vector3d above_[3 * most_path_degree + 1], below_[2 * most_path_degree + 1];
  Bernstein z_[3];
  double nearest_, farthest_;
  bool cut_;                        ///< the near plane may cut it
  bool shows_above_, shows_below_;  ///< where edge functions are above 0, and below
};

}  // namespace swept
