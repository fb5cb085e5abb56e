// Points that curve, spin or come and go in packets of their own: which they are, and that the picture stays
// the reference's whatever is beside what.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "abuffer/sources/path_groups.h"
#include "abuffer/sources/point_packets.h"
#include "abuffer/tiles/cells.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using Eigen::Vector3f;

/// A sphere of which every fourth point bends, every sixth spins, every tenth ends and every fourteenth
/// begins.
Scene mixed_scene() {
  Scene scene = test::stage();
  Object object = test::checkered_sphere(0.9, 700);
  SurfelCloud& cloud = object.cloud;
  cloud.velocity.assign(cloud.size(), Vector3f(0.4f, 0.1f, 0.0f));
  cloud.acceleration.assign(cloud.size(), Vector3f::Zero());
  cloud.angular_velocity.assign(cloud.size(), Vector3f::Zero());
  cloud.lifetime.assign(cloud.size(), {-10.0, 10.0});
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (i % 4 == 0) cloud.acceleration[i] = {0.2f, 1.0f, 0.3f};
    if (i % 6 == 0) cloud.angular_velocity[i] = {0.5f, 0.9f, 0.0f};
    if (i % 10 == 0) cloud.lifetime[i].gone = 0.4;
    if (i % 14 == 0) cloud.lifetime[i].born = 0.3;
  }
  scene.objects = {std::move(object)};
  return scene;
}

TEST(PathGroups, HoldEveryPointOnceByWhatItDoes) {
  const Scene scene = mixed_scene();
  const SurfelCloud& cloud = scene.objects[0].cloud;
  const std::vector<PathGroup> groups = path_groups(cloud, {0.0, 1.0});
  EXPECT_EQ(groups.size(), 8u);
  std::vector<int> seen(cloud.size());
  for (const PathGroup& group : groups) {
    EXPECT_EQ(group.degree(cloud), group.curved ? 2u : 1u);
    EXPECT_FALSE(group.points.empty());
    for (const std::uint32_t i : group.points) {
      ++seen[i];
      EXPECT_EQ(group.curved, i % 4 == 0) << i;
      EXPECT_EQ(group.spins, i % 6 == 0) << i;
      EXPECT_EQ(group.mortal, i % 10 == 0 || i % 14 == 0) << i;
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(cloud.size()));
}

TEST(PathGroups, KeyedPointsThatGoStraightAndEvenlyAreStraight) {
  for (const KeyPath path : {KeyPath::spline, KeyPath::bezier}) {
    SurfelCloud cloud;
    cloud.path = path;
    for (const double frame : {0.0, 1.0, 2.0, 3.0}) {
      SurfelKey& key = cloud.keys.emplace_back();
      key.frame = frame;
      const auto f = static_cast<float>(frame);
      key.pose.position = {
          {1.0, 2.0, 3.0}, {0.1 * frame, 5e6, 0.0}, {0.1 * frame * frame, 0.0, 0.0}, {0, 0, 0}};
      key.pose.axis_u.assign(4, Vector3f(0.01f, 0.0f, 0.0f));
      key.pose.axis_v.assign(4, Vector3f(0.0f, 0.01f, 0.0f));
      key.pose.axis_u[3] = Vector3f(0.01f, 0.001f * f * f, 0.0f);
    }
    const std::vector<double> frames =
        path == KeyPath::spline ? std::vector<double>{0.0, 1.0, 2.0, 3.0} : std::vector<double>{0.0, 3.0};
    const std::vector<PathGroup> groups = path_groups(cloud, frames);
    ASSERT_EQ(groups.size(), 2u);
    EXPECT_EQ(groups[0].points, (std::vector<std::uint32_t>{0, 1}));
    EXPECT_EQ(groups[1].points, (std::vector<std::uint32_t>{2, 3}));
    EXPECT_TRUE(groups[1].curved);
    // An instant has no paths.
    EXPECT_EQ(path_groups(cloud, {0.5}).size(), 1u);
  }
}

TEST(PathGroups, AnyMixIsTheReferences) {
  const Scene scene = mixed_scene();
  const auto truth = render_reference(scene, {96, ReferenceMotion::smooth});
  SampledOptions options;
  options.samples = 96;
  const auto rendered = render_sampled(scene, options);
  ASSERT_TRUE(truth.ok() && rendered.ok());
  EXPECT_LE(test::difference_of(rendered->image, truth->image).color, 1e-5);
  EXPECT_EQ(rendered->statistics.counter("surfels"), 700.0);
}

TEST(PathGroups, OrderOfPointsChangesNoBit) {
  Scene scene = mixed_scene();
  SampledOptions options;
  options.samples = 9;
  const auto before = render_sampled(scene, options);
  SurfelCloud& cloud = scene.objects[0].cloud;
  const SurfelCloud was = cloud;
  std::vector<std::size_t> order(cloud.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t from = order[i];
    cloud.keys[0].pose.position[i] = was.keys[0].pose.position[from];
    cloud.keys[0].pose.axis_u[i] = was.keys[0].pose.axis_u[from];
    cloud.keys[0].pose.axis_v[i] = was.keys[0].pose.axis_v[from];
    cloud.acceleration[i] = was.acceleration[from];
    cloud.angular_velocity[i] = was.angular_velocity[from];
    cloud.lifetime[i] = was.lifetime[from];
    cloud.color[i] = was.color[from];
  }
  const auto after = render_sampled(scene, options);
  ASSERT_TRUE(before.ok() && after.ok());
  EXPECT_EQ(before->image.rgba, after->image.rgba);
}

TEST(PathGroups, AFewFastPointsDoNotDecideForTheirCells) {
  Scene scene = test::stage();
  scene.film = {256, 256, 0, 0, 0, 0};
  Object object = test::checkered_sphere(1.2, 20000);
  SurfelCloud& cloud = object.cloud;
  cloud.velocity.assign(cloud.size(), Vector3f(0.1f, 0.0f, 0.0f));
  cloud.lifetime.assign(cloud.size(), {-10.0, 10.0});
  for (std::size_t i = 0; i < cloud.size(); i += 200) cloud.lifetime[i].gone = 0.5;
  scene.objects = {std::move(object)};
  const Exposure exposure = scene.exposure();
  const std::vector<PointPackets> packets = pack_points(scene, exposure);
  ASSERT_EQ(packets.size(), 2u);
  std::size_t mortal = 0;
  for (const PointPackets& group : packets)
    if (group.mortal) mortal += group.count;
  // Left among their neighbours they would be in every thirteenth packet or more.
  EXPECT_EQ(mortal, (100 + packet_size - 1) / packet_size);
}

}  // namespace
}  // namespace swept
