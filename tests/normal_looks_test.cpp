// Colours by normals of discs that turn while the shutter is open.
#include "splat/io/normal_looks.h"

#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "splat/io/cloud_source.h"
#include "splat/motion/look.h"
#include "tests/image_difference.h"
#include "tests/point_files.h"
#include "tests/small_scenes.h"

namespace {

using namespace swept;
using Eigen::Vector3d;
using Eigen::Vector3f;
using swept_test::float_ply;
using swept_test::PointFiles;
class NormalLooks : public PointFiles {};

Vector3f shown(const Vector3d& normal) {
  return (0.5 * (normal.normalized() + Vector3d::Ones())).cast<float>();
}

Vector3f normal_color(const SurfelCloud& cloud, std::size_t i, double frame) {
  const SurfelInstant disc = surfel_at(cloud, i, frame);
  return shown(disc.axis_u.cross(disc.axis_v));
}

CloudSource by_normals(std::vector<KeyFile> files) {
  CloudSource source;
  source.files = std::move(files);
  source.color_by_normals = true;
  return source;
}

/// Discs with normals all round, each of which turns by up to `degrees` a second, at one frame a second.
std::string spinning(double degrees) {
  std::vector<std::vector<double>> rows;
  test::Random random(5);
  for (int i = 0; i < 60; ++i) {
    const Vector3d place = random.vector(-1.0, 1.0), normal = random.vector(-1.0, 1.0);
    const Vector3d spin = degrees * std::numbers::pi / 180.0 * random.vector(-1.0, 1.0).normalized();
    rows.push_back({place.x(), place.y(), place.z(), normal.x(), normal.y(), normal.z(), 0.3, spin.x(),
                    spin.y(), spin.z()});
  }
  return float_ply("ascii", {"x", "y", "z", "nx", "ny", "nz", "radius", "wx", "wy", "wz"}, rows);
}

/// What is true: the mean of stills, each in the colours of the normals at its own instant.
Image mean_of_stills(const SurfelCloud& cloud, int stills) {
  Scene scene = test::stage();
  Image sum;
  for (int k = 0; k < stills; ++k) {
    const double frame = -0.25 + 0.5 * (k + 0.5) / stills;
    SurfelCloud then = cloud;
    then.looks.clear();
    for (std::size_t i = 0; i < cloud.size(); ++i) then.color[i] = normal_color(cloud, i, frame);
    scene.objects.clear();
    scene.objects.emplace_back().cloud = std::move(then);
    scene.shutter.open = scene.shutter.close = frame - scene.frame;
    const Image still = render_sampled(scene).value().image;
    if (k == 0) {
      sum = still;
      continue;
    }
    for (std::size_t i = 0; i < sum.rgba.size(); ++i) sum.rgba[i] += still.rgba[i];
  }
  for (float& value : sum.rgba) value /= static_cast<float>(stills);
  return sum;
}

double psnr(const Image& image, const Image& truth) {
  return -20.0 * std::log10(test::difference_of(image, truth).color);
}

TEST_F(NormalLooks, ChangeWithDiscsThatSpin) {
  CloudSource source = by_normals({{0.0, write("spin.ply", spinning(160.0))}});
  source.fps = {1, 1};
  const Result<LoadedCloud> loaded = read_cloud(source, -0.25, 0.25);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  const SurfelCloud& cloud = loaded->cloud;
  ASSERT_GE(cloud.looks.size(), 9u);
  EXPECT_EQ(cloud.looks.front().frame, -0.25);
  EXPECT_EQ(cloud.looks.back().frame, 0.25);
  for (const double frame : {-0.25, -0.1, 0.02, 0.25}) {
    const LooksAt looks(cloud, frame);
    for (std::size_t i = 0; i < cloud.size(); ++i)
      EXPECT_LT((looks[i].head<3>() - normal_color(cloud, i, frame)).norm(), 1.0f / 256.0f) << frame;
  }

  Scene scene = test::stage();
  scene.shutter.open = -0.25 - scene.frame;
  scene.shutter.close = 0.25 - scene.frame;
  scene.objects.emplace_back().cloud = cloud;
  const Image truth = mean_of_stills(cloud, 96), image = render_sampled(scene, {.samples = 96}).value().image;
  const Image reference = render_reference(scene, {96, ReferenceMotion::smooth}).value().image;
  EXPECT_GT(psnr(image, reference), 100.0);
  scene.objects[0].cloud.looks.clear();
  const Image frozen = render_sampled(scene, {.samples = 96}).value().image;
  std::printf("against stills in the colours of their instants: %.1f dB, frozen %.1f dB\n",
              psnr(image, truth), psnr(frozen, truth));
  EXPECT_GT(psnr(image, truth), 60.0);  // chords of arcs of 10°: 0.5 (1 − cos 5°) · 2/3 of a colour, at most
  EXPECT_LT(psnr(frozen, truth), 45.0);
}

/// A row of discs of given normals.
std::string row(const std::vector<Vector3d>& normals, const std::vector<int>& ids = {}) {
  std::vector<std::vector<double>> rows;
  std::vector<std::string> names = {"x", "y", "z", "nx", "ny", "nz", "radius"};
  if (!ids.empty()) names.push_back("id");
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Vector3d& n = normals[i];
    rows.push_back({1.0 * (ids.empty() ? static_cast<int>(i) : ids[i]), 0, 0, n.x(), n.y(), n.z(), 1});
    if (!ids.empty()) rows.back().push_back(ids[i]);
  }
  return float_ply("ascii", names, rows);
}

TEST_F(NormalLooks, OfASequenceAreThoseOfItsFiles) {
  const Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  const CloudSource source =
      by_normals({{1.0, write("a.ply", row({x, y, z}))}, {2.0, write("b.ply", row({y, y, -z}))}});
  const Result<LoadedCloud> loaded = read_cloud(source, 1.0, 1.5);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  const std::vector<LookKey>& looks = loaded->cloud.looks;
  ASSERT_EQ(looks.size(), 2u);
  EXPECT_EQ(looks[1].frame, 2.0);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT((looks[0].color[i] - shown(std::vector{x, y, z}[i])).norm(), 1e-6f);
    EXPECT_LT((looks[1].color[i] - shown(std::vector<Vector3d>{y, y, -z}[i])).norm(), 1e-6f);
  }
}

TEST_F(NormalLooks, FollowPointsByTheirIds) {
  const Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  const CloudSource source = by_normals(
      {{1.0, write("a.ply", row({x, y, z}, {0, 1, 2}))}, {2.0, write("b.ply", row({x, y, z}, {2, 1, 0}))}});
  for (const double middle : {1.25, 1.75}) {  // the file whose colours the cloud has is the nearest
    const Result<LoadedCloud> loaded = read_cloud(source, middle - 0.2, middle + 0.2);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message();
    const SurfelCloud& cloud = loaded->cloud;
    ASSERT_EQ(cloud.looks.size(), 2u);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 2; ++k)
        EXPECT_LT((cloud.looks[k].color[i] - normal_color(cloud, i, cloud.keys[k].frame)).norm(), 1e-6f);
  }
}

TEST_F(NormalLooks, OfGuessedNormalsKeepTheSideThatWasAskedFor) {
  // A wall that turns by 40° about x: its normal is y, or −y.
  const auto wall = [](double angle) {
    std::vector<std::vector<double>> rows;
    for (int i = 0; i < 36; ++i) {
      const double z = i / 6 - 2.5;
      rows.push_back({i % 6 + 0.1 * (i / 6 % 2), -std::sin(angle) * z, std::cos(angle) * z});
    }
    return float_ply("ascii", {"x", "y", "z"}, rows);
  };
  for (const double side : {1.0, -1.0}) {
    CloudSource source = by_normals({{1.0, write("a.ply", wall(0.0))}, {2.0, write("b.ply", wall(0.7))}});
    source.normals_toward = {0, side, 0};
    const Result<LoadedCloud> loaded = read_cloud(source, 1.0, 2.0);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message();
    ASSERT_EQ(loaded->cloud.looks.size(), 2u);
    for (std::size_t i = 0; i < 36; ++i) {
      EXPECT_LT((loaded->cloud.looks[0].color[i] - shown({0, side, 0})).norm(), 1e-5f);
      EXPECT_LT(
          (loaded->cloud.looks[1].color[i] - shown(side * Vector3d(0, std::cos(0.7), std::sin(0.7)))).norm(),
          1e-5f);
    }
  }
}

TEST_F(NormalLooks, OfWhatDoesNotTurnAreNone) {
  const Vector3d x(1, 0, 0), y(0, 1, 0);
  const CloudSource moved =
      by_normals({{1.0, write("a.ply", row({x, y}))}, {2.0, write("b.ply", row({x, 2 * y}))}});
  EXPECT_TRUE(read_cloud(moved, 1.0, 2.0)->cloud.looks.empty());
  CloudSource still = by_normals({{0.0, write("spin.ply", spinning(160.0))}});
  EXPECT_TRUE(read_cloud(still, 0.0, 0.0)->cloud.looks.empty());
  still.fps = {1, 1};
  EXPECT_FALSE(read_cloud(still, 0.0, 0.5)->cloud.looks.empty());
  still.color_by_normals = false;
  EXPECT_TRUE(read_cloud(still, 0.0, 0.5)->cloud.looks.empty());
}

}  // namespace
