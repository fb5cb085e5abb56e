// Arrays of a caller: wrong lengths, numbers and indices are errors that name them, at every public entry.
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "splat/io/cloud_source.h"
#include "splat/io/surfel_estimate.h"

namespace {

using namespace swept;
using Eigen::Vector3f;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Four points in a square, two triangles, and everything that may be said about them but axes.
PointSet square() {
  PointSet set;
  set.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  set.normal.assign(4, Vector3f(0, 0, 2));
  set.radius.assign(4, 0.5f);
  set.color.assign(4, Vector3f(1, 0.5f, 0));
  set.opacity.assign(4, 1.0f);
  set.velocity.assign(4, Vector3f(1, 0, 0));
  set.triangle = {{0, 1, 2}, {1, 3, 2}};
  return set;
}

struct Case {
  const char* field;
  std::function<void(PointSet&)> spoil;
};

std::vector<Case> cases() {
  return {
      {"position", [](PointSet& s) { s = {}; }},
      {"position[2]", [](PointSet& s) { s.position[2].y() = std::nan(""); }},
      {"position[3]", [](PointSet& s) { s.position[3].z() = -HUGE_VAL; }},
      {"normal", [](PointSet& s) { s.normal.pop_back(); }},
      {"normal[1]", [](PointSet& s) { s.normal[1].x() = kNaN; }},
      {"radius", [](PointSet& s) { s.radius.push_back(1.0f); }},
      {"radius[0]", [](PointSet& s) { s.radius[0] = -1.0f; }},
      {"radius[3]", [](PointSet& s) { s.radius[3] = kInfinity; }},
      {"radius[2]", [](PointSet& s) { s.radius[2] = kNaN; }},
      {"axis_u", [](PointSet& s) { s.axis_u = s.axis_v = {Vector3f(1, 0, 0)}; }},
      {"axis_v", [](PointSet& s) { s.axis_u.assign(4, Vector3f(1, 0, 0)); }},
      {"axis_u", [](PointSet& s) { s.axis_v.assign(4, Vector3f(1, 0, 0)); }},
      {"axis_v[1]",
       [](PointSet& s) {
         s.axis_u = s.axis_v = std::vector<Vector3f>(4, Vector3f(1, 0, 0));
         s.axis_v[1].z() = kInfinity;
       }},
      {"color", [](PointSet& s) { s.color.resize(1); }},
      {"color[0]", [](PointSet& s) { s.color[0].x() = kNaN; }},
      {"opacity", [](PointSet& s) { s.opacity.resize(5); }},
      {"opacity[1]", [](PointSet& s) { s.opacity[1] = 1.5f; }},
      {"opacity[2]", [](PointSet& s) { s.opacity[2] = kNaN; }},
      {"velocity", [](PointSet& s) { s.velocity.resize(3); }},
      {"id",
       [](PointSet& s) {
         s.id = {1, 2, 3};
       }},
      {"velocity[3]", [](PointSet& s) { s.velocity[3].y() = kInfinity; }},
      {"triangle[1]", [](PointSet& s) { s.triangle[1][2] = 4; }},
      {"triangle[0]", [](PointSet& s) { s.triangle[0][0] = 0xffffffff; }},
  };
}

TEST(PointChecksTest, EveryFaultOfAPointSetIsNamedByEveryEntryThatTakesIt) {
  ASSERT_TRUE(square().validate().ok()) << square().validate().error().message();
  ASSERT_TRUE(cloud_from_points(square(), 0.0, {}).ok());
  ASSERT_TRUE(surfels_from_cloud(square()).ok());
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.field);
    PointSet set = square();
    c.spoil(set);
    ASSERT_FALSE(set.validate().ok());
    EXPECT_EQ(set.validate().error().field, c.field);
    EXPECT_FALSE(set.validate().error().reason.empty());
    ASSERT_FALSE(surfels_from_cloud(set).ok());
    EXPECT_EQ(surfels_from_cloud(set).error().field, c.field);
    const auto cloud = cloud_from_points(set, 0.0, {});
    ASSERT_FALSE(cloud.ok());
    EXPECT_EQ(cloud.error().field, c.field);
  }
  EXPECT_EQ(cloud_from_points(square(), std::nan(""), {}).error().field, "frame");
}

TEST(PointChecksTest, Meshes) {
  PointSet set = square();
  ASSERT_TRUE(surfels_from_mesh(set.position, set.triangle).ok());
  ASSERT_TRUE(surfels_from_mesh({}, {}).ok());
  set.triangle[1][0] = 4;
  EXPECT_EQ(surfels_from_mesh(set.position, set.triangle).error().field, "triangle[1]");
  EXPECT_EQ(surfels_from_mesh({}, set.triangle).error().field, "triangle[0]");
  set = square();
  set.position[1].x() = std::nan("");
  EXPECT_EQ(surfels_from_mesh(set.position, set.triangle).error().field, "position[1]");
}

TEST(PointChecksTest, DiscsBeyondFloatAreAnError) {
  PointSet set;
  for (const double x : {0.0, 1e300, 1.5e308}) set.position.emplace_back(x, -x, 0);
  EXPECT_EQ(surfels_from_cloud(set).error().field, "radius");
  EXPECT_EQ(surfels_from_mesh(set.position, {{0, 1, 2}}).error().field, "radius");
  EXPECT_EQ(surfels_from_mesh(set.position, {}).error().field, "radius");
  EXPECT_EQ(cloud_from_points(set, 0.0, {}).error().field, "radius");
}

TEST(PointChecksTest, ColoursByNormalsOfACloudThatIsNone) {
  SurfelCloud cloud;
  EXPECT_EQ(color_by_normals(cloud).error().field, "keys");
  cloud.keys.push_back({0.0, {{{0, 0, 0}, {1, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}, {0, 1, 0}}}});
  EXPECT_EQ(color_by_normals(cloud).error().field, "keys[0].pose.axis_u");
  EXPECT_TRUE(cloud.color.empty());
  cloud.keys[0].pose.axis_u.emplace_back(1, 0, 0);
  ASSERT_TRUE(color_by_normals(cloud).ok());
  EXPECT_EQ(cloud.color[1], Vector3f(0.5f, 0.5f, 1.0f));
}

}  // namespace
