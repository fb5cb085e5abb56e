// The nearest points that the search tree finds, against all points gone through one by one.
#include "splat/io/neighbourhood.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace {

using namespace swept;
using Eigen::Vector3d;
using Cloud = std::vector<Vector3d>;

/// Mean distance of the 6 nearest other points.
double spacing_by_hand(const Cloud& cloud, std::size_t i) {
  std::vector<double> distances;
  for (const Vector3d& p : cloud) distances.push_back((p - cloud[i]).norm());
  std::sort(distances.begin(), distances.end());
  const std::size_t count = std::min<std::size_t>(7, distances.size());
  return std::accumulate(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(count), 0.0) /
         static_cast<double>(count - 1);
}

Cloud random_cloud(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> coordinate;
  Cloud cloud(count);
  // Neither even nor centred, and of no simple shape.
  for (Vector3d& p : cloud) {
    p = {coordinate(random), std::exp(coordinate(random)), 0.01 * coordinate(random)};
  }
  return cloud;
}

/// Most points here have more than 12 points as near as the twelfth.
Cloud lattice(int side) {
  Cloud cloud;
  for (int i = 0; i < side * side * side; ++i) cloud.emplace_back(i % side, i / side % side, i / side / side);
  return cloud;
}

TEST(NeighbourhoodTest, SpacingIsThatOfTheNearestPoints) {
  for (const std::size_t count : {2, 3, 6, 7, 8, 13, 14, 500, 2000}) {
    const Cloud cloud = random_cloud(count, 1);
    const Neighbourhood neighbourhood(cloud);
    for (std::size_t i = 0; i < count; ++i) {
      const double expected = spacing_by_hand(cloud, i);
      // Positions are rounded to half an ulp of 1 in an extent of some 20.
      ASSERT_NEAR(neighbourhood.fit(i).spacing, expected, 20.0 * 0x1p-24 * 4.0) << i << " of " << count;
    }
  }
}

TEST(NeighbourhoodTest, NormalIsThatOfThePlane) {
  const Vector3d normal = Vector3d(0.3, -0.7, 0.5).normalized(), u = normal.unitOrthogonal();
  Cloud cloud;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 500; ++i) cloud.push_back(unit(random) * u + unit(random) * normal.cross(u));
  const Neighbourhood neighbourhood(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d found = neighbourhood.fit(i).normal;
    EXPECT_NEAR(found.norm(), 1.0, 1e-14);
    // Points are off the plane by an ulp of 1, over a tenth of it.
    EXPECT_NEAR(std::abs(found.dot(normal)), 1.0, 1e-10);
  }
}

TEST(NeighbourhoodTest, OrderOfThePointsChangesNoBit) {
  for (Cloud cloud : {random_cloud(1000, 3), lattice(9)}) {
    // With duplicates, far away.
    cloud.insert(cloud.end(), cloud.begin(), cloud.begin() + 100);
    for (Vector3d& p : cloud) p += Vector3d(4.1e5, 5.4e6, 300.0);
    std::vector<std::size_t> order(cloud.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937(4));
    Cloud shuffled;
    for (const std::size_t i : order) shuffled.push_back(cloud[i]);
    const Neighbourhood as_is(cloud), mixed(shuffled);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const LocalFit a = as_is.fit(order[i]), b = mixed.fit(i);
      ASSERT_EQ(a.spacing, b.spacing);
      ASSERT_EQ(a.normal, b.normal);
    }
  }
}

TEST(NeighbourhoodTest, TiesGoToTheLesserCoordinates) {
  // From -4 to 4: exact in the tree.
  Cloud cloud = lattice(9);
  for (Vector3d& p : cloud) p -= Vector3d(4, 4, 4);
  const Neighbourhood neighbourhood(cloud);
  int told_apart = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Cloud nearest = cloud;
    const auto before = [&](const Vector3d& a, const Vector3d& b) {
      const double in_a = (a - cloud[i]).squaredNorm(), in_b = (b - cloud[i]).squaredNorm();
      return in_a != in_b ? in_a < in_b
                          : std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    };
    std::sort(nearest.begin(), nearest.end(), before);
    Vector3d mean = Vector3d::Zero();
    for (int n = 0; n < 13; ++n) mean += nearest[n] / 13.0;
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    for (int n = 0; n < 13; ++n) moment += (nearest[n] - mean) * (nearest[n] - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moment);
    if (solver.eigenvalues()[1] - solver.eigenvalues()[0] < 0.1) continue;
    ++told_apart;
    ASSERT_NEAR(std::abs(neighbourhood.fit(i).normal.dot(solver.eigenvectors().col(0))), 1.0, 1e-12) << i;
  }
  EXPECT_GT(told_apart, 700);
}

TEST(NeighbourhoodTest, ExtremeCoordinates) {
  const double most = std::numeric_limits<double>::max();
  const Cloud huge = {{-most, -most, 0}, {most, most, 0}, {0, most, 0}, {0, 0, 0}};
  const Neighbourhood around(huge);
  for (std::size_t i = 0; i < huge.size(); ++i) {
    const LocalFit fit = around.fit(i);
    EXPECT_TRUE(fit.normal.allFinite());
    EXPECT_NEAR(std::abs(fit.normal.z()), 1.0, 1e-6);
  }
  const double least = std::numeric_limits<double>::denorm_min();
  const Cloud tiny = {{0, 0, 0}, {8 * least, 0, 0}, {0, 8 * least, 0}};
  const LocalFit fit = Neighbourhood(tiny).fit(0);
  EXPECT_NEAR(fit.spacing / least, 8.0, 1.0);
  EXPECT_EQ(Neighbourhood(Cloud(5, Vector3d(1, 2, 3))).fit(4).spacing, 0.0);
  EXPECT_EQ(Neighbourhood(Cloud(5, Vector3d(1, 2, 3))).fit(4).normal, Vector3d::UnitZ());
}

}  // namespace
