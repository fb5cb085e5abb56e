// What a place sees of a texture along its way over it, summed up texel by texel.
//
// Where on the texture a ray meets a triangle is a quotient of polynomials of time. Over the while that a
// place sees one triangle it is hardly bent: a parabola through its begin, middle and end is it to a
// thousandth of a texel, as the coefficients of what it is off show, or else the while is halved. At roots of
// quadratics it then meets the lines between texels; where these are off by so much, sums are by its square,
// for colours have no steps there. Between four texels a colour is a sum of 1, x, y and xy: four integrals
// hold the light of all channels, by the quotient itself at nodes that are exact to the fifth degree.
// Source: model section 15.2; Rönnow et al. 2021, section 4.3, who filter along the chord from uv_s to uv_e.
#pragma once

#include <vector>

#include "abuffer/resolve/light_left.h"
#include "abuffer/resolve/place_light.h"
#include "abuffer/sources/triangle_stretch.h"
#include "splat/interval/fixed_bernstein.h"

namespace swept {

/// A thread's.
class TexelWay {
 public:
  /// Takes the way of what `ray` sees of `triangle` between these times, and forgets the one before. False:
  /// it is too bent, or passes too many texels.
  [[nodiscard]] bool find(const TriangleStretch& triangle, const Eigen::Vector3d& ray, double begin,
                          double end);
  /// Has this light see it, evenly in time; parts are within the times of find().
  void see(const LightLeft::Part& part);
  /// Adds ∫ texel ds by all light that has seen it: red, green and blue, premultiplied.
  void add_colors(const Texture& texture, double (&sum)[3]) const;
  /// Adds that to a sum, in the one colour of the triangle.
  void add_light(const TriangleStretch& triangle, LightSum& sum) const;

 private:
  /// Between four texels.
  struct Step {
    double end;                     ///< it begins where the one before ends
    double column, row;             ///< of the first of the four
    double one, of_x, of_y, of_xy;  ///< integrals of 1, x, y and xy, which are 0 there
  };
  /// One coordinate, in texels; whole numbers are where the texture is not smooth.
  struct Parabola {
    double start, slope, bend;

    [[nodiscard]] double at(double u) const { return start + u * (slope + u * bend); }
  };
  /// Columns and rows are quotients of the first two by the third.
  template <int n>
  using Way = FixedBernstein<2 * n>[3];
  template <int n>
  [[nodiscard]] bool find_of(const TriangleStretch& triangle, const Eigen::Vector3d& ray, double end);
  template <int n>
  [[nodiscard]] bool fit(const Way<n>& way, double begin, double end, int halvings);
  [[nodiscard]] bool add_steps(const Parabola (&of)[2], double begin, double end);
  template <int n>
  void see_of(const LightLeft::Part& part);

  int degree_ = 1;  ///< of the paths
  double begin_ = 0.0, per_time_ = 1.0;
  double powers_[3][2 * most_path_degree + 1] = {};  ///< of (time − begin_)·per_time_
  std::vector<Step> steps_;
  std::vector<double> cuts_;
};

}  // namespace swept
