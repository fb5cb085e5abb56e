// Options for what a camera is otherwise than the scene says: orthographic, or with another lens.
#include <string>

#include <gtest/gtest.h>

#include "splat/io/image_file.h"
#include "splat/io/scene_file.h"
#include "tests/command.h"

namespace swept {
namespace {

using test::put;
using test::TemporaryFolder;

class CameraOptions : public testing::Test {
 protected:
  void SetUp() override { put(folder_ / "p.xyz", "0 0 0\n0.5 0.3 -2\n-0.6 -0.2 1\n"); }
  /// A scene of three discs, with this camera.
  [[nodiscard]] std::string scene(const std::string& name, const std::string& camera) const {
    put(folder_ / name,
        R"({"swept": 1, "film": {"width": 64, "height": 48}, "shutter": {"open": 0, "close": 1},
      "camera": {)" +
            camera + R"(}, "objects": [{"source": {"file": "p.xyz"}, "radius": 0.4}]})");
    return folder_ / name;
  }
  [[nodiscard]] test::Outcome swept(const std::string& arguments) const {
    return test::run_command(std::string(SWEPT_COMMAND) + ' ' + arguments);
  }
  [[nodiscard]] Image picture(const std::string& scene, const std::string& options = "") const {
    const std::string path = folder_ / "a.exr";
    const test::Outcome outcome =
        swept("render '" + scene + "' -o '" + path + "' --overwrite --samples 4 " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    Result<Image> image = read_exr(path);
    EXPECT_TRUE(image.ok());
    return image.ok() ? std::move(*image) : Image{};
  }
  void expect_refused(const std::string& arguments, int exit_code, const std::string& reason) const {
    const test::Outcome outcome = swept(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments << outcome.err;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << outcome.err;
  }

  const std::string fov_ = R"("fov": {"axis": "vertical", "degrees": 60})";
  const std::string keys_ = R"("keys": [{"frame": 1, "eye": [0, 0, 5], "target": [0, 0, 0]},
                                        {"frame": 3, "eye": [1, 0, 5], "target": [0, 0, 0]}])";
  const TemporaryFolder folder_;
};

TEST_F(CameraOptions, OrthographicIsAsInTheFile) {
  const std::string plain = scene("plain.json", fov_ + ", " + keys_);
  const std::string high = scene("high.json", R"("height": 3, )" + keys_);
  EXPECT_EQ(picture(plain, "--orthographic 3").rgba, picture(high).rgba);
  EXPECT_NE(picture(plain).rgba, picture(high).rgba);
  EXPECT_EQ(picture(high, "--orthographic 2").rgba, picture(plain, "--orthographic 2").rgba);
  // What the camera sees at its target: 2 · 5 tan 30°, and at the second key √26 in place of 5.
  const test::Outcome info = swept("info '" + plain + "' --orthographic auto");
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_NE(info.out.find("orthographic, 5.80"), std::string::npos) << info.out;
  // Every key has its own height, or all share one; a zoom is keyed.
  const std::string zoom =
      scene("zoom.json", R"("keys": [{"frame": 1, "eye": [0, 0, 5], "target": [0, 0, 0], "height": 2},
                               {"frame": 3, "eye": [0, 0, 5], "target": [0, 0, 0], "height": 4}])");
  const Result<SceneFile> file = read_scene_file(zoom);
  ASSERT_TRUE(file.ok()) << file.error().message();
  EXPECT_TRUE(file->scene().camera.orthographic);
  EXPECT_DOUBLE_EQ(2.0 * file->scene().camera.at(2.0).tan_half_fov_y, 3.0);
  // A cloud without a scene.
  EXPECT_EQ(swept("render '" + folder_ / "p.xyz" + "' -o '" + folder_ / "c.exr" +
                  "' --size 32x24 --orthographic auto")
                .exit_code,
            0);
}

TEST_F(CameraOptions, LensesAreAsInTheFile) {
  const std::string plain = scene("plain.json", fov_ + ", " + keys_);
  const std::string lens =
      scene("lens.json", fov_ + R"(, "lens": {"aperture": 0.5, "focus": 4, "blades": 5, "rotation": 20,
                                             "samples": 9}, )" +
                             keys_);
  const Image blurred = picture(lens);
  EXPECT_NE(picture(plain).rgba, blurred.rgba);
  EXPECT_EQ(picture(lens, "--no-lens").rgba, picture(plain).rgba);
  const std::string rest = " --focus 4 --blades 5 --lens-rotation 20 --lens-points 9";
  EXPECT_EQ(picture(plain, "--aperture 0.5" + rest).rgba, blurred.rgba);
  EXPECT_EQ(picture(plain, "--f-number 4 --focal-length 2" + rest).rgba, blurred.rgba);
  EXPECT_EQ(picture(lens, "--aperture 0").rgba, picture(plain).rgba);
  // Keyed, where the camera has no keys: what is between them is between them.
  const std::string pulled = scene("pulled.json", fov_ + R"(, "lens": {"aperture": 0.5, "samples": 9},
      "keys": [{"frame": 1, "eye": [0, 0, 5], "target": [0, 0, 0], "focus": 3},
               {"frame": 1.5, "eye": [0.25, 0, 5], "target": [0, 0, 0], "focus": 5},
               {"frame": 3, "eye": [1, 0, 5], "target": [0, 0, 0], "focus": 5}])");
  EXPECT_EQ(picture(plain, "--aperture 0.5 --lens-points 9 --focus 1:3,1.5:5").rgba, picture(pulled).rgba);
  // Unless it is said what a look-at looks at is in focus.
  const Result<SceneFile> file = [&] {
    SceneOverrides overrides;
    overrides.camera.aperture = 0.5;
    return read_scene_file(plain, overrides);
  }();
  ASSERT_TRUE(file.ok()) << file.error().message();
  EXPECT_DOUBLE_EQ(file->scene().camera.at(1.0).lens.focus, 5.0);
}

TEST_F(CameraOptions, WhatCannotBeIsSaid) {
  const std::string plain = scene("plain.json", fov_ + ", " + keys_);
  const std::string lens = scene("lens.json", fov_ + R"(, "lens": {"aperture": 0.5, "focus": 4}, )" + keys_);
  const auto render = [&](const std::string& path, const std::string& options) {
    return "render '" + path + "' -o '" + (folder_ / "b.exr") + "' --overwrite " + options;
  };
  for (const char* bad :
       {"--orthographic 0", "--orthographic wide", "--aperture=-1", "--aperture x", "--focus 0",
        "--focus 1:3,1:4", "--focus 3,4", "--blades 2", "--lens-points 0", "--f-number 0"})
    expect_refused(render(plain, bad), 2, "--");
  expect_refused(render(plain, "--focus 3"), 2, "no lens");
  expect_refused(render(plain, "--f-number 4"), 2, "focal length");
  expect_refused(render(lens, "--no-lens --focus 3"), 2, "switched off");
  expect_refused(render(lens, "--orthographic 3"), 1, "no lens");
  expect_refused("info '" +
                     scene("mixed.json", R"("keys": [{"frame": 1, "eye": [0, 0, 5], "target": [0, 0, 0],
      "height": 2}, {"frame": 2, "eye": [0, 0, 5], "target": [0, 0, 0],
      "fov": {"axis": "vertical", "degrees": 60}}])") +
                     "'",
                 1, "/camera/keys/1");
  expect_refused("info '" + scene("both.json", R"("height": 2, )" + fov_ + ", " + keys_) + "'", 1,
                 "/camera/height");
  expect_refused("info '" + scene("matrix.json", fov_ + R"(, "keys": [{"matrix":
      [1,0,0,0, 0,1,0,0, 0,0,1,5, 0,0,0,1]}])") +
                     "' --orthographic auto",
                 2, "say the height");
#ifdef SWEPT_HAS_GPU
  expect_refused(render(plain, "--orthographic 3 --method gpu"), 1, "orthographic");
#endif
}

}  // namespace
}  // namespace swept
