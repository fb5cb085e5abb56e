// What `swept info` says of motion: the longest streak, and the unit of velocities.
#include "tools/scene_report.h"

#include <cmath>

#include "tests/point_files.h"
#include "tools/longest_streak.h"

namespace {

using namespace swept;
using swept_test::float_ply;

/// 200 px high, 90° high: a point at depth 2 moves 50 px for one unit.
Scene looking_down_z() {
  Scene scene;
  scene.frame = 1.0;
  scene.film.width = 400;
  scene.film.height = 200;
  scene.shutter = {-0.25, 0.25};
  scene.camera.look_ats.push_back({0.0, {0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 1.0});
  return scene;
}

Object points(const std::vector<Eigen::Vector3d>& positions, const std::vector<Eigen::Vector3f>& velocities) {
  Object object;
  SurfelPose pose;
  pose.position = positions;
  pose.axis_u.assign(positions.size(), Eigen::Vector3f(0.1f, 0, 0));
  pose.axis_v.assign(positions.size(), Eigen::Vector3f(0, 0.1f, 0));
  object.cloud.keys.push_back({1.0, std::move(pose)});
  object.cloud.velocity = velocities;
  return object;
}

TEST(LongestStreak, IsThatOfTheFastestPointOnTheFilm) {
  const Scene scene = looking_down_z();
  // Half a frame of exposure. The third is fastest, and far beside the film; the fourth is behind the eye.
  const Object object = points({{0, 0, 0}, {0, 0, 0}, {40, 0, 0}, {0, 0, 3}},
                               {{0.5f, 0, 0}, {0, -1.5f, 0}, {0, 5, 0}, {9, 0, 0}});
  EXPECT_NEAR(longest_streak_px(scene, object), 0.5 * 1.5 * 50.0, 1e-5);
}

TEST(LongestStreak, CountsObjectCameraAndBends) {
  Scene scene = looking_down_z();
  Object object = points({{1, 0, 0}}, {});
  EXPECT_EQ(longest_streak_px(scene, object), 0.0);
  // A full turn about the view within the exposure: a circle of 50 px. Nine instants see its octagon.
  for (const double frame : {0.75, 1.25}) {
    TransformKey key;
    key.frame = frame;
    key.rotate_axis = Eigen::Vector3d::UnitZ();
    key.rotate_radians = (frame - 0.75) * 4.0 * M_PI;
    object.transform.keys.push_back(key);
  }
  EXPECT_NEAR(longest_streak_px(scene, object), 16.0 * 50.0 * std::sin(M_PI / 8.0), 1e-9);
  object.transform.keys.clear();
  scene.camera.look_ats.push_back({2.0, {1, 0, 2}, {1, 0, 0}, {0, 1, 0}, 1.0});
  EXPECT_NEAR(longest_streak_px(scene, object), 0.25 * 50.0, 1e-9);
  scene.shutter = {0.0, 0.0};
  EXPECT_EQ(longest_streak_px(scene, object), 0.0);
}

using SceneReportTest = swept_test::PointFiles;

TEST_F(SceneReportTest, NamesTheUnitOfVelocitiesThatMovePoints) {
  write("v.ply", float_ply("ascii", {"x", "y", "z", "radius", "vx", "vy", "vz"}, {{0, 0, 0, 0.1, 24, 0, 0}}));
  const auto report = [&](const std::string& velocity) {
    Result<SceneFile> file = scene_from_text(
        R"({"swept": 1, "film": {"width": 400, "height": 200}, "camera": {"fov": {"axis": "vertical",
            "degrees": 90}, "keys": [{"eye": [0, 0, 2], "target": [0, 0, 0]}]},
            "objects": [{"source": {"file": "v.ply"})" +
            velocity + "}]}",
        folder_ / "scene.json");
    EXPECT_TRUE(file.ok()) << file.error().message();
    const Result<const Scene*> scene = file->scene_at(1.0, {});
    EXPECT_TRUE(scene.ok()) << scene.error().message();
    return report_scene(*file, **scene).objects.at(0);
  };
  EXPECT_EQ(report("").velocity_unit, "per_second");
  EXPECT_NEAR(report("").longest_streak_px, 0.5 * 50.0, 1e-5);
  EXPECT_EQ(report(R"(, "velocity": {"unit": "per_frame"})").velocity_unit, "per_frame");
  EXPECT_EQ(report(R"(, "velocity": {"unit": "ignore"})").velocity_unit, "");
  EXPECT_EQ(report(R"(, "velocity": {"unit": "ignore"})").longest_streak_px, 0.0);
}

}  // namespace
