#include "abuffer/tiles/mesh_facing.h"

#include <Eigen/Geometry>

#include "splat/interval/fixed_bernstein.h"

namespace swept {
namespace {

struct Volume {
  double value, error;  ///< above 0: the back is seen; and what rounding may have made of it
};

class Corners {
 public:
  Corners(const MovingMesh& mesh, std::size_t stretch, std::size_t triangle, bool orthographic)
      : side_(mesh.mirrored(stretch) ? -1.0 : 1.0), orthographic_(orthographic) {
    const Triangle& points = mesh.object().triangles[triangle];
    for (std::size_t i = 0; i < 3; ++i) path_[i] = mesh.path(stretch, points[i]);
  }
  /// Of these control points of the three.
  [[nodiscard]] Volume volume(int i, int j, int k) const {
    const Eigen::Vector3d p = at(0, i), q = at(1, j), r = at(2, k);
    return {side_ * p.dot(q.cross(r)), 0x1p-48 * p.norm() * q.norm() * r.norm()};
  }
  /// When the paths, of that degree, begin or end.
  [[nodiscard]] bool faces_away(int at) const {
    const Volume of = volume(at, at, at);
    return of.value > of.error;
  }

 private:
  /// Parallel rays see of it what those from an eye do of its shadow at depth 1.
  [[nodiscard]] Eigen::Vector3d at(std::size_t corner, int control) const {
    Eigen::Vector3d p = path_[corner][control];
    if (orthographic_) p.z() = 1.0;
    return p;
  }

  double side_;
  bool orthographic_;
  const Eigen::Vector3d* path_[3];
};

}  // namespace

bool always_faces_away(const MovingMesh& mesh, std::size_t stretch, std::size_t triangle, bool orthographic) {
  const Corners corners(mesh, stretch, triangle, orthographic);
  const int n = mesh.degree();
  // The ends are coefficients, too, and most that do not face away are known by one of them.
  if (!corners.faces_away(0) || !corners.faces_away(n)) return false;
  for (int sum = 1; sum < 3 * n; ++sum) {
    double value = 0.0, error = 0.0;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) {
        const int k = sum - i - j;
        if (k < 0 || k > n) continue;
        const Volume of = corners.volume(i, j, k);
        const double weight = binomial_of(n, i) * binomial_of(n, j) * binomial_of(n, k);
        value += weight * of.value;
        error += weight * of.error;
      }
    if (!(value > error)) return false;
  }
  return true;
}

bool faces_away_at_both_ends(const MovingMesh& mesh, std::size_t triangle, bool orthographic) {
  return Corners(mesh, 0, triangle, orthographic).faces_away(0) &&
         Corners(mesh, mesh.stretches() - 1, triangle, orthographic).faces_away(mesh.degree());
}

}  // namespace swept
