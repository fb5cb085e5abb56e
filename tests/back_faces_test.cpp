// Backs of moving triangles: what is left out of one-sided meshes because it is never seen, and by the rule
// of Rönnow et al. 2021, section 4.4.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/sources/moving_mesh.h"
#include "abuffer/tiles/mesh_facing.h"
#include "tests/counter.h"
#include "tests/drawn.h"
#include "tests/mesh_scenes.h"

namespace swept {
namespace {

using Eigen::Vector3d;

/// A triangle on straight paths, right-angled on the film, with legs that each change their side: its area is
/// (t − ¼)(t − ¾), so that it shows one side between a quarter and three quarters of the exposure, the other
/// before and after.
Scene turns_over_and_back(bool front_first) {
  Scene scene = test::mesh_stage(32, 24, 0.5);
  Object& object = scene.objects.emplace_back();
  test::add_point(object, {-0.4, 0.4, 3}, {1, 1, 1});
  test::add_point(object, {-0.4 - 0.5, 0.4, 3}, {1, 1, 1});
  test::add_point(object, {-0.4, 0.4 - 1.5, 3}, {1, 1, 1});
  object.cloud.velocity.own() = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  object.triangles = {front_first ? Triangle{0, 2, 1} : Triangle{0, 1, 2}};
  object.two_sided = false;
  return scene;
}

double light_of(const Image& image) {
  double sum = 0.0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) sum += double{image.rgba[i]};
  return sum;
}

AbufferOptions both_ends() {
  AbufferOptions options;
  options.back_faces = BackFaces::both_ends;
  return options;
}

/// The rule is not exact where paths are straight, either.
TEST(BackFaces, AtBothEndsMayBeFrontsBetween) {
  const Scene front_between = turns_over_and_back(false), front_at_ends = turns_over_and_back(true);
  for (const Scene& scene : {front_between, front_at_ends}) {
    const Image image = test::exact(scene).image, truth = test::reference(scene, 1024);
    EXPECT_GT(light_of(image), 2.0);
    EXPECT_GT(test::psnr_db(image, truth), 70.0);
  }
  const Rendered dropped = test::exact(front_between, both_ends());
  EXPECT_EQ(light_of(dropped.image), 0.0);
  EXPECT_EQ(test::counter(dropped, "triangles_away_at_both_ends"), 1.0);
  EXPECT_EQ(test::counter(dropped, "triangles_facing_away"), 0.0);
  const Rendered kept = test::exact(front_at_ends, both_ends());
  EXPECT_EQ(kept.image.rgba, test::exact(front_at_ends).image.rgba);
  EXPECT_EQ(test::counter(kept, "triangles_away_at_both_ends"), 0.0);
  Scene beside = front_between;
  beside.objects.push_back(beside.objects[0]);
  beside.objects[0].two_sided = true;
  EXPECT_EQ(test::counter(test::exact(beside, both_ends()), "triangles_away_at_both_ends"), 1.0)
      << "of two-sided meshes nothing is left out";
}

/// Whether the corner's triangle shows its back where the camera is now.
bool away(const Scene& scene, const Object& object, std::size_t t, double frame) {
  const CameraInstant camera = scene.camera.at(frame);
  const Eigen::Affine3d world = object.transform.at(frame);
  Vector3d p[3];
  for (std::size_t i = 0; i < 3; ++i)
    p[i] = camera.camera_from_world.linear() *
           (world * surfel_at(object.cloud, object.triangles[t][i], frame).position - camera.eye);
  const double volume =
      camera.orthographic ? (p[1] - p[0]).cross(p[2] - p[0]).z() : p[0].dot(p[1].cross(p[2]));
  const bool mirrored =
      (world.linear().determinant() < 0.0) != (camera.camera_from_world.linear().determinant() < 0.0);
  return (volume > 0.0) != mirrored;
}

TEST(BackFaces, AreLeftOutWhereTheyAreSeenAllTheTime) {
  int always = 0, found = 0, away_at_ends = 0, between = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Scene scene = test::mesh_stage(16, 12, 0.5);
    scene.objects = {test::triangle_soup(60, seed, false, 0.4)};
    Object& object = scene.objects[0];
    object.two_sided = false;
    if (seed % 3 == 0) object.cloud.acceleration.assign(object.cloud.size(), {0.8f, -0.4f, 1.2f});
    if (seed % 4 == 0) {
      object.transform.keys.resize(2);
      object.transform.keys[1].frame = 1.0;
      for (TransformKey& key : object.transform.keys)
        key.scale = {-1.0, 1.0, 1.0}, key.translate = {0.0, 0.1 * key.frame, 0.0};
    }
    const Exposure exposure = scene.exposure();
    const Result<MovingMesh> mesh = MovingMesh::follow(scene, object, exposure, 0.01, {});
    ASSERT_TRUE(mesh.ok()) << mesh.error().message();
    for (std::size_t t = 0; t < object.triangles.size(); ++t) {
      bool by_polynomial = true, all = true;
      for (std::size_t s = 0; s < mesh->stretches(); ++s)
        by_polynomial = by_polynomial && always_faces_away(*mesh, s, t, false);
      for (int i = 0; i <= 256; ++i) all = all && away(scene, object, t, i / 256.0);
      EXPECT_TRUE(all || !by_polynomial) << seed << ' ' << t;
      const bool ends = away(scene, object, t, 0.0) && away(scene, object, t, 1.0);
      EXPECT_EQ(faces_away_at_both_ends(*mesh, t, false), ends) << seed << ' ' << t;
      always += all ? 1 : 0, found += by_polynomial ? 1 : 0;
      away_at_ends += ends ? 1 : 0, between += ends && !all ? 1 : 0;
    }
  }
  EXPECT_GT(always, 100);
  EXPECT_GT(between, 0) << "of " << away_at_ends;
  // Coefficients enclose the polynomial closely where it bends little.
  EXPECT_GT(found, always * 9 / 10);
  RecordProperty("between", between);
  RecordProperty("away_at_ends", away_at_ends);
}

/// A ball, which turns by 20°: half of it is never seen.
TEST(BackFaces, OfABallAreHalfOfIt) {
  Scene scene = test::mesh_stage(48, 36, 0.5);
  Object& ball = scene.objects.emplace_back();
  constexpr std::uint32_t rings = 16, sectors = 32;
  for (std::uint32_t j = 0; j <= rings; ++j)
    for (std::uint32_t i = 0; i < sectors; ++i) {
      const double a = M_PI * j / rings, b = 2.0 * M_PI * i / sectors;
      test::add_point(
          ball, {std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b)},
          {0.5f + 0.5f * static_cast<float>(std::cos(5.0 * b)), 0.5f, static_cast<float>(j) / rings});
      if (j == rings) continue;
      const std::uint32_t p = j * sectors + i, q = j * sectors + (i + 1) % sectors;
      ball.triangles.push_back({p, q, p + sectors});
      ball.triangles.push_back({q, q + sectors, p + sectors});
    }
  ball.transform.keys.resize(2);
  ball.transform.keys[1].frame = 1.0;
  for (TransformKey& key : ball.transform.keys)
    key.rotate_axis = Vector3d::UnitY(), key.translate = {0, 0, 3.5};
  ball.transform.keys[1].rotate_radians = 0.35;
  const Image both_sides = test::exact(scene).image;
  ball.two_sided = false;
  const Rendered front = test::exact(scene);
  const double stretches = test::counter(front, "segments");
  EXPECT_GT(test::counter(front, "triangles_facing_away"),
            0.4 * stretches * static_cast<double>(ball.triangles.size()));
  EXPECT_GT(test::psnr_db(front.image, both_sides), 100.0) << "it is closed";
  // What is left out shows at the rim, for a part of the exposure.
  EXPECT_GT(test::psnr_db(test::exact(scene, both_ends()).image, front.image), 60.0);
}

TEST(BackFaces, AreRefusedWhereTheyMeanNothing) {
  Scene scene = turns_over_and_back(true);
  scene.objects[0].two_sided = true;
  for (int i = 0; i < 2; ++i, scene.objects[0].triangles.clear()) {
    const Result<Rendered> refused = render_abuffer(scene, both_ends());
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().field, "back_faces");
    EXPECT_EQ(refused.error().kind, ErrorKind::unsupported);
  }
}

}  // namespace
}  // namespace swept
