// How deep a triangle is at a place while the place sees it: Σe·z / Σe, made ready once and looked at often.
// Source: Gribel et al. 2013, Eq. 11; model section 15.
#pragma once

#include <algorithm>

#include "abuffer/sources/triangle_stretch.h"
#include "splat/interval/fixed_bernstein.h"

namespace swept {

class PlaceDepth {
 public:
  /// While the ray meets the triangle, between these depths.
  PlaceDepth(const TriangleStretch& triangle, const Eigen::Vector3d& ray, float nearest, float farthest)
      : degree_(triangle.depth(ray, above_, below_)),
        begin_(triangle.begin),
        per_time_(1.0 / (triangle.end - triangle.begin)),
        nearest_(double{nearest}),
        farthest_(double{farthest}) {
    to_powers(above_, 3 * degree_, above_powers_);
    to_powers(below_, 2 * degree_, below_powers_);
  }

  /// At a time at which it does. Never outside of these depths, where rounding may put a quotient of
  /// what is nearly 0.
  [[nodiscard]] double at(double time) const {
    const double t = (time - begin_) * per_time_;
    const double z = degree_ == 1 ? quotient<1>(t) : degree_ == 2 ? quotient<2>(t) : quotient<3>(t);
    // Written so that what is no number becomes one.
    return std::min(farthest_, std::max(nearest_, z));
  }

  /// Appends, in any order, at which times between `from` and `to`, at which both are there, one of them
  /// passes through the other.
  static void add_crossings(const PlaceDepth& a, const PlaceDepth& b, double from, double to,
                            std::vector<double>& times) {
    if (a.degree_ != b.degree_) return add_mixed(a, b, from, to, times);
    if (a.degree_ == 1) return add_alike<1>(a, b, from, to, times);
    if (a.degree_ == 2) return add_alike<2>(a, b, from, to, times);
    add_alike<3>(a, b, from, to, times);
  }

 private:
  template <int n>
  [[nodiscard]] double quotient(double t) const {
    double over = above_powers_[3 * n], under = below_powers_[2 * n];
    for (int k = 3 * n; k-- > 0;) over = over * t + above_powers_[k];
    for (int k = 2 * n; k-- > 0;) under = under * t + below_powers_[k];
    return over / under;
  }

  /// From Bernstein form to powers of the same time.
  static void to_powers(const double* c, int degree, double* powers) {
    std::copy_n(c, degree + 1, powers);
    for (int level = 1; level <= degree; ++level)
      for (int k = degree; k >= level; --k) powers[k] -= powers[k - 1];
    double binomial = 1.0;
    for (int k = 1; k <= degree; ++k) powers[k] *= binomial = binomial * (degree - k + 1) / k;
  }

  [[nodiscard]] double share(double time) const { return std::clamp((time - begin_) * per_time_, 0.0, 1.0); }
  template <int degree>
  [[nodiscard]] static FixedBernstein<degree> part(const double* c, double from, double to) {
    FixedBernstein<degree> p;
    std::copy_n(c, degree + 1, p.c);
    return p.part(from, std::max(from, to));
  }
  // Depths are Na/Da and Nb/Db: they are equal where Na·Db − Nb·Da is 0.
  template <int n>
  static void add_alike(const PlaceDepth& a, const PlaceDepth& b, double from, double to,
                        std::vector<double>& times) {
    const auto above = [&](const PlaceDepth& of) {
      return part<3 * n>(of.above_, of.share(from), of.share(to));
    };
    const auto below = [&](const PlaceDepth& of) {
      return part<2 * n>(of.below_, of.share(from), of.share(to));
    };
    FixedBernstein<5 * n> apart{}, other{};
    add_product(below(b), above(a), apart);
    add_product(below(a), above(b), other);
    for (int k = 0; k <= 5 * n; ++k) apart.c[k] -= other.c[k];
    if (apart.side() != 0) return;
    Bernstein whole;
    whole.degree = 5 * n;
    std::copy_n(apart.c, 5 * n + 1, whole.c.begin());
    add_roots(whole, from, to, times);
  }
  static void add_mixed(const PlaceDepth& a, const PlaceDepth& b, double from, double to,
                        std::vector<double>& times);
  static void add_roots(const Bernstein& apart, double from, double to, std::vector<double>& times);

  int degree_;  ///< of the paths
  double begin_, per_time_, nearest_, farthest_;
  // Over the triangle's stretch.
  double above_[3 * most_path_degree + 1], below_[2 * most_path_degree + 1];  ///< in Bernstein form
  double above_powers_[3 * most_path_degree + 1], below_powers_[2 * most_path_degree + 1];
};

}  // namespace swept
