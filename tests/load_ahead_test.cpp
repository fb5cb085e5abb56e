// Frames of a sequence that are loaded while the one before is rendered: the same scenes, the same bytes, and
// errors of a frame at that frame alone.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "datasets/generators.h"
#include "splat/io/scene_file.h"
#include "tests/command.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using test::content_of;
using test::run_command;

const std::string scene_text =
    R"({"swept": 1, "film": {"width": 48, "height": 32}, "shutter": {"open": 0, "close": 0.5},
 "camera": {"fov": {"axis": "vertical", "degrees": 40},
            "keys": [{"eye": [0, 0, 9], "target": [0, 0, 0], "up": [0, 1, 0]}]},
 "objects": [{"source": {"sequence": "s.%04d.obj"}, "radius": 0.4},
             {"source": {"generator": "sphere", "points": 200}}]})";

class LoadAhead : public testing::Test {
 protected:
  LoadAhead() {
    test::put(folder_ / "scene.json", scene_text);
    for (int number = 1; number <= 6; ++number) put_file(number);
  }

  /// Three points of which the first is at (number, 0, 0).
  void put_file(int number) const {
    test::put(file_of(number), "v " + std::to_string(number) + " 0 0\nv 1 0 1\nv 0 1 0\nf 1 2 3\n");
  }
  [[nodiscard]] std::string file_of(int number) const {
    return folder_ / ("s.000" + std::to_string(number) + ".obj");
  }
  [[nodiscard]] SceneFile open() const {
    Result<SceneFile> file = read_scene_file(folder_ / "scene.json");
    EXPECT_TRUE(file.ok()) << file.error().message();
    return *std::move(file);
  }
  static double place(SceneFile& file, double frame) {
    const Result<const Scene*> scene = file.scene_at(frame, generate);
    EXPECT_TRUE(scene.ok()) << scene.error().message();
    return scene ? surfel_at((*scene)->objects[0].cloud, 0, frame).position.x() : -1.0;
  }

  test::TemporaryFolder folder_;
};

TEST_F(LoadAhead, IsTakenByThatFrameAndByNoOther) {
  SceneFile file = open();
  EXPECT_EQ(place(file, 1), 1.0);
  file.load_ahead(2, generate);
  EXPECT_EQ(file.scene().frame, 1.0) << "the scene is as it was";
  EXPECT_EQ(surfel_at(file.scene().objects[0].cloud, 0, 1).position.x(), 1.0);
  // What was loaded is not read again: files that are gone meanwhile are not missed.
  for (const int number : {2, 3}) std::filesystem::remove(file_of(number));
  EXPECT_EQ(place(file, 2), 2.0);
  EXPECT_EQ(file.scene().objects[1].cloud.size(), 200u) << "what does not change stays";
  EXPECT_FALSE(file.notes().empty());
  for (const int number : {2, 3}) put_file(number);
  file.load_ahead(4, generate);
  EXPECT_EQ(place(file, 3), 3.0) << "another frame than the one that was expected";
  EXPECT_EQ(place(file, 4), 4.0);
}

TEST_F(LoadAhead, WhatFailsIsToldByTheFrameItself) {
  SceneFile file = open();
  EXPECT_EQ(place(file, 1), 1.0);
  test::put(file_of(2), "v nonsense\n");
  file.load_ahead(2, generate);
  EXPECT_EQ(place(file, 4), 4.0) << "nothing of it comes to others";
  file.load_ahead(2, generate);
  const Result<const Scene*> scene = file.scene_at(2, generate);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().file.find("s.0002.obj"), std::string::npos) << scene.error().message();
  put_file(2);
  EXPECT_EQ(place(file, 2), 2.0);
  file.load_ahead(1e300, generate);
  EXPECT_FALSE(file.scene_at(1e300, generate).ok());
}

const std::string generated_head =
    R"({"swept": 1, "film": {"width": 48, "height": 32}, "shutter": {"open": 0, "close": 0.5},
 "camera": {"fov": {"axis": "vertical", "degrees": 40},
            "keys": [{"eye": [0, 0, 9], "target": [0, 0, 0], "up": [0, 1, 0]}]}, )";

TEST(GenerateAhead, GivesWhatTheSceneWouldHaveGenerated) {
  const std::string text = generated_head + R"("objects": [
    {"source": {"generator": "sphere", "points": 500}},
    {"source": {"generator": "knot", "points": 700, "seed": 5}},
    {"source": {"generator": "plane", "points": 300, "red": 0.5}}]})";
  const test::TemporaryFolder folder;
  test::put(folder / "scene.json", text);
  Result<SceneFile> plain = read_scene_file(folder / "scene.json"),
                    ahead = read_scene_file(folder / "scene.json");
  ASSERT_TRUE(plain.ok() && ahead.ok());
  std::atomic<int> calls{0};
  const auto counted = [&](const std::string& shape, std::size_t points, const auto& parameters) {
    ++calls;
    return generate(shape, points, parameters);
  };
  ahead->generate_ahead(1, counted, 3);
  EXPECT_EQ(calls, 3);
  const Result<const Scene*> one = plain->scene_at(1, generate), other = ahead->scene_at(1, counted);
  ASSERT_TRUE(one.ok() && other.ok());
  EXPECT_EQ(calls, 3) << "what is there is not generated again";
  for (std::size_t i = 0; i < 3; ++i) {
    const SurfelCloud &a = (*one)->objects[i].cloud, &b = (*other)->objects[i].cloud;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      ASSERT_EQ(a.keys[0].pose.position[k], b.keys[0].pose.position[k]);
      ASSERT_EQ(a.color[k], b.color[k]);
    }
  }
  ahead->generate_ahead(2, counted, 3);
  ASSERT_TRUE(ahead->scene_at(2, counted).ok());
  EXPECT_EQ(calls, 3) << "nor is what stays";
}

TEST(GenerateAhead, WhatFailsIsToldByTheSceneOfTheFirstThatFails) {
  const test::TemporaryFolder folder;
  test::put(folder / "scene.json", generated_head + R"("objects": [
    {"source": {"generator": "sphere", "points": 500}},
    {"source": {"generator": "knot", "points": 100}},
    {"source": {"generator": "plane", "points": 300}}]})");
  Result<SceneFile> file = read_scene_file(folder / "scene.json");
  ASSERT_TRUE(file.ok());
  const auto failing = [](const std::string& shape, std::size_t points,
                          const auto& parameters) -> Result<SurfelCloud> {
    if (shape == "knot") return Error{"", "points", "no knots today"};
    if (shape == "plane") throw std::runtime_error("no planes either");
    return generate(shape, points, parameters);
  };
  file->generate_ahead(1, failing, 2);
  const Result<const Scene*> scene = file->scene_at(1, failing);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().reason.find("no knots today"), std::string::npos) << scene.error().message();
  EXPECT_NE(scene.error().field.find("/objects/1"), std::string::npos) << scene.error().message();
  EXPECT_TRUE(file->scene_at(1, generate).ok());
}

TEST_F(LoadAhead, OnAnotherThreadWhileTheSceneIsRead) {
  SceneFile file = open();
  for (int frame = 1; frame < 6; ++frame) {
    ASSERT_EQ(place(file, frame), frame);
    std::thread other([&file, frame] {
      file.load_ahead(frame + 1, generate);
      EXPECT_TRUE(file.hash(frame + 1).ok());
    });
    for (int i = 0; i < 100; ++i)
      EXPECT_EQ(surfel_at(file.scene().objects[0].cloud, 0, frame).position.x(), frame);
    other.join();
  }
}

TEST_F(LoadAhead, FramesAreTheSameBytesWithAndWithout) {
  const std::string scene = " render '" + (folder_ / "scene.json") + "' --frames 1-5 -o '";
  test::Outcome outcome = run_command(SWEPT_COMMAND + scene + (folder_ / "with.%d.exr") + "'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  outcome = run_command(SWEPT_COMMAND + scene + (folder_ / "without.%d.exr") + "' --no-load-ahead");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (int frame = 1; frame <= 5; ++frame)
    EXPECT_TRUE(content_of(folder_ / ("with." + std::to_string(frame) + ".exr")) ==
                content_of(folder_ / ("without." + std::to_string(frame) + ".exr")))
        << frame;
}

TEST_F(LoadAhead, AFrameThatCannotBeLoadedStopsTheRunAtThatFrame) {
  test::put(file_of(4), "v nonsense\n");
  const test::Outcome outcome = run_command(SWEPT_COMMAND " render '" + (folder_ / "scene.json") +
                                            "' --frames 1-6 -o '" + (folder_ / "f.%d.exr") + "'");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("s.0004.obj"), std::string::npos) << outcome.err;
  // Frame 3 looks at the file, too: its shutter is open until 3.5.
  EXPECT_NE(outcome.err.find("(frame 3)"), std::string::npos) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "f.2.exr"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "f.3.exr"));
}

}  // namespace
}  // namespace swept
