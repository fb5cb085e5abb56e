#include "splat/interval/edge_function.h"

#include <algorithm>

namespace swept {
namespace {

double binomial(int n, int k) {
  double b = 1.0;
  for (int i = 1; i <= k; ++i) b = b * (n - k + i) / i;
  return b;
}

/// A total order of paths by what they are, which no numbering of points changes.
bool before(const PathPoints& p, const PathPoints& q, int degree) {
  for (std::size_t i = 0; i <= static_cast<std::size_t>(degree); ++i)
    for (int c = 0; c < 3; ++c)
      if (p[i][c] != q[i][c]) return p[i][c] < q[i][c];
  return false;
}

}  // namespace

EdgeFunction::EdgeFunction(const PathPoints& p, const PathPoints& q, int degree) : degree_(2 * degree) {
  // Summed up in one order whichever way the edge runs: negatives to the bit, even where the compiler
  // contracts products.
  const bool swapped = before(q, p, degree);
  const PathPoints &a = swapped ? q : p, &b = swapped ? p : q;
  const double sign = swapped ? -1.0 : 1.0;
  for (Eigen::Vector3d& normal : normals_) normal.setZero();
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; j <= degree; ++j)
      normals_[static_cast<std::size_t>(i + j)] +=
          binomial(degree, i) * binomial(degree, j) *
          a[static_cast<std::size_t>(i)].cross(b[static_cast<std::size_t>(j)]);
  for (int k = 0; k <= degree_; ++k) normals_[static_cast<std::size_t>(k)] *= sign / binomial(degree_, k);
}

SignChanges EdgeFunction::sides(const Eigen::Vector3d& ray) const {
  SignChanges changes = sign_changes(at(ray));
  if (changes.first != 0) return changes;
  double right = 0.0, below = 0.0;
  for (std::size_t k = 0; k <= static_cast<std::size_t>(degree_); ++k) {
    right += normals_[k].x();
    below += normals_[k].y();
  }
  const double side = right != 0.0 ? right : below;
  changes.first = side > 0.0 ? 1 : side < 0.0 ? -1 : 0;
  return changes;
}

}  // namespace swept
