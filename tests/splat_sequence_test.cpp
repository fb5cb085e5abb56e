// Numbered sequences of trained splats: each frame shows its own file, as splats, and joins it to no other.
#include <cmath>
#include <string>
#include <vector>

#include "abuffer/sampled.h"
#include "splat/io/cloud_scene.h"
#include "splat/io/scene_file.h"
#include "tests/point_files.h"

namespace {

using namespace swept;
using SplatSequence = swept_test::PointFiles;

Result<SurfelCloud> no_generator(const std::string&, std::size_t, const std::map<std::string, double>&) {
  return Error{"", "", "no generators here"};
}

/// White splats in a row from x on, moving by `velocity` per second.
std::string trained(int count, double x, double velocity) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) + "\n";
  for (const char* name : {"x", "y", "z", "vx", "vy", "vz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
                           "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    text += "property float " + std::string(name) + "\n";
  text += "end_header\n";
  for (int i = 0; i < count; ++i)
    text +=
        std::to_string(x + i) + " 0 5 " + std::to_string(velocity) + " 0 0 1.7 1.7 1.7 4 -2 -2 -2 1 0 0 0\n";
  return text;
}

bool says(const std::vector<std::string>& notes, const std::string& what) {
  for (const std::string& note : notes)
    if (note.find(what) != std::string::npos) return true;
  return false;
}

TEST_F(SplatSequence, EachFrameShowsItsOwnFile) {
  write("frame.0001.ply", trained(3, 0.0, 0.0));
  write("frame.0002.ply", trained(5, 40.0, 0.0));
  write("frame.0004.ply", trained(2, -40.0, 0.0));
  Result<SceneFile> file = read_scene_or_points(folder_ / "frame.%04d.ply", {});
  ASSERT_TRUE(file.ok()) << file.error().message();
  for (const auto& [frame, count, x] : std::vector<std::tuple<double, std::size_t, double>>{
           {1.0, 3, 0.0}, {2.0, 5, 40.0}, {2.4, 5, 40.0}, {1.0, 3, 0.0}}) {
    const Result<const Scene*> scene = file->scene_at(frame, no_generator);
    ASSERT_TRUE(scene.ok()) << scene.error().message();
    const Object& object = (*scene)->objects.at(0);
    EXPECT_EQ(object.cloud.size(), 0u);
    ASSERT_EQ(object.splats.size(), count);
    EXPECT_EQ(object.splats.position[0].x(), x);
    EXPECT_TRUE(says(file->notes(), "each frame shows its own file")) << frame;
  }
}

TEST_F(SplatSequence, VelocitiesAreTheOnlyMotion) {
  write("a.1.ply", trained(1, 0.0, 24.0));
  write("a.2.ply", trained(1, 100.0, 24.0));
  Result<SceneFile> file = read_scene_or_points(folder_ / "a.#.ply", {});
  ASSERT_TRUE(file.ok()) << file.error().message();
  const Result<const Scene*> scene = file->scene_at(2.0, no_generator);
  ASSERT_TRUE(scene.ok()) << scene.error().message();
  const SplatCloud& splats = (*scene)->objects.at(0).splats;
  ASSERT_EQ(splats.velocity.size(), 1u);
  // 24 a second at 24 frames a second, about where the second file has it.
  EXPECT_NEAR(splats.position_at(0, 2.0).x(), 100.0, 1e-6);
  EXPECT_NEAR(splats.position_at(0, 2.25).x(), 100.25, 1e-6);
  EXPECT_TRUE(says(file->notes(), "by their velocities"));
}

TEST_F(SplatSequence, DiscsAreThereForTheAskingAndFaultsNameTheirFile) {
  write("b.1.ply", trained(4, 0.0, 0.0));
  write("b.2.ply", "ply\nformat ascii 1.0\n");
  SceneOverrides discs;
  discs.draw = DrawAs::surfels;
  write("c.1.ply", trained(4, 0.0, 0.0));
  Result<SceneFile> as_discs = read_scene_or_points(folder_ / "c.#.ply", discs);
  ASSERT_TRUE(as_discs.ok()) << as_discs.error().message();
  const Result<const Scene*> scene = as_discs->scene_at(1.0, no_generator);
  ASSERT_TRUE(scene.ok()) << scene.error().message();
  EXPECT_EQ((*scene)->objects.at(0).splats.size(), 0u);
  EXPECT_EQ((*scene)->objects.at(0).cloud.size(), 4u);

  const Result<SceneFile> broken = read_scene_or_points(folder_ / "b.#.ply", {});
  ASSERT_FALSE(broken.ok());
  EXPECT_NE(broken.error().message().find("b.2.ply"), std::string::npos) << broken.error().message();
}

}  // namespace
