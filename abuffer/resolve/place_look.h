// What one place sees of a triangle whose colour changes over it: its edge functions, made ready once and
// looked at often. Source: Gribel et al. 2013, Eq. 10; model section 15.2.
#pragma once

#include <algorithm>

#include "abuffer/sources/triangle_stretch.h"
#include "splat/interval/fixed_bernstein.h"

namespace swept {

class PlaceLook {
 public:
  PlaceLook() = default;
  /// The triangle must outlive it.
  PlaceLook(const TriangleStretch& triangle, const Eigen::Vector3d& ray)
      : triangle_(&triangle), degree_(triangle.edges(ray, edge_)) {}

  /// Premultiplied, at a time at which the ray meets it; as TriangleStretch::look() has it.
  void at(double time, double (&rgba)[4]) const {
    const double t = share(time);
    double e[3];
    edges_at(t, e);
    triangle_->color(e, t, rgba);
  }
  [[nodiscard]] TriangleStretch::OnTexture on_texture(double time) const {
    double e[3];
    edges_at(share(time), e);
    return triangle_->texels(e);
  }

 private:
  [[nodiscard]] double share(double time) const { return std::clamp(triangle_->local(time), 0.0, 1.0); }
  void edges_at(double t, double (&e)[3]) const {
    degree_ == 1 ? edges_of<1>(t, e) : degree_ == 2 ? edges_of<2>(t, e) : edges_of<3>(t, e);
  }
  template <int n>
  void edges_of(double t, double (&e)[3]) const {
    for (int i = 0; i < 3; ++i) {
      FixedBernstein<2 * n> p;
      std::copy_n(edge_[i], 2 * n + 1, p.c);
      e[i] = p.at(t);
    }
  }

  const TriangleStretch* triangle_ = nullptr;
  double edge_[3][2 * most_path_degree + 1] = {};
  int degree_ = 1;
};

}  // namespace swept
