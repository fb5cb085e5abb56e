// Points of other programs drawn with the cameras of other programs, and the guides' commands.
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/io/image_file.h"
#include "tests/cloud_files.h"

namespace swept {
namespace {

using test::blender_ply;
using test::expect_said;
using test::Outcome;
using test::ply;
using test::put;
using test::run_command;
using test::sphere;
using CloudCamera = test::CloudCommandFolder;

/// Two cameras on the z axis at 8 and 5, which look at the origin.
std::string transforms(const std::string& lens) {
  const auto frame = [](const char* z) {
    return std::string("{\"file_path\": \"a.png\", \"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,") + z +
           "],[0,0,0,1]]}";
  };
  return "{" + lens + ", \"frames\": [" + frame("8") + ", " + frame("5") + "]}";
}

TEST_F(CloudCamera, TakesTheCameraOfTransformsJson) {
  put(folder_ / "ball.xyz", sphere(2000, 0, 0, 0, true, [](double, double, double) { return ""; }));
  put(folder_ / "focal.json",
      transforms(R"("fl_x": 120, "fl_y": 120, "cx": 48, "cy": 27, "w": 96, "h": 54, "k1": 0.01)"));
  // The same field of view as an angle: 2 atan(48 / 120).
  put(folder_ / "angle.json", transforms(R"("camera_angle_x": 0.7610127542247298, "w": 96, "h": 54)"));
  for (const std::string name : {"focal", "angle"}) {
    const Outcome outcome = swept({"render", "ball.xyz", "--camera", name + ".json", "-o", name + ".%d.exr",
                                   "--frames", "1-2", "--shutter", "0,0"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    expect_said(outcome.err,
                {"assumed: the camera is at the 2 frames of " + name + ".json, from frame 1 on"});
    EXPECT_EQ(outcome.err.find("framed by"), std::string::npos);
    EXPECT_EQ(outcome.err.find("distortion k1") != std::string::npos, name == "focal");
    // A ball of radius 1 at distance d has the angle asin(1/d), 120 px · tan of which is its picture's
    // radius.
    for (const int frame : {1, 2}) {
      const Result<Image> image = read_exr(folder_ / (name + "." + std::to_string(frame) + ".exr"));
      ASSERT_TRUE(image.ok());
      ASSERT_EQ(image->width, 96);
      double area = 0.0;
      for (std::size_t i = 3; i < image->rgba.size(); i += 4) area += static_cast<double>(image->rgba[i]);
      const double distance = frame == 1 ? 8.0 : 5.0, radius = 120.0 * std::tan(std::asin(1.0 / distance));
      // Discs reach over the silhouette by less than a pixel.
      EXPECT_NEAR(std::sqrt(area / std::numbers::pi), radius, 1.0) << name << frame;
    }
  }
  // Of a scene file it replaces the camera, and nothing else.
  ASSERT_EQ(swept({"init", "ball.xyz"}).exit_code, 0);
  const Outcome info = swept({"info", "scene.json", "--camera", "focal.json", "--frame", "2"});
  expect_said(info.out, {"film      1920 x 1080 px", "  eye     0 0 5\n"});
}

TEST_F(CloudCamera, RefusesCamerasThatItHasNot) {
  put(folder_ / "ball.xyz", sphere(50, 0, 0, 0, true, [](double, double, double) { return ""; }));
  const auto expect_refused = [&](const std::string& text, const std::string& message) {
    put(folder_ / "camera.json", text);
    const Outcome outcome = swept({"info", "ball.xyz", "--camera", "camera.json"});
    EXPECT_EQ(outcome.exit_code, 1) << text;
    expect_said(outcome.err, {"camera.json: " + message});
  };
  expect_refused(transforms(R"("fl_x": 120, "cx": 50, "h": 54)"), "/cx: comes without w");
  expect_refused(transforms(R"("fl_x": 120, "fl_y": 0, "w": 96, "h": 54)"), "/fl_y: ");
  expect_refused(transforms(R"("fl_x": 120, "w": 96, "h": 54, "camera_model": "OPENCV_FISHEYE")"),
                 "/camera_model");
  expect_refused(transforms(R"("w": 96, "h": 54)"), "/frames/0: no field of view");
  expect_refused(R"({"camera_angle_x": 1, "frames": []})", "/frames: there are no frames");
  expect_refused(R"({"camera_angle_x": 1})", "");
  expect_refused("[1]", "");
  expect_refused("", "");
  std::string scaled = transforms(R"("camera_angle_x": 1)");
  scaled.replace(scaled.rfind("[1,0,0,0]"), 9, "[2,0,0,0]");
  expect_refused(scaled, "/frames/1/transform_matrix: ");
  std::string short_row = transforms(R"("camera_angle_x": 1)");
  short_row.replace(short_row.rfind("[1,0,0,0]"), 9, "[1,0,0]");
  expect_refused(short_row, "/frames/1/transform_matrix/0: ");
}

/// A fan of three cameras around the origin, z up, in the axes of OpenGL.
std::string nerfstudio_cameras() {
  std::string frames;
  for (const double angle : {-0.3, 0.0, 0.3}) {
    const double c = std::cos(angle), s = std::sin(angle);
    std::ostringstream matrix;
    matrix << "[[" << c << ", 0, " << s << ", " << 4 * s << "], [" << s << ", 0, " << -c << ", " << -4 * c
           << "], [0, 1, 0, 0], [0, 0, 0, 1]]";
    if (!frames.empty()) frames += ',';
    frames += "{\"file_path\": \"images/a.png\", \"transform_matrix\": " + matrix.str() + "}";
  }
  return R"({"camera_model": "OPENCV", "fl_x": 110.5, "fl_y": 110, "cx": 47, "cy": 28, "w": 96, "h": 54, "frames": [)" +
         frames + "]}";
}

/// What the guides say to work in one command does, on small files of the same kinds.
TEST_F(CloudCamera, TheCommandsOfTheGuidesDraw) {
  put(folder_ / "blender.ply", blender_ply());
  for (int i = 1; i <= 4; ++i)
    put(folder_ / ("particles.000" + std::to_string(i) + ".ply"),
        ply("", 500, {"x", "y", "z", "v[0]", "v[1]", "v[2]", "Cd[0]", "Cd[1]", "Cd[2]", "pscale"},
            sphere(500, 0.05 * i, 0, 0, false,
                   [](double, double, double) { return " 1.2 0 0 0.5 0.25 0 0.1"; })));
  put(folder_ / "sparse_pc.ply",
      ply("", 800, {"x", "y", "z", "red", "green", "blue"},
          sphere(800, 0, 0, 0, false, [](double, double, double z) { return z > 0 ? " 1 0 0" : " 0 0 1"; })));
  put(folder_ / "transforms.json", nerfstudio_cameras());
  put(folder_ / "scan.pcd",
      "VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 600\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 600\nDATA ascii\n" +
          sphere(600, 10, 2, 0, false, [](double, double, double z) { return z > 0 ? " 40" : " 20"; }));
  std::string survey = "Easting,Northing,Elevation,Intensity\n";
  for (int i = 0; i < 4800; ++i)
    survey += std::to_string(512345.25 + 0.25 * (i % 80)) + ',' +
              std::to_string(5412345.75 + 0.25 * (i / 80)) + ',' + std::to_string(310.0 + 0.01 * (i % 80)) +
              ',' + std::to_string(i % 200) + '\n';
  put(folder_ / "survey.txt", survey);

  std::string pages;
  for (const char* name : {"/film.md", "/splats.md", "/survey.md"})
    pages += test::content_of(std::string(SWEPT_GUIDES) + name);
  std::istringstream guides(pages);
  std::vector<std::string> commands;
  for (std::string line; std::getline(guides, line);) {
    const bool ours = line.starts_with("swept render ") && line.find(" # ") != std::string::npos;
    for (const char* name : {"blender.ply", "particles.", "sparse_pc.ply", "scan.pcd", "survey.txt"})
      if (ours && line.find(name) != std::string::npos) commands.push_back(line.substr(0, line.find(" # ")));
  }
  ASSERT_EQ(commands.size(), 5u);
  for (std::string command : commands) {
    command.replace(0, 5, SWEPT_COMMAND);
    const std::string size = command.find("--camera") == std::string::npos ? " --size 96x54" : "";
    const Outcome outcome = run_command("(cd '" + (folder_ / "") + "' && " + command + size + ")");
    EXPECT_EQ(outcome.exit_code, 0) << command << '\n' << outcome.err;
  }
  for (const char* name : {"blender.exr", "particles.0002.exr", "scan.exr", "survey.exr"})
    expect_well_framed(name);
  for (const char* name : {"blender.png", "particles.0003.png", "export.png", "scan.png", "survey.png"})
    EXPECT_TRUE(folder_.names().contains(name)) << name;
  // The camera's second frame looks along y from −4: a ball of 110/√15 px about its principal point.
  const Result<Image> image = read_exr(folder_ / "export.exr");
  ASSERT_TRUE(image.ok()) << image.error().message();
  double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
  for (std::size_t i = 0; i < image->pixel_count(); ++i) {
    const auto alpha = static_cast<double>(image->rgba[4 * i + 3]);
    sum += alpha;
    sum_x += alpha * (static_cast<double>(i % 96) + 0.5);
    sum_y += alpha * (static_cast<double>(i / 96) + 0.5);
  }
  EXPECT_EQ(image->width, 96);
  EXPECT_NEAR(sum_x / sum, 47.0, 1.0);
  EXPECT_NEAR(sum_y / sum, 28.0, 1.0);
}

}  // namespace
}  // namespace swept
