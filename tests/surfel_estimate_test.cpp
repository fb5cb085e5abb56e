// Discs from triangles and from nearest points, against grids whose answer is known.
#include "splat/io/surfel_estimate.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "splat/io/nearest_point.h"

namespace {

using namespace swept;
using Eigen::Vector3d;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

constexpr int kSide = 12;

/// A triangular grid of spacing h, rotated and put far away, rows of kSide.
std::vector<Vector3d> triangular_grid(double h, const Eigen::Quaterniond& turn, const Vector3d& origin) {
  std::vector<Vector3d> points;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      points.push_back(origin + turn * Vector3d(h * (i + 0.5 * j), h * std::sqrt(0.75) * j, 0.0));
    }
  }
  return points;
}
Triangles grid_triangles() {
  Triangles triangles;
  for (std::uint32_t j = 0; j + 1 < kSide; ++j) {
    for (std::uint32_t i = 0; i + 1 < kSide; ++i) {
      const std::uint32_t a = j * kSide + i, b = a + 1, c = a + kSide, d = c + 1;
      triangles.push_back({a, b, c});
      triangles.push_back({b, d, c});
    }
  }
  return triangles;
}
bool inside(std::size_t i) {
  const int x = static_cast<int>(i) % kSide, y = static_cast<int>(i) / kSide;
  return x >= 3 && y >= 3 && x < kSide - 3 && y < kSide - 3;
}
Vector3d front_of(const SurfelPose& pose, std::size_t i) {
  return pose.axis_u[i].cast<double>().cross(pose.axis_v[i].cast<double>());
}

const Eigen::Quaterniond kTurn = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized();

TEST(SurfelsFromMeshTest, TriangularGridGivesRoundDiscsOfTheStatedRadius) {
  const double h = 0.37;
  // Survey coordinates: the grid's own numbers are good to an ulp of 5.4e6, 1e-9.
  const auto points = triangular_grid(h, kTurn, {4.1e5, 5.4e6, 300.0});
  const auto surfels = surfels_from_mesh(points, grid_triangles());
  ASSERT_TRUE(surfels.ok());
  EXPECT_TRUE(surfels->unoriented.empty());
  EXPECT_TRUE(surfels->notes.empty());
  const double radius = kRadiusPerSpacing * h, tolerance = 4e-9 + 0x1p-23 * radius;
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(surfels->pose.position[i], points[i]);
    EXPECT_GT(front_of(surfels->pose, i).normalized().dot(kTurn * Vector3d::UnitZ()), 1.0 - 1e-6);
    if (!inside(i)) continue;
    EXPECT_NEAR(surfels->pose.axis_u[i].norm(), radius, tolerance);
    EXPECT_NEAR(surfels->pose.axis_v[i].norm(), radius, tolerance);
  }
}

TEST(SurfelsFromMeshTest, StretchedGridStretchesTheDiscs) {
  auto points = triangular_grid(1.0, Eigen::Quaterniond::Identity(), Vector3d::Zero());
  for (Vector3d& p : points) p.x() *= 4.0;
  const auto surfels = surfels_from_mesh(points, grid_triangles());
  ASSERT_TRUE(surfels.ok());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!inside(i)) continue;
    const Eigen::Vector3f &u = surfels->pose.axis_u[i], &v = surfels->pose.axis_v[i];
    EXPECT_NEAR(std::abs(u.x()), 5.0, 5e-6);
    EXPECT_NEAR(std::abs(v.y()), 1.25, 5e-6);
    EXPECT_LT(std::abs(u.y()) + std::abs(v.x()), 5e-6);
  }
}

TEST(SurfelsFromMeshTest, NarrowRingsKeepATenthAndLoneVerticesAreEstimated) {
  auto points = triangular_grid(1.0, Eigen::Quaterniond::Identity(), Vector3d::Zero());
  for (Vector3d& p : points) p.x() *= 1000.0;
  auto surfels = surfels_from_mesh(points, grid_triangles());
  ASSERT_TRUE(surfels.ok());
  const std::size_t middle = kSide * kSide / 2 + kSide / 2;
  EXPECT_NEAR(surfels->pose.axis_v[middle].norm() / surfels->pose.axis_u[middle].norm(), 0.1, 1e-6);

  points = triangular_grid(1.0, kTurn, Vector3d::Zero());
  const std::size_t lone = points.size();
  points.push_back(points[40] + 0.3 * (points[41] - points[40]));
  Triangles triangles = grid_triangles();
  const auto flat = static_cast<std::uint32_t>(points.size());
  points.push_back(points[0]);
  triangles.push_back({0, 0, flat});     // a corner twice
  triangles.push_back({flat, 0, flat});  // no area
  surfels = surfels_from_mesh(points, triangles);
  ASSERT_TRUE(surfels.ok());
  EXPECT_EQ(surfels->unoriented, (std::vector<std::size_t>{lone, flat}));
  ASSERT_EQ(surfels->notes.size(), 1u);
  EXPECT_EQ(surfels->notes[0].substr(0, 2), "2 ");
  EXPECT_GT(std::abs(front_of(surfels->pose, lone).normalized().dot(kTurn * Vector3d::UnitZ())), 1.0 - 1e-6);
  EXPECT_GT(surfels->pose.axis_u[lone].norm(), 0.5);
  EXPECT_LE(surfels->pose.axis_u[lone].norm(), kRadiusPerSpacing * (1.0 + 1e-6));
}

TEST(NearestPointTest, IsNoFartherThanAnyOther) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(-1.0, 1.0);
  std::vector<Vector3d> points;
  std::vector<std::size_t> among;
  for (std::size_t i = 0; i < 600; ++i) {
    // A third are copies, a third lie in a plane.
    points.emplace_back(anywhere(random), anywhere(random), i % 3 == 1 ? 0.0 : anywhere(random));
    if (i % 3 == 2) points.back() = points[i / 30];
    if (i % 2 == 0) among.push_back(i);
  }
  const NearestPoint nearest(points, among);
  for (int k = 0; k < 500; ++k) {
    const Vector3d place(2.0 * anywhere(random), anywhere(random), anywhere(random));
    double least = INFINITY;
    for (const std::size_t i : among) least = std::min(least, (points[i] - place).squaredNorm());
    const std::size_t found = nearest.to(place);
    EXPECT_EQ(found % 2, 0u);
    EXPECT_EQ((points[found] - place).squaredNorm(), least);
  }
  EXPECT_EQ(NearestPoint(points, {5}).to({9, 9, 9}), 5u);
}

TEST(SurfelsFromCloudTest, GridFarAwayWithDuplicates) {
  const double h = 0.37;
  PointSet set;
  set.position = triangular_grid(h, kTurn, {4.1e5, 5.4e6, 300.0});
  const std::size_t distinct = set.position.size();
  // Every point thirty times: more often than neighbours are asked for.
  for (int copy = 1; copy < 30; ++copy) {
    for (std::size_t i = 0; i < distinct; ++i) set.position.push_back(set.position[i]);
  }
  const auto surfels = surfels_from_cloud(set);
  ASSERT_TRUE(surfels.ok());
  EXPECT_EQ(surfels->unoriented.size(), set.size());
  EXPECT_EQ(surfels->notes.size(), 2u);
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (!inside(i % distinct)) continue;
    // Coordinates were rounded to float after recentring: 6 h across, half an ulp of it is 2e-7 h each.
    EXPECT_NEAR(surfels->pose.axis_u[i].norm(), kRadiusPerSpacing * h, 4e-6 * h);
    EXPECT_NEAR(surfels->pose.axis_v[i].norm(), kRadiusPerSpacing * h, 4e-6 * h);
    EXPECT_GT(std::abs(front_of(surfels->pose, i).normalized().dot(kTurn * Vector3d::UnitZ())), 1.0 - 1e-5);
  }
}

TEST(SurfelsFromCloudTest, GivenNormalsAndRadiiStay) {
  PointSet set;
  set.position = triangular_grid(1.0, kTurn, Vector3d::Zero());
  set.normal.assign(set.size(), Eigen::Vector3f(0, 0, -1));
  set.normal[7].setZero();
  set.radius.assign(set.size(), 0.5f);
  const auto surfels = surfels_from_cloud(set);
  ASSERT_TRUE(surfels.ok());
  EXPECT_EQ(surfels->unoriented, std::vector<std::size_t>{7});
  for (std::size_t i = 0; i < set.size(); ++i) {
    EXPECT_NEAR(surfels->pose.axis_u[i].norm(), 0.5, 1e-7);
    if (i != 7) {
      EXPECT_GT(front_of(surfels->pose, i).normalized().dot(-Vector3d::UnitZ()), 1.0 - 1e-6);
    }
  }
}

TEST(SurfelsFromCloudTest, OutliersAndTooFewPoints) {
  PointSet set;
  set.position = triangular_grid(1.0, kTurn, Vector3d::Zero());
  set.position.emplace_back(1e4, 0, 0);
  const auto surfels = surfels_from_cloud(set);
  ASSERT_TRUE(surfels.ok());
  EXPECT_NEAR(surfels->pose.axis_u.back().norm(), 10.0 * kRadiusPerSpacing, 0.1);
  EXPECT_NE(surfels->notes[1].find("1 radii shortened"), std::string::npos) << surfels->notes[1];

  PointSet same;
  same.position.assign(5, Vector3d(1, 2, 3));
  ASSERT_FALSE(surfels_from_cloud(same).ok());
  EXPECT_EQ(surfels_from_cloud(same).error().field, "radius");
  same.radius.assign(5, 0.1f);
  const auto given = surfels_from_cloud(same);
  ASSERT_TRUE(given.ok());
  EXPECT_NEAR(front_of(given->pose, 0).norm(), 0.01, 1e-8);
  same.position = {{0, 0, 0}, {3, 0, 0}};
  same.radius.clear();
  const auto two = surfels_from_cloud(same);
  ASSERT_TRUE(two.ok());
  EXPECT_NEAR(two->pose.axis_u[0].norm(), 3.0 * kRadiusPerSpacing, 1e-6);
}

}  // namespace
