#include "splat/io/scene_file.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/scene_text.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::base_scene;
using test::base_source;
using test::dots;
using test::matrix_scene;
using test::replaced;

class SceneFiles : public test::SceneFiles {
 protected:
  SceneFile read(const std::string& text, const SceneOverrides& overrides = {}) const {
    Result<SceneFile> file = read_scene_file(write(text), overrides);
    EXPECT_TRUE(file.ok()) << file.error().message();
    if (!file.ok()) std::abort();  // nothing after it would make sense
    return std::move(*file);
  }
};

TEST_F(SceneFiles, EverythingArrives) {
  SceneFile file = read(base_scene);
  const Result<const Scene*> loaded = file.scene_at(3.0, dots);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  const Scene& scene = **loaded;
  EXPECT_EQ(scene.frame, 3.0);
  EXPECT_EQ(scene.film.width, 320);
  EXPECT_EQ(scene.film.height, 180);
  EXPECT_EQ(scene.fps.numerator, 24000);
  EXPECT_EQ(scene.fps.denominator, 1001);
  EXPECT_EQ(scene.shutter.open, -0.25);
  EXPECT_EQ(scene.model.segments, 2);
  EXPECT_EQ(scene.camera.near, 0.01);
  ASSERT_EQ(scene.camera.look_ats.size(), 2u);
  EXPECT_EQ(scene.camera.look_ats[1].frame, 9.0);
  EXPECT_DOUBLE_EQ(scene.camera.look_ats[1].tan_half_fov_y, std::tan(std::numbers::pi / 9));
  ASSERT_EQ(scene.objects.size(), 1u);
  const Object& object = scene.objects[0];
  EXPECT_EQ(object.name, "knot");
  EXPECT_EQ(object.cloud.size(), 3u);
  EXPECT_FALSE(object.two_sided);
  EXPECT_EQ(object.segments, 4);
  ASSERT_EQ(object.transform.keys.size(), 2u);
  EXPECT_EQ(object.transform.keys[0].rotate_axis, Vector3d::UnitY());
  EXPECT_DOUBLE_EQ(object.transform.keys[1].rotate_radians, 4 * std::numbers::pi);
  EXPECT_EQ(object.transform.keys[1].translate, Vector3d(1, 2, 3));
  const Status valid = scene.validate();
  EXPECT_TRUE(valid.ok()) << valid.error().message();
}

TEST_F(SceneFiles, TheDocumentedExampleIsRead) {
  const std::string readme = test::content_of(SWEPT_SCENE_MANUAL), fence = "```json\n";
  const std::size_t begin = readme.find(fence);
  ASSERT_NE(begin, std::string::npos);
  const std::size_t end = readme.find("```", begin + fence.size());
  const SceneFile file = read(readme.substr(begin + fence.size(), end - begin - fence.size()));
  EXPECT_EQ(file.sources().size(), 2u);
}

TEST_F(SceneFiles, DefaultsAreThoseOfTheTypes) {
  const SceneFile file = read(R"({"swept": 1, "objects": [],
    "camera": {"fov": {"axis": "vertical", "degrees": 90}, "keys": [{"eye": [0,0,5], "target": [0,0,0]}]}})");
  const Scene expected, &scene = file.scene();
  EXPECT_EQ(scene.frame, 1.0);
  EXPECT_EQ(scene.film.width, expected.film.width);
  EXPECT_EQ(scene.fps.numerator, expected.fps.numerator);
  EXPECT_EQ(scene.shutter.close, expected.shutter.close);
  EXPECT_EQ(scene.background, expected.background);
  EXPECT_EQ(scene.model.edge_weight, expected.model.edge_weight);
  EXPECT_EQ(scene.camera.look_ats[0].up, Vector3d::UnitY());
}

TEST_F(SceneFiles, FieldOfViewFollowsItsAxis) {
  // 400 × 300 has a diagonal of 500.
  for (const auto& [axis, tangent] :
       {std::pair{"vertical", 1.0}, {"horizontal", 300.0 / 400.0}, {"diagonal", 300.0 / 500.0}}) {
    std::string text = replaced(base_scene, "\"axis\": \"vertical\", \"degrees\": 40",
                                std::string("\"axis\": \"") + axis + "\", \"degrees\": 90");
    SceneOverrides overrides;
    overrides.fields = {{"/film/width", {400}}, {"/film/height", {300}}};
    EXPECT_DOUBLE_EQ(read(text, overrides).scene().camera.look_ats[0].tan_half_fov_y, tangent) << axis;
  }
}

/// Of a picture of 640 × 480; another film shows the same height of it.
TEST_F(SceneFiles, IntrinsicsAreThoseOfAPictureOfTheirSize) {
  const std::string fov = R"("fov": {"axis": "vertical", "degrees": 40})";
  const auto lens = [&](const std::string& intrinsics) {
    return replaced(base_scene, fov, "\"intrinsics\": {\"width\": 640, \"height\": 480, " + intrinsics + "}");
  };
  const Scene scene = read(lens(R"("fx": 600, "fy": 480, "cx": 300, "cy": 288)")).scene();
  for (const LookAtKey& key : scene.camera.look_ats) {
    EXPECT_DOUBLE_EQ(key.tan_half_fov_y, 0.5);
    EXPECT_DOUBLE_EQ(key.lens.stretch_x, 1.25);
    EXPECT_DOUBLE_EQ(key.lens.shift.x(), -20.0 / 480.0);
    EXPECT_DOUBLE_EQ(key.lens.shift.y(), 48.0 / 480.0);
  }
  const Scene plain = read(lens(R"("fx": 480)")).scene();
  EXPECT_DOUBLE_EQ(plain.camera.look_ats[0].tan_half_fov_y, 0.5);
  EXPECT_EQ(plain.camera.look_ats[0].lens, Lens());
  // A key's own comes before the camera's, and may be a field of view.
  const std::string key = R"("target": [0, 0, 0], "up": [0, 1, 0])";
  const Scene zoom = read(replaced(lens(R"("fx": 600, "fy": 480)"), key, key + ", " + fov)).scene();
  EXPECT_EQ(zoom.camera.look_ats[0].lens, Lens());
  EXPECT_DOUBLE_EQ(zoom.camera.look_ats[1].lens.stretch_x, 1.25);
}

TEST_F(SceneFiles, RollIsInDegrees) {
  const std::string key = R"("target": [0, 0, 0], "up": [0, 1, 0])";
  const Scene scene = read(replaced(base_scene, key, key + R"(, "roll": -180)")).scene();
  EXPECT_DOUBLE_EQ(scene.camera.look_ats[0].roll_radians, -std::numbers::pi);
  EXPECT_EQ(scene.camera.look_ats[1].roll_radians, 0.0);
}

TEST_F(SceneFiles, MatrixIsCameraToWorldInOpenGlAxesUnlessSaidOtherwise) {
  // Both say: eye at (1, 2, 8), looking along −z, y up.
  const SceneFile opengl = read(matrix_scene("[1,0,0,1, 0,1,0,2, 0,0,1,8, 0,0,0,1]"));
  const SceneFile opencv =
      read(matrix_scene("[1,0,0,1, 0,-1,0,2, 0,0,-1,8, 0,0,0,1]", R"("convention": "opencv", )"));
  for (const SceneFile* file : {&opengl, &opencv}) {
    const CameraInstant camera = file->scene().camera.at(0.0);
    EXPECT_EQ(camera.camera_from_world * Vector3d(1, 2, 3), Vector3d(0, 0, 5));
    EXPECT_EQ(camera.camera_from_world * Vector3d(2, 3, 3), Vector3d(1, -1, 5));
  }
}

TEST_F(SceneFiles, RoundedMatricesBecomeRotations) {
  // A turn by 30 degrees with four decimals.
  const SceneFile file = read(matrix_scene("[0.8660,0,0.5000,0, 0,1,0,0, -0.5000,0,0.8660,0, 0,0,0,1]"));
  const Eigen::Matrix3d r = file.scene().camera.at(0.0).camera_from_world.linear();
  EXPECT_LE((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(),
            1e-15);  // 16 products of a few ulp each
}

TEST_F(SceneFiles, TheLastRowOfAMatrixMayBeRoundedToo) {
  for (const char* row : {"0,0,1e-17,1", "-1e-4,0,0,0.9999", "0,0,0,1"}) {
    const SceneFile file = read(matrix_scene(std::string("[1,0,0,0, 0,1,0,0, 0,0,1,5, ") + row + "]"));
    EXPECT_EQ(file.scene().camera.at(0.0).eye, Vector3d(0, 0, 5)) << row;
  }
  for (const char* row : {"0,0,0.001,1", "0,0,0,1.001", "0,0,0,0"}) {
    EXPECT_FALSE(
        scene_from_text(matrix_scene(std::string("[1,0,0,0, 0,1,0,0, 0,0,1,5, ") + row + "]"), "s.json"))
        << row;
  }
}

TEST_F(SceneFiles, GeneratedCloudsTakeTheObjectsAttributes) {
  const std::string text = replaced(base_scene, "\"name\": \"knot\"",
                                    R"("color": [0.5, 0.25, 1], "radius": 0.125, "radius_scale": 2,
                                       "velocity": {"unit": "ignore"})");
  SceneOverrides overrides;
  overrides.points_scale = 2.0;
  SceneFile file = read(text, overrides);
  const Result<const Scene*> scene = file.scene_at(1.0, dots);
  ASSERT_TRUE(scene.ok()) << scene.error().message();
  const SurfelCloud& cloud = (*scene)->objects[0].cloud;
  ASSERT_EQ(cloud.size(), 6u);
  EXPECT_TRUE(cloud.velocity.empty());
  EXPECT_EQ(cloud.color.back(), Vector3f(0.5f, 0.25f, 1.0f));
  const SurfelPose& pose = cloud.keys[0].pose;
  const Vector3f normal = pose.axis_u[5].cross(pose.axis_v[5]);
  // Single precision: 4 ulp of the numbers compared.
  EXPECT_NEAR(pose.axis_u[5].norm(), 0.25f, 4 * 0.25f * 1.2e-7f);
  EXPECT_NEAR(pose.axis_v[5].norm(), 0.25f, 4 * 0.25f * 1.2e-7f);
  EXPECT_NEAR(normal.z(), 0.0625f, 4 * 0.0625f * 1.2e-7f);
}

TEST_F(SceneFiles, StillCloudsAreMadeOnce) {
  int calls = 0;
  SceneFile file = read(base_scene);
  const Generator counting = [&](const auto& shape, std::size_t points, const auto& parameters) {
    ++calls;
    EXPECT_EQ(parameters.at("seed"), 1.0);
    return dots(shape, points, parameters);
  };
  for (const double frame : {1.0, 2.0, 3.0}) {
    const Result<const Scene*> scene = file.scene_at(frame, counting);
    ASSERT_TRUE(scene.ok());
    EXPECT_EQ((*scene)->frame, frame);
    EXPECT_EQ((*scene)->objects[0].cloud.size(), 3u);
  }
  EXPECT_EQ(calls, 1);
}

/// A triangle of which the first vertex is at (x, 0, 0).
std::string triangle(double x) { return "v " + std::to_string(x) + " 0 0\nv 1 0 -4\nv 0 1 -4\nf 1 2 3\n"; }

TEST_F(SceneFiles, SequencesHoldTheFilesAroundTheShutterAndCycle) {
  for (int n = 2; n <= 4; ++n) write(triangle(n), "walk.000" + std::to_string(n) + ".obj");
  for (const bool cycle : {false, true}) {
    const std::string text =
        replaced(base_scene, base_source,
                 std::string(R"({"sequence": "walk.####.obj", "first": 2, "last": 4, "cycle": )") +
                     (cycle ? "true}" : "false}"));
    SceneFile file = read(text);
    // Frame, and where the first point is at it: files 2, 3, 4 say 2, 3, 4.
    for (const auto& [frame, held, cycled] : {std::array{3.0, 3.0, 3.0},
                                              {2.5, 2.5, 2.5},
                                              {1.0, 2.0, 4.0},
                                              {5.0, 4.0, 2.0},
                                              {4.25, 4.0, 3.5},
                                              {-1.0, 2.0, 2.0},
                                              {302.0, 4.0, 2.0}}) {
      const Result<const Scene*> scene = file.scene_at(frame, dots);
      ASSERT_TRUE(scene.ok()) << scene.error().message();
      const SurfelCloud& cloud = (*scene)->objects[0].cloud;
      EXPECT_EQ(surfel_at(cloud, 0, frame).position.x(), cycle ? cycled : held) << frame;
      EXPECT_LE(cloud.keys.size(), 3u);
    }
  }
}

TEST_F(SceneFiles, TwoFilesMoveFromOneFrameToTheNext) {
  write(triangle(2), "a.obj");
  write(triangle(3), "b.obj");
  SceneFile file = read(replaced(base_scene, base_source, R"({"file": "a.obj", "end_file": "b.obj"})"));
  const Result<const Scene*> scene = file.scene_at(1.0, dots);
  ASSERT_TRUE(scene.ok()) << scene.error().message();
  // The scene's own frame, 7, is when the first file holds.
  EXPECT_EQ(surfel_at((*scene)->objects[0].cloud, 0, 7.5).position.x(), 2.5);
}

TEST_F(SceneFiles, VelocitiesPerSecondAreDividedByTheFrameRate) {
  write(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property float vx\nproperty float vy\nproperty float vz\nproperty float radius\nend_header\n"
      "0 0 0 48 0 0 0.5\n1 0 0 0 24 0 0.5\n",
      "fast.ply");
  for (const auto& [unit, expected] : {std::pair{"per_second", 2.0f}, {"per_frame", 48.0f}}) {
    std::string text =
        replaced(base_scene, base_source,
                 std::string(R"({"file": "fast.ply"}, "velocity": {"unit": ")") + unit + "\"}");
    text = replaced(text, "[24000, 1001]", "24");
    SceneFile file = read(text);
    const Result<const Scene*> scene = file.scene_at(1.0, dots);
    ASSERT_TRUE(scene.ok()) << scene.error().message();
    EXPECT_EQ((*scene)->objects[0].cloud.velocity[0], Vector3f(expected, 0, 0));
    EXPECT_EQ((*scene)->objects[0].cloud.keys[0].frame, 7.0);
  }
}

TEST_F(SceneFiles, OverridesReachTheSceneAndAreValidated) {
  SceneOverrides overrides;
  overrides.fields = {{"/film/width", {64}},   {"/film/height", {48}},    {"/film/crop", {8, 4, 16, 12}},
                      {"/shutter/open", {0}},  {"/shutter/close", {0.5}}, {"/image/segments", {7}},
                      {"/image/coverage", {1}}};
  const SceneFile file = read(base_scene, overrides);
  EXPECT_EQ(file.scene().film.window_width(), 16);
  EXPECT_EQ(file.scene().shutter.close, 0.5);
  EXPECT_EQ(file.scene().model.segments, 7);
  EXPECT_EQ(file.scene().objects[0].segments, 0);
  EXPECT_EQ(file.scene().model.coverage, Coverage::hard);

  overrides.fields["/film/crop"] = {60, 0, 16, 12};
  const Result<SceneFile> outside = read_scene_file(write(base_scene), overrides);
  ASSERT_FALSE(outside.ok());
  EXPECT_EQ(outside.error().field, "/film/crop");
}

TEST_F(SceneFiles, HashFollowsContentAndNotLayout) {
  const SceneFile file = read(base_scene);
  const auto hash_of = [](const SceneFile& scene, double frame = 7.0) {
    const Result<std::string> hash = scene.hash(frame);
    EXPECT_TRUE(hash.ok());
    return hash.ok() ? *hash : "";
  };
  EXPECT_EQ(hash_of(file).size(), 16u);
  EXPECT_EQ(hash_of(read(replaced(base_scene, "\"fps\": [", "  \"fps\":[  "))), hash_of(file));
  EXPECT_NE(hash_of(read(replaced(base_scene, "\"frame\": 7", "\"frame\": 8"))), hash_of(file));
  EXPECT_NE(hash_of(file), hash_of(file, 8.0));
  SceneOverrides overrides;
  overrides.points_scale = 0.5;
  EXPECT_NE(hash_of(read(base_scene, overrides)), hash_of(file));
  // What the file says already is not another scene.
  overrides.points_scale = 1.0;
  overrides.fields["/film/width"] = {320};
  EXPECT_EQ(hash_of(read(base_scene, overrides)), hash_of(file));
}

TEST_F(SceneFiles, HashFollowsTheFilesOfTheFrame) {
  for (int n = 1; n <= 3; ++n) write(triangle(n), "walk." + std::to_string(n) + ".obj");
  const SceneFile file =
      read(replaced(base_scene, base_source, R"({"sequence": "walk.#.obj", "first": 1, "last": 3})"));
  const Result<std::string> first = file.hash(1.0), third = file.hash(3.0);
  ASSERT_TRUE(first.ok() && third.ok());
  write(triangle(9), "walk.3.obj");
  // Another content at a time that the file system may not tell apart: by a reader of its own.
  const SceneFile again =
      read(replaced(base_scene, base_source, R"({"sequence": "walk.#.obj", "first": 1, "last": 3})"));
  EXPECT_EQ(*again.hash(1.0), *first);
  EXPECT_NE(*again.hash(3.0), *third);
  std::filesystem::remove(folder_ / "walk.3.obj");
  const Result<std::string> missing = again.hash(3.0);
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().field, "/objects/0/source/sequence");
}

}  // namespace
}  // namespace swept
