// Every file of the real data: counts as its header has them, discs that make sense of it.
#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "splat/io/cloud_source.h"
#include "splat/io/sequence.h"
#include "splat/io/surfel_estimate.h"
#include "tests/point_files.h"

namespace {

using namespace swept;
using Eigen::Vector3d;

LoadedCloud load(const std::string& path, bool skip_invalid = false) {
  CloudSource source;
  source.files = {{0.0, path}};
  source.skip_invalid = skip_invalid;
  Result<LoadedCloud> loaded = read_cloud(source, 0.0, 0.0);
  EXPECT_TRUE(loaded.ok()) << loaded.error().message();
  return loaded.ok() ? *std::move(loaded) : LoadedCloud{};
}

Vector3d front_of(const SurfelPose& pose, std::size_t i) {
  return pose.axis_u[i].cast<double>().cross(pose.axis_v[i].cast<double>()).normalized();
}

/// Σρ of all discs at the centre and the edge midpoints of every triangle, from the discs of the corners'
/// one-rings, seen along each disc's normal: the least of all.
double least_coverage(const PointSet& mesh, const SurfelPose& pose) {
  std::vector<std::vector<std::uint32_t>> ring(mesh.size());
  for (const auto& t : mesh.triangle) {
    for (const std::uint32_t corner : t) ring[corner].insert(ring[corner].end(), t.begin(), t.end());
  }
  double least = INFINITY;
  std::vector<std::uint32_t> near;
  for (const auto& t : mesh.triangle) {
    near.clear();
    for (const std::uint32_t corner : t) near.insert(near.end(), ring[corner].begin(), ring[corner].end());
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    const Vector3d &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
    for (const Vector3d& p : {Vector3d((a + b + c) / 3.0), Vector3d((a + b) / 2.0), Vector3d((b + c) / 2.0),
                              Vector3d((c + a) / 2.0)}) {
      double sum = 0.0;
      for (const std::uint32_t i : near) {
        const Vector3d u = pose.axis_u[i].cast<double>(), v = pose.axis_v[i].cast<double>();
        const Vector3d d = p - mesh.position[i];
        const double r2 = std::pow(d.dot(u) / u.squaredNorm(), 2) + std::pow(d.dot(v) / v.squaredNorm(), 2);
        if (r2 <= 1.0) sum += std::exp(-3.0 * r2);
      }
      least = std::min(least, sum);
    }
  }
  return least;
}

/// A mesh whose discs leave no holes: Σρ stays above ρ_edge = 0.5, where soft coverage is whole.
void expect_covered(const std::string& path, std::size_t points, std::size_t triangles) {
  const Result<PointSet> mesh = read_points(path);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message();
  EXPECT_EQ(mesh->size(), points);
  EXPECT_EQ(mesh->triangle.size(), triangles);
  const auto surfels = surfels_from_mesh(mesh->position, mesh->triangle);
  ASSERT_TRUE(surfels.ok());
  EXPECT_GT(least_coverage(*mesh, surfels->pose), 0.5) << path;
}

TEST(PointsDataTest, MeshesAreCoveredWithoutHoles) {
  SWEPT_DATA_OR_SKIP(data);
  expect_covered(data + "clothball/cloth_ball92.ply", 46598, 92230);
  expect_covered(data + "horse/0004.obj", 8431, 16843);
  // A closed surface of genus 0 has 2V - 4 triangles: no strip was lost or cut wrong.
  expect_covered(data + "points/igea.ply", 134345, 2 * 134345 - 4);
  expect_covered(data + "points/bun_zipper_original.ply", 35947, 69451);
}

TEST(PointsDataTest, ClosedMeshesFaceOutward) {
  SWEPT_DATA_OR_SKIP(data);
  for (const char* file : {"points/igea.ply", "horse/0001.obj"}) {
    const Result<PointSet> mesh = read_points(data + file);
    ASSERT_TRUE(mesh.ok());
    double volume = 0.0;  // positive: triangles are counter-clockwise from outside
    Vector3d center = Vector3d::Zero();
    for (const Vector3d& p : mesh->position) center += p / static_cast<double>(mesh->size());
    for (const auto& [a, b, c] : mesh->triangle) {
      volume +=
          (mesh->position[a] - center).dot((mesh->position[b] - center).cross(mesh->position[c] - center));
    }
    EXPECT_GT(volume, 0.0) << file;
    const LoadedCloud loaded = load(data + file);
    // By the divergence theorem Σ area · n · p is thrice the volume: discs face out on the whole.
    const SurfelPose& pose = loaded.cloud.keys[0].pose;
    double outward = 0.0;
    for (std::size_t i = 0; i < pose.size(); ++i) {
      outward +=
          pose.axis_u[i].cast<double>().cross(pose.axis_v[i].cast<double>()).dot(pose.position[i] - center);
    }
    EXPECT_GT(outward, 0.0) << file;
  }
}

TEST(PointsDataTest, BunnyCountsItsLoneVertices) {
  SWEPT_DATA_OR_SKIP(data);
  const LoadedCloud loaded = load(data + "points/bun_zipper_original.ply");
  ASSERT_EQ(loaded.notes.size(), 1u);
  EXPECT_NE(loaded.notes[0].find("1113 vertices"), std::string::npos) << loaded.notes[0];
}

TEST(PointsDataTest, ClothBallIsTwoKeys) {
  SWEPT_DATA_OR_SKIP(data);
  CloudSource source;
  source.files = {{92.0, data + "clothball/cloth_ball92.ply"}, {93.0, data + "clothball/cloth_ball93.ply"}};
  const Result<LoadedCloud> loaded = read_cloud(source, 92.0, 93.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  ASSERT_EQ(loaded->cloud.keys.size(), 2u);
  EXPECT_EQ(loaded->cloud.size(), 46598u);
  const SurfelPose &a = loaded->cloud.keys[0].pose, &b = loaded->cloud.keys[1].pose;
  std::size_t moved = 0;
  for (std::size_t i = 0; i < a.size(); ++i) moved += a.position[i] != b.position[i];
  EXPECT_EQ(moved, a.size());  // every vertex moves, says its README
}

TEST(PointsDataTest, HorseIsTwelveKeysWhoseDiscsKeepTheirAreaBetween) {
  SWEPT_DATA_OR_SKIP(data);
  const auto files = list_sequence(data + "horse/%04d.obj");
  ASSERT_TRUE(files.ok()) << files.error().message();
  CloudSource source;
  for (const NumberedFile& file : *files)
    source.files.push_back({static_cast<double>(file.number), file.path});
  const Result<LoadedCloud> loaded = read_cloud(source, 1.0, 12.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  ASSERT_EQ(loaded->cloud.keys.size(), 12u);
  EXPECT_EQ(loaded->cloud.size(), 8431u);
  // The mean of two aligned discs turned by θ against each other keeps cos²(θ/2) of their area and more: at
  // the 59° of the 99th percentile 0.76. Discs that are not aligned may keep nothing.
  std::size_t thin = 0, all = 0;
  for (std::size_t k = 0; k + 1 < 12; ++k) {
    for (std::size_t i = 0; i < loaded->cloud.size(); ++i, ++all) {
      const auto area = [&](double frame) {
        const SurfelInstant at = surfel_at(loaded->cloud, i, frame);
        return at.axis_u.cross(at.axis_v).norm();
      };
      const double frame = static_cast<double>(k + 1);
      thin += area(frame + 0.5) < 0.75 * std::min(area(frame), area(frame + 1.0));
    }
  }
  EXPECT_LT(static_cast<double>(thin), 0.01 * static_cast<double>(all));
}

TEST(PointsDataTest, EstimatedNormalsOfTheKittenAgreeWithThoseGiven) {
  SWEPT_DATA_OR_SKIP(data);
  const std::string path = data + "points/kitten.xyz";
  const Result<PointSet> given = read_points(path);
  ASSERT_TRUE(given.ok());
  ASSERT_EQ(given->size(), 5210u);
  ASSERT_EQ(given->normal.size(), 5210u);
  PointSet bare;
  bare.position = given->position;
  const auto estimated = surfels_from_cloud(bare);
  ASSERT_TRUE(estimated.ok());
  EXPECT_EQ(estimated->unoriented.size(), 5210u);
  std::size_t agree = 0;
  for (std::size_t i = 0; i < given->size(); ++i) {
    agree +=
        std::abs(front_of(estimated->pose, i).dot(given->normal[i].cast<double>())) > std::cos(M_PI / 6.0);
  }
  RecordProperty("agree", static_cast<int>(agree));
  EXPECT_GT(static_cast<double>(agree), 0.95 * 5210.0);
}

TEST(PointsDataTest, BuildingKeepsItsNormals) {
  SWEPT_DATA_OR_SKIP(data);
  const Result<PointSet> given = read_points(data + "points/building.ply");
  ASSERT_TRUE(given.ok());
  const LoadedCloud loaded = load(data + "points/building.ply");
  ASSERT_EQ(loaded.cloud.size(), 100000u);
  for (std::size_t i = 0; i < 100000; ++i) {
    ASSERT_GT(front_of(loaded.cloud.keys[0].pose, i).dot(given->normal[i].cast<double>()), 1.0 - 1e-5);
  }
}

TEST(PointsDataTest, SurveyKeepsItsDigitsAndCopesWithDuplicates) {
  SWEPT_DATA_OR_SKIP(data);
  const LoadedCloud loaded = load(data + "survey/samp11-utm.pcd");
  const SurfelPose& pose = loaded.cloud.keys[0].pose;
  ASSERT_EQ(pose.size(), 38010u);
  double low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < pose.size(); ++i) {
    low = std::min(low, pose.position[i].y());
    high = std::max(high, pose.position[i].y());
    ASSERT_GT(pose.axis_u[i].norm(), 0.0f) << i;  // though 4% of the points have a twin
    // The file's y are float: multiples of half a metre, and so they must arrive.
    ASSERT_EQ(pose.position[i].y() * 2.0, std::round(pose.position[i].y() * 2.0));
  }
  EXPECT_GT(low, 5.0e6);
  EXPECT_LT(high - low, 5.0e3);
}

TEST(PointsDataTest, LidarSweepsAreRead) {
  SWEPT_DATA_OR_SKIP(data);
  const std::size_t counts[] = {107647, 107357, 107532};
  for (int k = 0; k < 3; ++k) {
    const LoadedCloud loaded = load(data + "lidar/scan" + std::to_string(k) + ".ply");
    EXPECT_EQ(loaded.cloud.size(), counts[k]);
    // Reflectivities are greys, and the rest is told.
    ASSERT_EQ(loaded.cloud.color.size(), counts[k]);
    for (const Eigen::Vector3f& color : loaded.cloud.color) {
      ASSERT_EQ(color, Eigen::Vector3f::Constant(color.x()));
      ASSERT_LE(color.x(), 1.0f);
    }
    EXPECT_EQ(loaded.report.unread, (std::vector<std::string>{"t", "ring", "scan"}));
  }
}

TEST(PointsDataTest, GaussiansKeepScaleColourAndOpacity) {
  SWEPT_DATA_OR_SKIP(data);
  const LoadedCloud loaded = load(data + "gaussians/try_it7000.ply");
  ASSERT_EQ(loaded.cloud.size(), 9080u);
  ASSERT_EQ(loaded.cloud.opacity.size(), 9080u);
  ASSERT_EQ(loaded.cloud.color.size(), 9080u);
  std::vector<float> opacity(loaded.cloud.opacity.begin(), loaded.cloud.opacity.end());
  std::nth_element(opacity.begin(), opacity.begin() + 4540, opacity.end());
  EXPECT_NEAR(opacity[4540], 0.06, 0.005);  // "median 0.06", says its README
  const SurfelPose& pose = loaded.cloud.keys[0].pose;
  for (std::size_t i = 0; i < pose.size(); ++i) {
    const double lengths =
        static_cast<double>(pose.axis_u[i].norm()) * static_cast<double>(pose.axis_v[i].norm());
    // Columns of a rotation are orthogonal whatever the length of the quaternion; axes are rounded to float.
    ASSERT_LE(std::abs(pose.axis_u[i].cast<double>().dot(pose.axis_v[i].cast<double>())),
              4.0 * 0x1p-24 * lengths);
  }
}

}  // namespace
