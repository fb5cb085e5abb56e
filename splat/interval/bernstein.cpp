#include "splat/interval/bernstein.h"

#include <algorithm>
#include <cmath>

#include "splat/interval/only_root.h"

namespace swept {
namespace {

std::size_t size_of(const Bernstein& p) { return static_cast<std::size_t>(p.degree) + 1; }

CoefficientSigns signs_of(const Bernstein& p) { return swept::signs_of(p.c.data(), size_of(p)); }

/// Of a size at which squares and quotients of coefficients are in range; false: not finite.
bool in_range(Bernstein& p) {
  for (std::size_t k = 0; k < size_of(p); ++k)
    if (!std::isfinite(p.c[k])) return false;
  const double most = p.largest();
  if (most > 0.0 && !(most > 1e-100 && most < 1e100)) {
    const double scale = std::ldexp(1.0, -std::ilogb(most));
    for (std::size_t k = 0; k < size_of(p); ++k) p.c[k] *= scale;
  }
  return true;
}

/// The left half; `p` becomes the right one.
Bernstein halve(Bernstein& p) {
  Bernstein left;
  left.degree = p.degree;
  const std::size_t n = size_of(p);
  for (std::size_t level = 0; level < n; ++level) {
    left.c[level] = p.c[0];
    for (std::size_t k = 0; k + 1 < n - level; ++k) p.c[k] = 0.5 * (p.c[k] + p.c[k + 1]);
  }
  // What is left in p, from the last level to the first, is the right half.
  return left;
}

constexpr int most_cuts = 46;  ///< of an interval: where a root lies is known to its 2⁻⁴⁶ then

class Cutter {
 public:
  SignChanges changes;

  void add(Bernstein p, double begin, double width, int depth) {
    const CoefficientSigns s = signs_of(p);
    if (s.first == 0) return;
    if (s.changes == 0 || depth == most_cuts) {
      meet(s.first, begin);
      // Nearer than numbers tell: a root between signs that differ, else none.
      if (s.last != s.first) meet(s.last, begin + 0.5 * width);
      return;
    }
    if (s.changes == 1) {
      meet(s.first, begin);
      meet(s.last, begin + width * only_root<0>(p.c.data(), p.degree, s.first));
      return;
    }
    const Bernstein left = halve(p);
    // halve() leaves coefficients of the right half in order.
    add(left, begin, 0.5 * width, depth + 1);
    add(p, begin + 0.5 * width, 0.5 * width, depth + 1);
  }

 private:
  int last_ = 0;

  /// From `t` on the sign is this.
  void meet(int sign, double t) {
    if (last_ == 0) changes.first = sign;
    if (last_ != 0 && sign != last_ && changes.count < most_bernstein_degree) {
      const auto n = static_cast<std::size_t>(changes.count++);
      changes.at[n] = n > 0 ? std::max(t, changes.at[n - 1]) : t;
    }
    last_ = sign;
  }
};

/// a·b − c·d with an error of 1.5 ulp (Kahan).
double difference_of_products(double a, double b, double c, double d) {
  const double cd = c * d, error = std::fma(-c, d, cd);
  return std::fma(a, b, -cd) + error;
}

/// All real roots of x³ + ax² + bx + c: the largest.
double largest_cubic_root(double a, double b, double c) {
  const double q = (a * a - 3.0 * b) / 9.0, r = (a * (2.0 * a * a - 9.0 * b) + 27.0 * c) / 54.0;
  double x;
  if (r * r < q * q * q) {
    const double angle = std::acos(std::clamp(r / std::sqrt(q * q * q), -1.0, 1.0));
    const double m = -2.0 * std::sqrt(q);
    x = std::max({m * std::cos(angle / 3.0), m * std::cos((angle + 2.0 * M_PI) / 3.0),
                  m * std::cos((angle - 2.0 * M_PI) / 3.0)}) -
        a / 3.0;
  } else {
    const double u = -std::copysign(std::cbrt(std::abs(r) + std::sqrt(std::max(0.0, r * r - q * q * q))), r);
    x = u + (u == 0.0 ? 0.0 : q / u) - a / 3.0;
  }
  for (int i = 0; i < 3; ++i) {
    const double slope = (3.0 * x + 2.0 * a) * x + b;
    if (slope == 0.0) break;
    x -= (((x + a) * x + b) * x + c) / slope;
  }
  return x;
}

/// Real parts of the roots of x⁴ + ax³ + bx² + cx + d that are real, or nearly: a double root that rounding
/// makes a complex pair is its middle, twice.
int quartic_roots(double a, double b, double c, double d, double (&out)[4]) {
  // Depressed: y⁴ + py² + qy + r, y = x + a/4.
  const double aa = a * a, p = b - 0.375 * aa, q = c - 0.5 * a * b + 0.125 * aa * a,
               r = d - 0.25 * a * c + aa * b / 16.0 - 3.0 * aa * aa / 256.0;
  int n = 0;
  const auto add = [&](double linear, double constant) {  // y² + linear·y + constant
    const double discriminant = 0.25 * linear * linear - constant;
    const double scale = 0.25 * linear * linear + std::abs(constant);
    if (discriminant < -1e-4 * scale) return;
    const double root = std::sqrt(std::max(0.0, discriminant));
    out[n++] = -0.5 * linear - root - 0.25 * a;
    out[n++] = -0.5 * linear + root - 0.25 * a;
  };
  // (y² + m/2 … )² with m the largest root of the resolvent, ≥ 0.
  const double m = largest_cubic_root(2.0 * p, p * p - 4.0 * r, -q * q);
  if (m > 0.0) {
    const double s = std::sqrt(m), middle = 0.5 * (p + m);
    add(s, middle - 0.5 * q / s);
    add(-s, middle + 0.5 * q / s);
  } else {
    // y⁴ + py² + r.
    const double discriminant = std::max(0.0, 0.25 * p * p - r), root = std::sqrt(discriminant);
    add(0.0, 0.5 * p - root);
    add(0.0, 0.5 * p + root);
  }
  return n;
}

SignChanges four_roots(const Bernstein& p, const CoefficientSigns& s) {
  // In r = (1 + t)/(2 − t), of which [½, 2] is what is sought: no root of interest is near 0 or infinity. Its
  // coefficients are those over [−1, 2], seen from the end whose coefficient is larger.
  Bernstein wide = p;
  for (std::size_t level = 1; level < 5; ++level)
    for (std::size_t k = 0; k + level < 5; ++k) wide.c[k] -= wide.c[k + 1] - wide.c[k];
  for (std::size_t level = 1; level < 5; ++level)
    for (std::size_t k = 4; k >= level; --k) wide.c[k] = wide.c[k - 1] + 1.5 * (wide.c[k] - wide.c[k - 1]);
  const bool reversed = std::abs(wide.c[0]) > std::abs(wide.c[4]);
  double c[5];
  for (std::size_t k = 0; k < 5; ++k) c[k] = bernstein_binomials[4][k] * wide.c[reversed ? 4 - k : k];
  double x[4];
  int n = 0;
  // Both ends at zero: rare, and left to the other way.
  if (c[4] == 0.0) return sign_changes_by_cutting(p);
  n = quartic_roots(c[3] / c[4], c[2] / c[4], c[1] / c[4], c[0] / c[4], x);
  Bernstein slope;
  slope.degree = 3;
  for (std::size_t k = 0; k < 4; ++k) slope.c[k] = 4.0 * (p.c[k + 1] - p.c[k]);
  Bernstein bend;
  bend.degree = 2;
  for (std::size_t k = 0; k < 3; ++k) bend.c[k] = 3.0 * (slope.c[k + 1] - slope.c[k]);
  double t[4];
  int count = 0;
  const auto time_of = [&](double r) {
    const double at = (2.0 * r - 1.0) / (1.0 + r);
    return reversed ? 1.0 - at : at;
  };
  const auto add = [&](double at) {
    for (int step = 0; step < 16; ++step) {
      const double next = at - p.at(at) / slope.at(at);
      const double by = std::abs(next - at);
      if (!(by < 1e-2)) break;
      at = next;
      if (by < 1e-15) break;
    }
    // What rounding puts outside lies at the end, and is told by the sign there.
    if (!(at > 0.0 && at < 1.0)) return;
    int place = count++;
    for (; place > 0 && t[place - 1] > at; --place) t[place] = t[place - 1];
    t[place] = at;
  };
  for (int i = 0; i < n; i += 2) {
    double at[2] = {time_of(x[i]), time_of(x[i + 1])};
    // Two roots near each other lie on either side of an extremum, which is found well where they are not.
    if (std::abs(at[0] - at[1]) < 1e-2) {
      double middle = 0.5 * (at[0] + at[1]);
      for (int step = 0; step < 6; ++step) {
        const double next = middle - slope.at(middle) / bend.at(middle);
        if (!(std::abs(next - middle) < 2e-2)) break;
        middle = next;
      }
      const double squared = -2.0 * p.at(middle) / bend.at(middle);
      if (std::abs(squared) < 1e-4) {
        if (!(squared > 0.0)) continue;
        at[0] = middle - std::sqrt(squared);
        at[1] = middle + std::sqrt(squared);
      }
    }
    add(at[0]);
    add(at[1]);
  }
  SignChanges changes;
  changes.first = s.first;
  int sign = s.first;
  const auto change = [&](double at, int to) {
    if (to == 0 || to == sign || changes.count == 4) return;
    changes.at[static_cast<std::size_t>(changes.count++)] = at;
    sign = to;
  };
  // Roots that rounding has put outside are at the ends: the signs there tell.
  change(0.0, sign_of(p.at(0.5 * (count > 0 ? t[0] : 1.0))));
  for (int i = 0; i < count; ++i)
    change(t[i], sign_of(p.at(0.5 * (t[i] + (i + 1 < count ? t[i + 1] : 1.0)))));
  change(1.0, s.last);
  return changes;
}

}  // namespace

double Bernstein::at(double t) const {
  if (degree == 0) return c[0];
  const double u = 1.0 - t;
  const auto& binomial = bernstein_binomials[static_cast<std::size_t>(degree)];
  const auto last = static_cast<std::size_t>(degree);
  double power = 1.0, sum = c[0] * u;
  for (std::size_t k = 1; k < last; ++k) {
    power *= t;
    sum = (sum + power * binomial[k] * c[k]) * u;
  }
  return sum + power * t * c[last];
}

Bernstein Bernstein::part(double from, double to) const {
  Bernstein p = *this;
  const std::size_t n = size_of(p);
  // Right of `from`, then left of what `to` is there.
  if (from > 0.0)
    for (std::size_t level = 1; level < n; ++level)
      for (std::size_t k = 0; k + level < n; ++k) p.c[k] += from * (p.c[k + 1] - p.c[k]);
  if (to < 1.0) {
    const double share = from < 1.0 ? (to - from) / (1.0 - from) : 0.0;
    for (std::size_t level = 1; level < n; ++level)
      for (std::size_t k = n - 1; k >= level; --k) p.c[k] = p.c[k - 1] + share * (p.c[k] - p.c[k - 1]);
  }
  return p;
}

Bernstein Bernstein::raised(int to_degree) const {
  Bernstein p = *this;
  while (p.degree < to_degree) {
    const std::size_t n = size_of(p);
    const double degrees = static_cast<double>(n);
    p.c[n] = p.c[n - 1];
    for (std::size_t k = n - 1; k > 0; --k) {
      const double share = static_cast<double>(k) / degrees;
      p.c[k] = share * p.c[k - 1] + (1.0 - share) * p.c[k];
    }
    ++p.degree;
  }
  return p;
}

double Bernstein::largest() const {
  double most = 0.0;
  for (std::size_t k = 0; k < size_of(*this); ++k) most = std::max(most, std::abs(c[k]));
  return most;
}

Bernstein product(const Bernstein& a, const Bernstein& b) {
  Bernstein p;
  p.degree = a.degree + b.degree;
  const auto &of_a = bernstein_binomials[static_cast<std::size_t>(a.degree)],
             &of_b = bernstein_binomials[static_cast<std::size_t>(b.degree)],
             &of_p = bernstein_binomials[static_cast<std::size_t>(p.degree)];
  for (std::size_t i = 0; i < size_of(a); ++i)
    for (std::size_t j = 0; j < size_of(b); ++j) p.c[i + j] += (of_a[i] * a.c[i]) * (of_b[j] * b.c[j]);
  for (std::size_t k = 0; k < size_of(p); ++k) p.c[k] /= of_p[k];
  return p;
}

Bernstein difference(const Bernstein& a, const Bernstein& b) {
  Bernstein p = a;
  for (std::size_t k = 0; k < size_of(p); ++k) p.c[k] -= b.c[k];
  return p;
}

SignChanges sign_changes_by_cutting(const Bernstein& polynomial) {
  Bernstein p = polynomial;
  if (!in_range(p)) return {};
  Cutter cutter;
  cutter.add(p, 0.0, 1.0, 0);
  return cutter.changes;
}

int quadratic_sign_changes(const double* c, double* at) {
  // With r = t/(1 − t) it is c₀ + 2c₁r + c₂r²: roots above 0 are those sought.
  const double c0 = c[0], c1 = c[1], c2 = c[2];
  const double discriminant = difference_of_products(c1, c1, c0, c2);
  if (!(discriminant > 0.0)) return 0;
  const double root = std::sqrt(discriminant);
  const double q = c1 > 0.0 ? -(c1 + root) : root - c1;
  double r[2] = {q / c2, c0 / q};
  if (!(r[0] < r[1])) std::swap(r[0], r[1]);
  int count = 0;
  for (const double x : r) {
    // t = r/(1 + r): beyond 1 it is more exact by the inverse.
    if (!(x > 0.0) || !std::isfinite(x)) continue;
    at[count++] = x <= 1.0 ? x / (1.0 + x) : 1.0 / (1.0 + 1.0 / x);
  }
  return count;
}

SignChanges sign_changes_closed(const Bernstein& polynomial) {
  Bernstein p = polynomial;
  if (!in_range(p)) return {};
  const CoefficientSigns s = signs_of(p);
  SignChanges changes;
  changes.first = s.first;
  if (s.changes == 0) return changes;
  switch (p.degree) {
    case 1:
      changes.count = 1;
      changes.at[0] = p.c[0] / (p.c[0] - p.c[1]);
      return changes;
    case 2:
      changes.count = quadratic_sign_changes(p.c.data(), changes.at.data());
      return changes;
    case 4:
      return four_roots(p, s);
    default:
      return sign_changes_by_cutting(p);
  }
}

}  // namespace swept
