#include "tests/oracle/oracle.h"

#include <algorithm>

#include <boost/math/constants/constants.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/special_functions/erf.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
// clang-tidy reads what GCC compiles, without this header of GCC's.
#if defined(SWEPT_QUADMATH) && !__has_include(<quadmath.h>)
#undef SWEPT_QUADMATH
#endif
#if defined(SWEPT_QUADMATH)
#include <boost/multiprecision/float128.hpp>
#endif

namespace swept::oracle {
namespace {

namespace mp = boost::multiprecision;
// No expression templates: plain values, quicker to compile.
using Fifty =
    mp::number<mp::cpp_bin_float<50, mp::digit_base_10, void, std::int32_t, -1000000, 1000000>, mp::et_off>;
#if defined(SWEPT_QUADMATH)
using Quad = mp::number<mp::float128_backend, mp::et_off>;  // some times quicker
#else
using Quad =
    mp::number<mp::cpp_bin_float<113, mp::digit_base_2, void, std::int32_t, -1000000, 1000000>, mp::et_off>;
#endif

template <class R>
Exact round_off(const R& value) {
  const double high = value.template convert_to<double>();
  return {high, R(value - R(high)).template convert_to<double>()};
}

/// The rounding of erf − erf is relative 2⁻¹⁶⁶ (2⁻¹¹³ in quad) of erf; the series takes over before the
/// difference loses eight bits of it.
template <class R>
R closed_mean(R a, R b) {
  if (a + b < 0) {
    const R mirrored = -a;
    a = -b;
    b = mirrored;
  }
  const R span = b - a, middle = (a + b) / 2;
  if (span * (1 + middle) < R(1) / 32) {
    R previous = 1, current = 2 * middle, sum = 1, scale = 1;
    for (int k = 1; k < 60; k += 2) {
      previous = 2 * middle * current - 2 * k * previous;
      scale *= span * span / (4 * (k + 1) * (k + 2));
      const R term = previous * scale;
      sum += term;
      if (abs(term) < std::numeric_limits<R>::epsilon() / 16) break;
      current = 2 * middle * previous - 2 * (k + 1) * current;
    }
    return exp(-middle * middle) * sum;
  }
  const R difference =
      a <= 0 ? R(boost::math::erf(b) + boost::math::erf(-a)) : R(boost::math::erfc(a) - boost::math::erfc(b));
  return difference * sqrt(boost::math::constants::pi<R>()) / (2 * span);
}

/// Integral of exp(a² − y²) from a to b, 0 ≤ a, in panels over which the exponent changes by 8.
Fifty scaled_panels(const Fifty& a, const Fifty& b) {
  Fifty sum = 0, from = a;
  const auto f = [&](const Fifty& y) { return Fifty(exp((a - y) * (a + y))); };
  // exp(−125) is below 10⁻⁵⁴ of the whole.
  const Fifty last = (std::min)(b, Fifty(sqrt(a * a + 125)));
  while (from < last) {
    const Fifty to = (std::min)(last, Fifty(sqrt(from * from + 8)));
    sum += boost::math::quadrature::gauss_kronrod<Fifty, 61>::integrate(f, from, to, 0);
    from = to;
  }
  return sum;
}

Fifty quadrature_mean(Fifty a, Fifty b) {
  if (a + b < 0) {
    const Fifty mirrored = -a;
    a = -b;
    b = mirrored;
  }
  if (a < 0) return (scaled_panels(0, -a) + scaled_panels(0, b)) / (b - a);
  return exp(-a * a) * scaled_panels(a, b) / (b - a);
}

using Vector = Eigen::Vector3d;

template <class R>
struct Vector3 {
  R x, y, z;
  Vector3(R x_, R y_, R z_) : x(std::move(x_)), y(std::move(y_)), z(std::move(z_)) {}
  explicit Vector3(const Vector& v) : x(v.x()), y(v.y()), z(v.z()) {}
};
template <class R>
R dot(const Vector3<R>& a, const Vector3<R>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class R>
Vector3<R> cross(const Vector3<R>& a, const Vector3<R>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class R>
Ray along_as(const MovingKernel& kernel, double x, double y) {
  using V = Vector3<R>;
  const V a(Vector(kernel.axis_u.cast<double>())), b(Vector(kernel.axis_v.cast<double>())), c(kernel.center),
      m(kernel.velocity), d(x, y, 1);
  const V n = cross(a, b);
  const R facing = dot(n, d);
  const auto ratio = [&](const R& value) { return round_off(R(value / facing)); };
  return {ratio(dot(d, cross(b, c))),
          ratio(dot(d, cross(c, a))),
          ratio(dot(n, c)),
          ratio(dot(d, cross(b, m))),
          ratio(dot(d, cross(m, a))),
          ratio(dot(n, m)),
          R(abs(facing) / sqrt(dot(n, n) * dot(d, d))).template convert_to<double>()};
}

}  // namespace

Exact mean_gaussian(double a, double b, Digits digits) {
  return digits == Digits::quad ? round_off(closed_mean<Quad>(a, b)) : round_off(closed_mean<Fifty>(a, b));
}

double quadrature_disagreement(double a, double b) {
  const Fifty closed = closed_mean<Fifty>(a, b);
  return Fifty(abs(quadrature_mean(a, b) / closed - 1)).convert_to<double>();
}

namespace {

template <class R>
Exact centroid_as(R a, R b) {
  const R span = b - a, middle = (a + b) / 2, mean = closed_mean<R>(a, b);
  const R ends = (exp(-a * a) - exp(-b * b)) / (2 * span);
  return round_off(R((ends - middle * mean) / (span * mean)));
}

}  // namespace

Exact gaussian_centroid(double a, double b, Digits digits) {
  return digits == Digits::quad ? centroid_as<Quad>(a, b) : centroid_as<Fifty>(a, b);
}

Ray along(const MovingKernel& kernel, double x, double y, Digits digits) {
  return digits == Digits::quad ? along_as<Quad>(kernel, x, y) : along_as<Fifty>(kernel, x, y);
}

namespace {

template <class R>
struct FragmentAs {
  R begin, end, peak, y_begin, rate, across;
};

/// False where there is none; `across` is set all the same.
template <class R>
bool intersect(const RayCoordinates<double>& ray, double segment_begin, double segment_end, double near,
               double delta, double weight, FragmentAs<R>& f) {
  const R u = ray.u, v = ray.v, z = ray.z, du = ray.du, dv = ray.dv, dz = ray.dz;
  const R t_mid = (R(segment_begin) + R(segment_end)) / 2;
  f.begin = segment_begin;
  f.end = segment_end;
  const R speed = sqrt(du * du + dv * dv);
  R squared = u * u + v * v, along_line = 0;
  if (speed > 0) {
    along_line = (u * du + v * dv) / speed;
    f.across = abs(u * dv - v * du) / speed;
    squared = f.across * f.across;
    if (squared > 1) return false;
    const R half = sqrt(1 - squared);
    f.begin = (std::max)(f.begin, R(t_mid + (-half - along_line) / speed));
    f.end = (std::min)(f.end, R(t_mid + (half - along_line) / speed));
  } else {
    f.across = sqrt(squared);
    if (squared > 1) return false;
  }
  if (dz > 0)
    f.begin = (std::max)(f.begin, R(t_mid + (near - z) / dz));
  else if (dz < 0)
    f.end = (std::min)(f.end, R(t_mid + (near - z) / dz));
  else if (z < near)
    return false;
  if (!(f.begin < f.end)) return false;
  f.peak = weight * exp(-delta * squared);
  f.rate = sqrt(R(delta)) * speed;
  f.y_begin = speed > 0 ? R(sqrt(R(delta)) * (along_line + speed * (f.begin - t_mid))) : R(0);
  return true;
}

template <class R>
Fragment intersect_as(const RayCoordinates<double>& ray, double segment_begin, double segment_end,
                      double near, double delta, double weight) {
  FragmentAs<R> f;
  Fragment fragment;
  fragment.hit = intersect(ray, segment_begin, segment_end, near, delta, weight, f);
  fragment.across = f.across.template convert_to<double>();
  if (!fragment.hit) return fragment;
  const R t_mid = (R(segment_begin) + R(segment_end)) / 2;
  fragment.t_begin = round_off(f.begin);
  fragment.t_end = round_off(f.end);
  fragment.peak = round_off(f.peak);
  fragment.rate = round_off(f.rate);
  fragment.y_begin = round_off(f.y_begin);
  fragment.z_begin = round_off(R(ray.z + R(ray.dz) * (f.begin - t_mid)));
  fragment.z_rate = {ray.dz, 0.0};
  return fragment;
}

template <class R>
Exact integral_as(const RayCoordinates<double>& ray, double segment_begin, double segment_end, double near,
                  double delta, double weight) {
  FragmentAs<R> f;
  if (!intersect(ray, segment_begin, segment_end, near, delta, weight, f)) return {};
  const R duration = f.end - f.begin;
  return round_off(R(f.peak * duration * closed_mean<R>(f.y_begin, R(f.y_begin + f.rate * duration))));
}

template <class R>
State state_as(const RayCoordinates<double>& ray, double t_mid, double t) {
  const R s = R(t) - R(t_mid), du = ray.du, dv = ray.dv;
  const R u = ray.u + s * du, v = ray.v + s * dv, speed = sqrt(du * du + dv * dv);
  State state{};
  state.radius_minus_one = R(sqrt(u * u + v * v) - 1).template convert_to<double>();
  state.z = R(ray.z + s * R(ray.dz)).template convert_to<double>();
  if (speed > 0) {
    state.along = R((u * du + v * dv) / speed).template convert_to<double>();
    state.across = R(abs(u * dv - v * du) / speed).template convert_to<double>();
  }
  return state;
}

template <class R>
Exact crossing_as(double z0, double rate0, double t0, double z1, double rate1, double t1) {
  const R value0 = R(z0) - R(rate0) * R(t0), value1 = R(z1) - R(rate1) * R(t1);
  return round_off(R((value0 - value1) / (R(rate1) - R(rate0))));
}

template <class R>
Filtered filter_as(const Eigen::Vector3d& axis_u, const Eigen::Vector3d& axis_v,
                   const Eigen::Vector2d& tangent, double radius) {
  const R tx = tangent.x(), ty = tangent.y(), r2 = R(radius) * radius;
  const R ux = axis_u.x() - tx * axis_u.z(), uy = axis_u.y() - ty * axis_u.z();
  const R vx = axis_v.x() - tx * axis_v.z(), vy = axis_v.y() - ty * axis_v.z();
  const R xx = ux * ux + vx * vx, xy = ux * uy + vx * vy, yy = uy * uy + vy * vy;
  const R determinant = (ux * vy - uy * vx) * (ux * vy - uy * vx);
  const R filtered = determinant + r2 * (xx + yy) + r2 * r2;
  // Squared singular values of Q, and the depth each carries: w = Rᵀ A_zᵀ.
  const R half_gap = sqrt((xx - yy) * (xx - yy) / 4 + xy * xy);
  const R major = (xx + yy) / 2 + half_gap, minor = major > 0 ? R(determinant / major) : R(0);
  const R uu = ux * ux + uy * uy, uv = ux * vx + uy * vy;
  // Unit eigenvector of QᵀQ for the major value.
  R p = uv, q = major - uu;
  const R p2 = major - (vx * vx + vy * vy);
  if (p2 * p2 + uv * uv > p * p + q * q) {
    p = p2;
    q = uv;
  }
  const R norm = sqrt(p * p + q * q);
  if (norm > 0) {
    p /= norm;
    q /= norm;
  } else {
    p = 1;
    q = 0;
  }
  const R z_major = p * axis_u.z() + q * axis_v.z(), z_minor = p * axis_v.z() - q * axis_u.z();
  const auto part = [&](const R& s2, const R& z) {
    const R floor = r2 / 16;
    return R((s2 + r2) * (1 + z * z / (std::max)(s2, floor)) / 2);
  };
  return {round_off(R(sqrt(determinant / filtered))),
          round_off(R(sqrt(part(major, z_major) + part(minor, z_minor))))};
}

}  // namespace

Fragment intersect_tube(const RayCoordinates<double>& ray, double segment_begin, double segment_end,
                        double near, double delta, double weight, Digits digits) {
  return digits == Digits::quad ? intersect_as<Quad>(ray, segment_begin, segment_end, near, delta, weight)
                                : intersect_as<Fifty>(ray, segment_begin, segment_end, near, delta, weight);
}

Exact fragment_integral(const RayCoordinates<double>& ray, double segment_begin, double segment_end,
                        double near, double delta, double weight, Digits digits) {
  return digits == Digits::quad ? integral_as<Quad>(ray, segment_begin, segment_end, near, delta, weight)
                                : integral_as<Fifty>(ray, segment_begin, segment_end, near, delta, weight);
}

State state_at(const RayCoordinates<double>& ray, double t_mid, double t, Digits digits) {
  return digits == Digits::quad ? state_as<Quad>(ray, t_mid, t) : state_as<Fifty>(ray, t_mid, t);
}

Exact crossing(double z0, double rate0, double t0, double z1, double rate1, double t1, Digits digits) {
  return digits == Digits::quad ? crossing_as<Quad>(z0, rate0, t0, z1, rate1, t1)
                                : crossing_as<Fifty>(z0, rate0, t0, z1, rate1, t1);
}

Filtered filter(const Eigen::Vector3d& axis_u, const Eigen::Vector3d& axis_v, const Eigen::Vector2d& tangent,
                double radius, Digits digits) {
  return digits == Digits::quad ? filter_as<Quad>(axis_u, axis_v, tangent, radius)
                                : filter_as<Fifty>(axis_u, axis_v, tangent, radius);
}

}  // namespace swept::oracle
