// Polynomials that are told by their roots.
#pragma once

#include <vector>

#include "splat/interval/bernstein.h"

namespace swept {

/// Π (t − roots), times `scale`, in Bernstein form. Its coefficients are rounded: those are what is exact.
inline Bernstein of_roots(const std::vector<double>& roots, double scale) {
  Bernstein p;
  p.c[0] = scale;
  for (const double root : roots) {
    Bernstein factor;
    factor.degree = 1;
    factor.c[0] = -root;
    factor.c[1] = 1.0 - root;
    p = product(p, factor);
  }
  return p;
}

}  // namespace swept
