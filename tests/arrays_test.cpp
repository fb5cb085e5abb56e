// Clouds from a caller's own arrays, and images into his own memory.
#include "splat/arrays.h"

#include <cstring>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include "abuffer/sampled.h"
#include "small_scenes.h"
#include "splat/pixel_target.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

struct Point {  // as a program may have it, with what is none of ours between
  float age = 1.0f;
  Vector3f color = {0.5f, 0.25f, 1.0f}, axis_u = {0.3f, 0, 0}, axis_v = {0, 0.3f, 0}, velocity = {0.5f, 0, 0};
  Vector3d position = Vector3d::Zero();
  float opacity = 0.75f, radius = 0.3f;
};

std::vector<Point> points() {
  std::vector<Point> points(50);
  test::Random random(3);
  for (Point& point : points) {
    point.position = random.vector(-1.0, 1.0);
    point.color = random.vector(0.0, 1.0).cast<float>();
    point.axis_u = random.vector(-0.2, 0.2).cast<float>();
    point.axis_v = random.vector(-0.2, 0.2).cast<float>();
    point.velocity = random.vector(-0.5, 0.5).cast<float>();
    point.opacity = static_cast<float>(random(0.2, 1.0));
  }
  return points;
}

template <class Member>
Strided<Member> member(const std::vector<Point>& points, Member Point::*which) {
  return {&(points.front().*which), points.size(), sizeof(Point)};
}

SurfelArrays arrays_of(const std::vector<Point>& points) {
  SurfelArrays arrays;
  arrays.position = member(points, &Point::position);
  arrays.axis_u = member(points, &Point::axis_u);
  arrays.axis_v = member(points, &Point::axis_v);
  arrays.velocity_per_frame = member(points, &Point::velocity);
  arrays.color = member(points, &Point::color);
  arrays.opacity = member(points, &Point::opacity);
  return arrays;
}

SurfelCloud copied(const std::vector<Point>& points) {
  SurfelCloud cloud;
  cloud.keys.resize(1);
  for (const Point& point : points) {
    cloud.keys[0].pose.position.push_back(point.position);
    cloud.keys[0].pose.axis_u.push_back(point.axis_u);
    cloud.keys[0].pose.axis_v.push_back(point.axis_v);
    cloud.velocity.push_back(point.velocity);
    cloud.color.push_back(point.color);
    cloud.opacity.push_back(point.opacity);
  }
  return cloud;
}

Image image_of(SurfelCloud cloud) {
  Scene scene = test::stage();
  scene.objects.emplace_back().cloud = std::move(cloud);
  return render_sampled(scene, {.samples = 8}).value().image;
}

TEST(Arrays, AreLookedIntoWhereTheyAre) {
  const std::vector<Point> table = points();
  const Result<SurfelCloud> cloud = cloud_from_arrays(arrays_of(table));
  ASSERT_TRUE(cloud) << cloud.error().message();
  const SurfelPose& pose = cloud->keys[0].pose;
  EXPECT_TRUE(pose.position.is_view() && pose.axis_u.is_view() && pose.axis_v.is_view());
  EXPECT_TRUE(cloud->velocity.is_view() && cloud->color.is_view() && cloud->opacity.is_view());
  EXPECT_EQ(&pose.position[7], &table[7].position);
  EXPECT_EQ(&cloud->opacity[49], &table[49].opacity);
}

TEST(Arrays, GiveTheBitsOfTheSameCloudCopied) {
  const std::vector<Point> table = points();
  const Result<SurfelCloud> cloud = cloud_from_arrays(arrays_of(table));
  ASSERT_TRUE(cloud);
  EXPECT_EQ(image_of(*cloud).rgba, image_of(copied(table)).rgba);
}

TEST(Arrays, BackwardsAreTheSamePicture) {
  const std::vector<Point> table = points();
  SurfelArrays arrays = arrays_of(table);
  const auto backwards = [](auto& array) {
    array.data = &array[array.count - 1];
    array.stride_bytes = -array.stride_bytes;
  };
  backwards(arrays.position);
  backwards(arrays.axis_u);
  backwards(arrays.axis_v);
  backwards(arrays.velocity_per_frame);
  backwards(arrays.color);
  backwards(arrays.opacity);
  const Result<SurfelCloud> cloud = cloud_from_arrays(arrays);
  ASSERT_TRUE(cloud);
  EXPECT_EQ(&cloud->keys[0].pose.position[0], &table[49].position);
  EXPECT_EQ(image_of(*cloud).rgba, image_of(copied(table)).rgba);
}

TEST(Arrays, ThatAreNotAlignedAreCopied) {
  const std::vector<Point> table = points();
  std::vector<char> bytes(50 * 25 + 1);
  for (std::size_t i = 0; i < 50; ++i) std::memcpy(&bytes[1 + 25 * i], table[i].position.data(), 24);
  SurfelArrays arrays = arrays_of(table);
  arrays.position = {reinterpret_cast<const Vector3d*>(&bytes[1]), 50, 25};
  const Result<SurfelCloud> cloud = cloud_from_arrays(arrays);
  ASSERT_TRUE(cloud);
  EXPECT_FALSE(cloud->keys[0].pose.position.is_view());
  EXPECT_TRUE(cloud->color.is_view());
  EXPECT_EQ(cloud->keys[0].pose.position, copied(table).keys[0].pose.position);
}

TEST(Arrays, OfSinglePrecisionNormalsAndRadii) {
  const std::vector<Vector3f> positions = {{1, 2, 3}, {4, 5, 6}}, normals = {{0, 0, 2}, {1, 1, 0}};
  const std::vector<float> one = {0.5f}, each = {0.5f, 0.25f};
  SurfelArrays arrays;
  arrays.position_single = positions;
  arrays.normal = normals;
  arrays.radius = one;
  Result<SurfelCloud> cloud = cloud_from_arrays(arrays);
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_EQ(std::as_const(cloud->keys[0].pose.position)[1], Vector3d(4, 5, 6));
  EXPECT_NEAR(std::as_const(cloud->keys[0].pose.axis_u)[1].norm(), 0.5f, 1e-6f);
  arrays.radius = each;
  cloud = cloud_from_arrays(arrays);
  ASSERT_TRUE(cloud);
  const SurfelPose& pose = cloud->keys[0].pose;
  EXPECT_NEAR(pose.axis_v[1].norm(), 0.25f, 1e-6f);
  EXPECT_NEAR(pose.axis_u[1].cross(pose.axis_v[1]).normalized().dot(normals[1].normalized()), 1.0f, 1e-6f);
}

TEST(Arrays, OfLooksAreLookedIntoAndChangeDuringTheExposure) {
  const std::vector<Point> table = points();
  std::vector<Point> later = table;
  for (Point& point : later) {
    point.color = Vector3f::Ones() - point.color;
    point.opacity *= 0.25f;
  }
  SurfelArrays arrays = arrays_of(table);
  arrays.color = {};
  arrays.opacity = {};
  arrays.looks = {{-0.25, member(table, &Point::color), member(table, &Point::opacity)},
                  {0.25, member(later, &Point::color), member(later, &Point::opacity)}};
  const Result<SurfelCloud> cloud = cloud_from_arrays(arrays);
  ASSERT_TRUE(cloud) << cloud.error().message();
  ASSERT_EQ(cloud->looks.size(), 2u);
  EXPECT_TRUE(cloud->looks[1].color.is_view());
  EXPECT_TRUE(cloud->looks[1].opacity.is_view());
  EXPECT_EQ(&std::as_const(cloud->looks[1].color)[7], &later[7].color);

  SurfelCloud same = copied(table);
  for (const LookKey& look : cloud->looks) {
    same.looks.push_back(look);
    same.looks.back().color.own();
    same.looks.back().opacity.own();
  }
  same.color.clear();
  same.opacity.clear();
  const Image image = image_of(*cloud);
  EXPECT_EQ(image.rgba, image_of(same).rgba);
  EXPECT_NE(image.rgba, image_of(copied(table)).rgba);
  // One of the two alone is another picture: what is not given is white, or opaque.
  arrays.looks[0].color = arrays.looks[1].color = {};
  EXPECT_NE(image_of(*cloud_from_arrays(arrays)).rgba, image.rgba);
}

TEST(Arrays, OfLooksThatAreWrongAreNamed) {
  const std::vector<Point> table = points();
  SurfelArrays good = arrays_of(table);
  good.color = {};
  good.opacity = {};
  good.looks = {{0.0, member(table, &Point::color), {}}, {1.0, {}, member(table, &Point::opacity)}};
  ASSERT_TRUE(cloud_from_arrays(good));
  const auto field_of = [&](const auto& spoil) {
    SurfelArrays arrays = good;
    spoil(arrays);
    const Result<SurfelCloud> cloud = cloud_from_arrays(arrays);
    return cloud ? std::string() : cloud.error().field;
  };
  EXPECT_EQ(field_of([&](SurfelArrays& a) { a.color = member(table, &Point::color); }), "color");
  EXPECT_EQ(field_of([&](SurfelArrays& a) { a.opacity = member(table, &Point::opacity); }), "opacity");
  EXPECT_EQ(field_of([](SurfelArrays& a) { a.looks[0].color.count = 49; }), "looks[0].color");
  EXPECT_EQ(field_of([](SurfelArrays& a) { a.looks[1].opacity.data = nullptr; }), "looks[1].opacity");
  EXPECT_EQ(field_of([](SurfelArrays& a) { a.looks[1].frame = 0.0; }), "looks[1].frame");
  std::vector<Point> spoilt = table;
  spoilt[5].color.y() = std::numeric_limits<float>::infinity();
  EXPECT_EQ(field_of([&](SurfelArrays& a) { a.looks[0].color = member(spoilt, &Point::color); }),
            "looks[0].color[5]");
}

TEST(Arrays, OfVelocitiesPerSecond) {
  const std::vector<Point> table = points();
  SurfelArrays arrays = arrays_of(table);
  arrays.velocity_per_second = arrays.velocity_per_frame;
  arrays.velocity_per_frame = {};
  arrays.frames_per_second = 32.0;
  const Result<SurfelCloud> cloud = cloud_from_arrays(arrays);
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->velocity[5], Vector3f(table[5].velocity / 32.0f));
}

TEST(Arrays, ThatAreWrongAreNamed) {
  std::vector<Point> table = points();
  const auto field_of = [](const SurfelArrays& arrays) {
    const Result<SurfelCloud> cloud = cloud_from_arrays(arrays);
    EXPECT_FALSE(cloud);
    if (cloud) return std::string();
    EXPECT_EQ(cloud.error().kind, ErrorKind::argument);
    return cloud.error().field;
  };
  const SurfelArrays good = arrays_of(table);
  EXPECT_EQ(field_of({}), "position");
  SurfelArrays arrays = good;
  arrays.color.count = 49;
  EXPECT_EQ(field_of(arrays), "color");
  arrays = good;
  arrays.axis_v = {};
  EXPECT_EQ(field_of(arrays), "axis_v");
  arrays = good;
  arrays.radius = member(table, &Point::radius);
  EXPECT_EQ(field_of(arrays), "axis_u");
  arrays = good;
  arrays.velocity_per_second = arrays.velocity_per_frame;
  EXPECT_EQ(field_of(arrays), "velocity_per_second");
  arrays = good;
  arrays.opacity.data = nullptr;
  EXPECT_EQ(field_of(arrays), "opacity");
  table[3].opacity = 2.0f;
  EXPECT_EQ(field_of(good), "opacity[3]");
  table[3].opacity = 0.5f;
  table[9].position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(field_of(good), "keys[0].pose.position[9]");
}

TEST(Arrays, OfSplats) {
  const std::vector<Vector3d> positions = {{0, 0, 0}, {1, 0, 0}};
  const std::vector<Vector3f> scales = {{0.1f, 0.2f, 0.3f}, {0.1f, 0.1f, 0.1f}};
  const std::vector<Eigen::Vector4f> rotations = {{2, 0, 0, 0}, {0, 0, 0, -3}};
  const std::vector<float> opacities = {0.5f, 1.0f}, harmonics = {1, 2, 3, 4, 5, 6};
  SplatArrays arrays;
  arrays.position = positions;
  arrays.scale = scales;
  arrays.rotation_wxyz = rotations;
  arrays.opacity = opacities;
  arrays.harmonics = harmonics;
  Result<SplatCloud> cloud = splats_from_arrays(arrays);
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_TRUE(cloud->position.is_view() && cloud->scale.is_view() && cloud->harmonics.is_view());
  EXPECT_EQ(std::as_const(cloud->rotation)[0].w(), 1.0f);
  EXPECT_EQ(std::as_const(cloud->rotation)[1].z(), -1.0f);
  arrays.harmonics.count = 5;
  cloud = splats_from_arrays(arrays);
  ASSERT_FALSE(cloud);
  EXPECT_EQ(cloud.error().field, "harmonics");
}

TEST(PointArray, OfAViewBecomesItsOwnWhenWritten) {
  const std::vector<float> theirs = {1, 2, 3, 4, 5, 6};
  PointArray<float> column = PointArray<float>::view({theirs.data(), 3, 2 * sizeof(float)});
  const PointArray<float> view = column;
  EXPECT_EQ(std::accumulate(view.begin(), view.end(), 0.0f), 9.0f);
  EXPECT_FALSE(view.contiguous());
  column[1] = 7.0f;
  EXPECT_FALSE(column.is_view());
  EXPECT_EQ(theirs[2], 3.0f);
  EXPECT_EQ(column, PointArray<float>({1, 7, 5}));
  EXPECT_EQ(view, PointArray<float>({1, 3, 5}));
}

TEST(PixelTarget, TakesTheImageWhereItIsToBe) {
  Image image = blank_image({3, 2, 0, 0, 0, 0});
  std::iota(image.rgba.begin(), image.rgba.end(), 0.0f);
  std::vector<float> packed(24, -1.0f);
  ASSERT_TRUE(copy_pixels(image, {packed.data(), 3, 2}));
  EXPECT_EQ(packed, image.rgba);
  // From the bottom up, without alpha, beside something else.
  std::vector<float> rows(2 * 11, -1.0f);
  ASSERT_TRUE(copy_pixels(image, {&rows[11], 3, 2, 3, 12, -44}));
  const std::vector<float> expected = {12, 13, 14, 16, 17, 18, 20, 21, 22, -1, -1,
                                       0,  1,  2,  4,  5,  6,  8,  9,  10, -1, -1};
  EXPECT_EQ(rows, expected);
}

TEST(PixelTarget, OfAnotherSizeIsAnError) {
  const Image image = blank_image({3, 2, 0, 0, 0, 0});
  std::vector<float> pixels(24, -1.0f);
  EXPECT_EQ(copy_pixels(image, {pixels.data(), 2, 3}).error().field, "width, height");
  EXPECT_EQ(copy_pixels(image, {pixels.data(), 3, 2, 1}).error().field, "channels");
  EXPECT_EQ(copy_pixels(image, {nullptr, 3, 2}).error().field, "data");
  EXPECT_EQ(pixels, std::vector<float>(24, -1.0f));
}

}  // namespace
}  // namespace swept
