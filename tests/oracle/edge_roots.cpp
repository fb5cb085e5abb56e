#include "tests/oracle/edge_roots.h"

#include <cstddef>

#include <boost/multiprecision/cpp_bin_float.hpp>

namespace swept::oracle {
namespace {

namespace mp = boost::multiprecision;
using Fifty = mp::number<mp::cpp_bin_float<50>, mp::et_off>;
using Quad = mp::number<mp::cpp_bin_float<113, mp::digit_base_2>, mp::et_off>;

template <class R>
R value_of(const std::vector<R>& powers, const R& t) {
  R v = 0;
  for (std::size_t k = powers.size(); k-- > 0;) v = v * t + powers[k];
  return v;
}

template <class R>
int sign_of(const R& v) {
  return v > 0 ? 1 : v < 0 ? -1 : 0;
}

template <class R>
std::vector<R> derivative(const std::vector<R>& powers) {
  std::vector<R> d;
  for (std::size_t k = 1; k < powers.size(); ++k) d.push_back(powers[k] * R(static_cast<int>(k)));
  return d;
}

/// Between `low`, whose sign is `below`, and `high`: halves, then Newton's steps, which no extremum disturbs.
template <class R>
R between(const std::vector<R>& powers, R low, R high, int below) {
  for (int i = 0; i < 44; ++i) {
    const R half = (low + high) / 2;
    (sign_of(value_of(powers, half)) == below ? low : high) = half;
  }
  const std::vector<R> slope = derivative(powers);
  R t = (low + high) / 2;
  for (int i = 0; i < 4; ++i) {
    const R by = value_of(slope, t);
    if (by == 0) break;
    const R next = t - value_of(powers, t) / by;
    if (!(next >= low && next <= high)) break;
    t = next;
  }
  return t;
}

template <class R>
std::vector<R> changes_of(const std::vector<R>& powers) {
  if (powers.size() < 2) return {};
  std::vector<R> places = changes_of(derivative(powers)), found;
  places.insert(places.begin(), R(0));
  places.push_back(R(1));
  int last = 0;
  R from = 0;
  for (const R& place : places) {
    const int sign = sign_of(value_of(powers, place));
    if (last != 0 && sign == -last) found.push_back(between(powers, from, place, last));
    if (sign == 0) continue;
    last = sign;
    from = place;
  }
  return found;
}

template <class R>
std::vector<Exact> exact_of(const double* c, int degree) {
  // binomial(n, k) tᵏ (1 − t)^(n − k), multiplied out.
  std::vector<R> powers(static_cast<std::size_t>(degree) + 1, R(0));
  const auto choose = [](int n, int k) {
    R b = 1;
    for (int i = 1; i <= k; ++i) b = b * (n - k + i) / i;
    return b;
  };
  for (int k = 0; k <= degree; ++k)
    for (int j = 0; j <= degree - k; ++j)
      powers[static_cast<std::size_t>(k + j)] +=
          R(c[k]) * choose(degree, k) * choose(degree - k, j) * (j % 2 == 0 ? 1 : -1);
  std::vector<Exact> exact;
  for (const R& t : changes_of(powers)) {
    const double high = t.template convert_to<double>();
    exact.push_back({high, R(t - R(high)).template convert_to<double>()});
  }
  return exact;
}

}  // namespace

std::vector<Exact> sign_changes(const double* c, int degree, Digits digits) {
  return digits == Digits::fifty ? exact_of<Fifty>(c, degree) : exact_of<Quad>(c, degree);
}

}  // namespace swept::oracle
