// Clouds of PCL in and out.
#include "splat/io/pcl/point_cloud.h"

#include <limits>

#include <gtest/gtest.h>

/// A point of one's own, with what only Swept makes use of.
struct MovingPoint {
  float x = 0, y = 0, z = 0;
  float vx = 0, vy = 0, vz = 0;
};

namespace {

using namespace swept;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// A 5 × 5 grid of spacing 1 in z = 2, of any type of point.
template <class P>
pcl::PointCloud<P> grid() {
  pcl::PointCloud<P> cloud;
  for (int i = 0; i < 25; ++i) {
    P p;
    p.x = static_cast<float>(i % 5), p.y = static_cast<float>(i / 5), p.z = 2.0f;
    cloud.push_back(p);
  }
  return cloud;
}

template <class P>
class PclTypesTest : public ::testing::Test {};
using Types =
    ::testing::Types<pcl::PointXYZ, pcl::PointXYZI, pcl::PointXYZL, pcl::PointXYZRGB, pcl::PointXYZRGBA,
                     pcl::PointXYZRGBL, pcl::PointNormal, pcl::PointXYZINormal, pcl::PointXYZRGBNormal,
                     pcl::PointSurfel, pcl::PointWithViewpoint, MovingPoint>;
TYPED_TEST_SUITE(PclTypesTest, Types);

TYPED_TEST(PclTypesTest, GetsTheSameDiscsAsThePointsAlone) {
  PointSet bare;
  for (int i = 0; i < 25; ++i) bare.position.emplace_back(i % 5, i / 5, 2.0);
  const auto expected = cloud_from_points(bare, 3.0, {});
  const auto found = cloud_from_pcl(grid<TypeParam>(), 3.0);
  ASSERT_TRUE(found.ok()) << found.error().message();
  ASSERT_EQ(found->cloud.keys.size(), 1u);
  EXPECT_EQ(found->cloud.keys[0].frame, 3.0);
  const SurfelPose &a = expected->cloud.keys[0].pose, &b = found->cloud.keys[0].pose;
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.axis_u, b.axis_u);
  EXPECT_EQ(a.axis_v, b.axis_v);
}

TYPED_TEST(PclTypesTest, ComesBackWhereItWas) {
  const auto cloud = cloud_from_pcl(grid<TypeParam>(), 0.0);
  ASSERT_TRUE(cloud.ok());
  const auto back = pcl_from_cloud<TypeParam>(cloud->cloud, 0.0);
  ASSERT_TRUE(back.ok()) << back.error().message();
  ASSERT_EQ(back->size(), 25u);
  for (int i = 0; i < 25; ++i) {
    EXPECT_EQ((*back)[i].x, static_cast<float>(i % 5));
    EXPECT_EQ((*back)[i].y, static_cast<float>(i / 5));
    EXPECT_EQ((*back)[i].z, 2.0f);
  }
}

TEST(PclTest, NormalsColoursAndRadiiAreTakenAndGivenBack) {
  pcl::PointCloud<pcl::PointSurfel> cloud = grid<pcl::PointSurfel>();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud[i].normal_x = 3.0f;
    cloud[i].radius = 0.25f + 0.5f * static_cast<float>(i);
    cloud[i].r = static_cast<std::uint8_t>(10 * i), cloud[i].g = 255, cloud[i].b = 128;
  }
  const auto loaded = cloud_from_pcl(cloud, 0.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  EXPECT_TRUE(loaded->notes.empty());
  EXPECT_NEAR(loaded->cloud.color[3].z(), 0.2158605f, 1e-6f);  // 128 of 255 in linear light
  const auto back = pcl_from_cloud(loaded->cloud, 0.0);
  ASSERT_TRUE(back.ok());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const pcl::PointSurfel& p = (*back)[i];
    EXPECT_NEAR(p.normal_x, 1.0f, 1e-6f);
    EXPECT_NEAR(p.radius, cloud[i].radius, 1e-6f * cloud[i].radius);
    EXPECT_EQ(p.r, cloud[i].r);
    EXPECT_EQ(p.g, 255);
    EXPECT_EQ(p.b, 128);
    EXPECT_EQ(p.a, 255);
  }
}

TEST(PclTest, WhatIsNotFiniteIsAnErrorOrDropped) {
  pcl::PointCloud<pcl::PointNormal> cloud = grid<pcl::PointNormal>();
  cloud[7].y = kNaN;
  cloud[9].normal_x = kNaN;
  const auto refused = cloud_from_pcl(cloud, 0.0);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "position[7]");
  CloudSource source;
  source.skip_invalid = true;
  const auto dropped = cloud_from_pcl(cloud, 0.0, source);
  ASSERT_TRUE(dropped.ok());
  EXPECT_EQ(dropped->cloud.size(), 24u);
  ASSERT_GE(dropped->notes.size(), 2u);
  EXPECT_EQ(dropped->notes[0].substr(0, 2), "1 ");
  EXPECT_EQ(dropped->notes[1].substr(0, 15), "dropped 1 of 25");
  EXPECT_EQ(cloud_from_pcl(pcl::PointCloud<pcl::PointXYZ>{}, 0.0).error().field, "position");
}

TEST(PclTest, WhatIsLeftUnreadIsSaid) {
  pcl::PointCloud<pcl::PointXYZI> cloud = grid<pcl::PointXYZI>();
  cloud.sensor_origin_ = {1.0f, 0.0f, 0.0f, 0.0f};
  const auto points = points_from_pcl(cloud);
  ASSERT_TRUE(points.ok());
  EXPECT_EQ(points->notes, (std::vector<std::string>{"the intensity is left unread",
                                                     "the cloud's sensor pose is not applied"}));
  const auto surfels = points_from_pcl(grid<pcl::PointSurfel>());
  ASSERT_TRUE(surfels.ok());
  EXPECT_TRUE(surfels->radius.empty());
  EXPECT_EQ(surfels->notes, std::vector<std::string>{"the radii are all zero, and count as not given"});
}

TEST(PclTest, VelocitiesOfOnesOwnPointsMoveThem) {
  pcl::PointCloud<MovingPoint> cloud = grid<MovingPoint>();
  for (MovingPoint& p : cloud) p.vx = 48.0f;
  CloudSource source;
  source.fps = {24, 1};
  const auto loaded = cloud_from_pcl(cloud, 10.0, source);
  ASSERT_TRUE(loaded.ok());
  EXPECT_EQ(loaded->cloud.velocity[0], Vector3f(2, 0, 0));
  const auto later = pcl_from_cloud<pcl::PointXYZ>(loaded->cloud, 11.5);
  ASSERT_TRUE(later.ok());
  EXPECT_EQ((*later)[0].x, 3.0f);
}

TEST(PclTest, CoordinatesOfASurveyNeedAnOrigin) {
  SurfelCloud cloud;
  const Vector3d far(4.1e5 + 0.001, 5.4e6, 300.0);
  cloud.keys.push_back({0.0, {{far}, {{1, 0, 0}}, {{0, 4, 0}}}});
  const auto points = pcl_from_cloud(cloud, 0.0, {4.1e5, 5.4e6, 0.0});
  ASSERT_TRUE(points.ok());
  EXPECT_NEAR((*points)[0].x, 0.001f, 1e-8f);
  EXPECT_EQ((*points)[0].z, 300.0f);
  EXPECT_EQ((*points)[0].radius, 2.0f);  // of the round disc of the same area
  EXPECT_EQ((*points)[0].r, 255);

  cloud.keys[0].pose.position[0].x() = 1e200;
  EXPECT_EQ(pcl_from_cloud(cloud, 0.0).error().field, "position[0]");
  EXPECT_EQ(pcl_from_cloud(cloud, std::nan("")).error().field, "frame");
  EXPECT_EQ(pcl_from_cloud(cloud, 0.0, {0, std::nan(""), 0}).error().field, "origin");
  cloud.color.resize(2, Vector3f::Zero());
  EXPECT_EQ(pcl_from_cloud(cloud, 0.0).error().field, "color");
  EXPECT_TRUE(pcl_from_cloud(SurfelCloud{}, 0.0).ok());
}

}  // namespace
