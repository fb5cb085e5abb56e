#include "abuffer/resolve/place_depth.h"

namespace swept {

void PlaceDepth::add_roots(const Bernstein& apart, double from, double to, std::vector<double>& times) {
  const SignChanges changes = sign_changes(apart);
  for (int k = 0; k < changes.count; ++k)
    times.push_back(from + (to - from) * changes.at[static_cast<std::size_t>(k)]);
}

void PlaceDepth::add_mixed(const PlaceDepth& a, const PlaceDepth& b, double from, double to,
                           std::vector<double>& times) {
  const auto of = [&](const PlaceDepth& depth, const double* c, int degree) {
    Bernstein p;
    p.degree = degree;
    std::copy_n(c, degree + 1, p.c.begin());
    return p.part(depth.share(from), std::max(depth.share(from), depth.share(to)));
  };
  const Bernstein one = product(of(a, a.above_, 3 * a.degree_), of(b, b.below_, 2 * b.degree_)),
                  other = product(of(b, b.above_, 3 * b.degree_), of(a, a.below_, 2 * a.degree_));
  const int degree = std::max(one.degree, other.degree);
  add_roots(difference(one.raised(degree), other.raised(degree)), from, to, times);
}

}  // namespace swept
