// The pixel filter of a disc: against the exact convolution, through edge-on, and in both of its limits.
#include "splat/kernel/moving_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "tests/oracle/hard_kernels.h"
#include "tests/oracle/oracle.h"

namespace swept {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using oracle::magnitude;
using oracle::Random;
using oracle::uniform;

constexpr double unit_roundoff = 0x1p-53;

/// A disc whose depth is a power of two, so that its tangent and the filter's radius there are exact.
struct Disc {
  Vector3d center, u, v;
  PixelFilter filter;

  [[nodiscard]] Vector2d tangent() const { return center.head<2>() / center.z(); }
  [[nodiscard]] double radius() const { return filter.radius * center.z(); }
  [[nodiscard]] double norm() const { return std::hypot(u.norm(), v.norm()); }
  [[nodiscard]] double shear() const { return 1.0 + tangent().norm(); }
  [[nodiscard]] FilteredDisc filtered() const { return filter_disc(center, u, v, filter); }
};

Disc some_disc(Random& random) {
  Disc disc;
  const double z = std::ldexp(1.0, static_cast<int>(random() % 12) - 4);
  disc.center = {z * uniform(random, -0.6, 0.6), z * uniform(random, -0.6, 0.6), z};
  disc.filter.radius = 0x1p-10;
  disc.filter.near = 0x1p-20;
  const double size = disc.radius() * std::abs(magnitude(random, -3.0, 3.0));
  Vector3d normal = oracle::direction(random);
  if (random() % 3 == 0) {  // edge-on or nearly so
    const Vector3d sight = disc.center.normalized();
    normal = (sight.cross(normal).normalized() + magnitude(random, -14.0, -1.0) * sight).normalized();
  }
  const Vector3d side = normal.unitOrthogonal();
  disc.u = size * side;
  disc.v = size * uniform(random, 0.2, 1.0) * normal.cross(side);
  return disc;
}

Eigen::Matrix<double, 2, 2> projected(const Disc& disc, const Vector3d& u, const Vector3d& v) {
  Matrix2d q;
  q.col(0) = u.head<2>() - disc.tangent() * u.z();
  q.col(1) = v.head<2>() - disc.tangent() * v.z();
  return q;
}

Matrix3d spread(const FilteredDisc& disc) {
  return disc.axis_u * disc.axis_u.transpose() + disc.axis_v * disc.axis_v.transpose();
}

TEST(FilterDisc, AFilterOfRadiusZeroReturnsTheDisc) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    Disc disc = some_disc(random);
    disc.filter.radius = 0.0;
    const FilteredDisc filtered = disc.filtered();
    EXPECT_EQ(filtered.axis_u, disc.u);
    EXPECT_EQ(filtered.axis_v, disc.v);
    EXPECT_EQ(filtered.weight, 1.0);
    disc.v = -2.0 * disc.u;
    EXPECT_EQ(disc.filtered().weight, 0.0);
  }
}

/// Q is off by 2 ε of its terms and the determinant by ε of its own, so the smaller singular value is off by
/// 8 ε (1 + |tangent|) |A|, the other by less; the weight changes by at most that over the filtered radius.
/// The size changes by that relative to its smallest slope's r/4, plus the roundings of its own sum.
TEST(FilterDisc, WeightAndSizeAreThoseOfTheConvolution) {
  Random random(2);
  for (int i = 0; i < 3000; ++i) {
    const Disc disc = some_disc(random);
    const FilteredDisc filtered = disc.filtered();
    const oracle::Filtered exact = oracle::filter(disc.u, disc.v, disc.tangent(), disc.radius());
    const Matrix2d q = projected(disc, disc.u, disc.v);
    const double minor = std::abs(q.determinant()) / std::max(q.col(0).norm(), q.col(1).norm());
    const double moved = 8 * unit_roundoff * disc.shear() * disc.norm();
    EXPECT_LE(oracle::error(filtered.weight, exact.weight),
              2 * moved / std::hypot(minor, disc.radius()) + 12 * unit_roundoff * exact.weight.high);
    EXPECT_LE(oracle::error(filtered.size, exact.size),
              exact.size.high * (moved / std::max(minor, 0.25 * disc.radius()) + 64 * unit_roundoff));
  }
}

/// Each axis' projection is off by 10 ε (1 + |tangent|) (|A| + r), and the product has two of them.
TEST(FilterDisc, ItsProjectionHasTheConvolvedCovariance) {
  Random random(3);
  for (int i = 0; i < 3000; ++i) {
    const Disc disc = some_disc(random);
    const FilteredDisc filtered = disc.filtered();
    const Matrix2d q = projected(disc, disc.u, disc.v), f = projected(disc, filtered.axis_u, filtered.axis_v);
    const double r = disc.radius();
    const Matrix2d difference = f * f.transpose() - q * q.transpose() - r * r * Matrix2d::Identity();
    const double size = disc.shear() * (disc.norm() + r);
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 4 * 10 * unit_roundoff * size * size);
  }
}

TEST(FilterDisc, DepthsStayWithinTheDiscsOwn) {
  Random random(4);
  for (int i = 0; i < 3000; ++i) {
    const Disc disc = some_disc(random);
    const FilteredDisc filtered = disc.filtered();
    EXPECT_LE(std::hypot(filtered.axis_u.z(), filtered.axis_v.z()),
              std::hypot(disc.u.z(), disc.v.z()) * (1 + 8 * unit_roundoff));
  }
}

/// Turning the axes within the plane is the same disc. The turned axes are rounded once more.
TEST(FilterDisc, DoesNotDependOnTheAxesWithinThePlane) {
  Random random(5);
  for (int i = 0; i < 3000; ++i) {
    const Disc disc = some_disc(random);
    Disc turned = disc;
    const double angle = uniform(random, 0.0, 6.28), c = std::cos(angle), s = std::sin(angle);
    turned.u = c * disc.u + s * disc.v;
    turned.v = c * disc.v - s * disc.u;
    const FilteredDisc a = disc.filtered(), b = turned.filtered();
    const Matrix2d q = projected(disc, disc.u, disc.v);
    const double minor = std::abs(q.determinant()) / std::max(q.col(0).norm(), q.col(1).norm());
    // As in WeightAndSize…, for both and for the turning.
    const double moved = 3 * 8 * unit_roundoff * disc.shear() * disc.norm();
    EXPECT_NEAR(a.weight, b.weight, 2 * moved / std::hypot(minor, disc.radius()) + 24 * unit_roundoff);
    EXPECT_NEAR(a.size, b.size,
                a.size * (moved / std::max(minor, 0.25 * disc.radius()) + 128 * unit_roundoff));
    // The lifted depth s/√(s² + r²) z changes by (|A|/r) of what s does, and each axis is rounded; they enter
    // AAᵀ twice with |A| + r.
    const double size = disc.shear() * (disc.norm() + disc.radius());
    const double lifted = disc.norm() / std::hypot(minor, disc.radius()) + 1.0;
    const double axis_error = moved * lifted + 8 * unit_roundoff * size;
    EXPECT_LE((spread(a) - spread(b)).cwiseAbs().maxCoeff(), 4 * axis_error * size);
  }
}

/// Turning through edge-on, in steps down to 10⁻¹² rad. The projection changes by |A| dθ, hence the lifted
/// depths by |A|/r of that, at each of several |A|/r.
TEST(FilterDisc, IsContinuousThroughEdgeOn) {
  for (const double ratio : {0.01, 0.3, 1.0, 3.0, 100.0}) {
    Disc disc;
    disc.center = {1.25, -0.5, 4.0};
    disc.filter.radius = 0x1p-10;
    const double size = ratio * disc.radius();
    const Vector3d sight = disc.center.normalized(), side = sight.unitOrthogonal(), up = sight.cross(side);
    const auto at = [&](double angle) {
      disc.u = size * side;
      disc.v = size * (std::cos(angle) * sight + std::sin(angle) * up);
      return disc.filtered();
    };
    for (const double step : {1e-2, 1e-5, 1e-8, 1e-12})
      for (int i = -3; i < 3; ++i) {
        const FilteredDisc a = at(i * step), b = at((i + 1) * step);
        const double scale = disc.shear() * (size + disc.radius());
        const double change = 4 * (step + 16 * unit_roundoff) * disc.shear() * (1.0 + ratio);
        EXPECT_LE((spread(a) - spread(b)).cwiseAbs().maxCoeff(), 2 * change * scale * scale) << ratio;
        EXPECT_NEAR(a.weight, b.weight, change) << ratio;
        // Of size², (1 + 4 · 4 / ratio … ) at most: own-plane slopes are capped at 4 (s² + r²)/r.
        EXPECT_NEAR(a.size, b.size, 17 * change * scale) << ratio;
      }
  }
}

/// Edge-on, the thin axis is r in the screen's plane; the smaller the disc, the more the other turns into it.
TEST(FilterDisc, EdgeOnItFacesTheScreen) {
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    Disc disc = some_disc(random);
    const Vector3d sight(disc.tangent().x(), disc.tangent().y(), 1.0);
    disc.v = 0.5 * disc.norm() * sight;
    const FilteredDisc filtered = disc.filtered();
    const double r = disc.radius();
    // The projection of v is 2 ε of its terms instead of zero.
    const double residue = 8 * unit_roundoff * disc.shear() * disc.norm();
    EXPECT_NEAR(filtered.axis_v.head<2>().norm(), r, residue * (1 + disc.norm() / r) + 8 * unit_roundoff * r);
    EXPECT_LE(std::abs(filtered.axis_v.z()), residue / r * disc.norm());
    EXPECT_LE(filtered.weight, 2 * residue / r);
    const double s = projected(disc, disc.u, disc.v).norm();
    EXPECT_LE(std::abs(filtered.axis_u.z()), std::min(1.0, s / r) * disc.norm() * (1 + 8 * unit_roundoff));
  }
}

/// Off its own plane by disc_z (√(s² + r²)/s − s/√(s² + r²)) = disc_z r² / (s √(s² + r²)) in depth.
TEST(FilterDisc, TendsToTheDiscsOwnPlaneAsItGrows) {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    Disc disc = some_disc(random);
    const Vector3d n = disc.u.cross(disc.v);
    const Matrix2d q = projected(disc, disc.u, disc.v);
    const double s_minor = Eigen::JacobiSVD<Matrix2d>(q).singularValues()[1], r = disc.radius();
    if (s_minor < 0.1 * r) continue;
    const FilteredDisc filtered = disc.filtered();
    for (const Vector3d& axis : {filtered.axis_u, filtered.axis_v}) {
      // Along the sight, from the axis' tip to the plane.
      const Vector3d sight(disc.tangent().x(), disc.tangent().y(), 1.0);
      const double off = std::abs(n.dot(axis) / n.dot(sight));
      const double depth = std::hypot(disc.u.z(), disc.v.z());
      const double slope_error =
          16 * unit_roundoff * disc.shear() * n.norm() * (disc.norm() + r) / std::abs(n.dot(sight));
      EXPECT_LE(off, depth * r * r / (s_minor * std::hypot(s_minor, r)) * (1 + 1e-9) + slope_error);
    }
  }
}

TEST(FilterDisc, IsFiniteForFiniteInput) {
  Random random(8);
  const auto any = [&] {
    switch (random() % 5) {
      case 0:
        return 0.0;
      case 1:
        return uniform(random, -2.0, 2.0);
      default:
        return std::ldexp(uniform(random, -1.0, 1.0), static_cast<int>(uniform(random, -1074.0, 1000.0)));
    }
  };
  for (int i = 0; i < 100000; ++i) {
    const Vector3d c(any(), any(), any()), u(any(), any(), any()), v(any(), any(), any());
    PixelFilter filter;
    filter.radius = random() % 3 ? 1e-3 : 0.0;
    const FilteredDisc disc = filter_disc(c, u, v, filter);
    ASSERT_TRUE(disc.axis_u.allFinite() && disc.axis_v.allFinite()) << i;
    ASSERT_TRUE(disc.weight >= 0.0 && disc.weight <= 1.0) << i << " " << disc.weight;
    ASSERT_TRUE(std::isfinite(disc.size)) << i;
  }
}

}  // namespace
}  // namespace swept
