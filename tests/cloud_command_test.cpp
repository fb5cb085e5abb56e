// Points without a scene file, from the files of a few tools to a picture: what is drawn, and what is said.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/io/image_file.h"
#include "tests/command.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using test::Outcome;
using test::put;
using test::run_command;
using test::TemporaryFolder;

class CloudCommand : public ::testing::Test {
 protected:
  /// Runs `swept` in the test's folder.
  Outcome swept(const std::vector<std::string>& arguments) const {
    std::string line = "cd '" + (folder_ / "") + "' && " + SWEPT_COMMAND;
    for (const std::string& argument : arguments) line += " '" + argument + "'";
    return run_command("(" + line + ")");
  }

  /// A small picture of the points, which fills a part of it and stands in its middle.
  std::string drawn(const std::string& points) const {
    const Outcome outcome = swept({"render", points, "-o", "a.exr", "--size", "96x54", "--overwrite"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    expect_well_framed("a.exr");
    return outcome.err;
  }

  void expect_well_framed(const std::string& name) const {
    const Result<Image> image = read_exr(folder_ / name);
    ASSERT_TRUE(image.ok()) << image.error().message();
    int left = image->width, right = -1, top = image->height, bottom = -1, covered = 0;
    for (int y = 0; y < image->height; ++y)
      for (int x = 0; x < image->width; ++x) {
        const float alpha = image->rgba[4 * static_cast<std::size_t>(y * image->width + x) + 3];
        covered += alpha > 0.5f ? 1 : 0;
        if (!(alpha > 0.1f)) continue;
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = std::max(bottom, y);
      }
    const double share = covered / static_cast<double>(image->pixel_count());
    EXPECT_GT(share, 0.05) << name;
    EXPECT_LT(share, 0.95) << name;
    // As much room on the one side as on the other, to a twentieth of the picture.
    EXPECT_NEAR(left, image->width - 1 - right, 0.05 * image->width) << name;
    EXPECT_NEAR(top, image->height - 1 - bottom, 0.05 * image->height) << name;
  }

  TemporaryFolder folder_;
};

/// A row of text per point of a sphere about `center`: x y z, its normal, and what `more` adds.
template <class More>
std::string sphere(int count, double center_x, double center_y, double center_z, bool normals,
                   const More& more) {
  std::ostringstream text;
  text.precision(12);
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double x = r * std::cos(angle), y = r * std::sin(angle);
    text << center_x + x << ' ' << center_y + y << ' ' << center_z + z;
    if (normals) text << ' ' << x << ' ' << y << ' ' << z;
    text << more(x, y, z) << '\n';
  }
  return text.str();
}

std::string ply(const std::string& comment, int count, const std::vector<std::string>& properties,
                const std::string& rows) {
  std::string text = "ply\nformat ascii 1.0\n" + comment + "element vertex " + std::to_string(count) + "\n";
  for (const std::string& name : properties) text += "property float " + name + "\n";
  return text + "end_header\n" + rows;
}

std::string blender_ply() {
  return ply("comment Created in Blender version 4.0.2\n", 600,
             {"x", "y", "z", "nx", "ny", "nz", "velocity_x", "velocity_y", "velocity_z"},
             sphere(600, 0, 0, 1, true, [](double, double, double) { return " 4.8 0 0"; }));
}

void expect_said(const std::string& err, const std::vector<std::string>& lines) {
  for (const std::string& line : lines)
    EXPECT_NE(err.find(line), std::string::npos) << line << "\nin\n" << err;
}

TEST_F(CloudCommand, DrawsVelocitiesFromBlender) {
  put(folder_ / "cloud.ply", blender_ply());
  const std::string err = drawn("cloud.ply");
  expect_said(err,
              {"note: assumed: seen from the front and 20 degrees above, z up, as Blender writes files\n",
               "note: assumed: framed by the points\n",
               "note: assumed: 24 frames per second, shutter open from -0.25 to 0.25 frames\n",
               "note: assumed: coloured by normals, for there are no colours\n",
               "velocity from velocity_x, velocity_y, velocity_z",
               "assumed: velocities are per second, at 24 frames per second\n"});
  // 4.8 per second are 0.1 over half a frame, and the picture is blurred by that: most of all at its sides.
  ASSERT_EQ(
      swept({"render", "cloud.ply", "-o", "still.exr", "--size", "96x54", "--shutter", "0,0"}).exit_code, 0);
  const Result<Image> moving = read_exr(folder_ / "a.exr"), still = read_exr(folder_ / "still.exr");
  ASSERT_TRUE(moving.ok() && still.ok());
  float most = 0.0f;
  for (std::size_t i = 3; i < still->rgba.size(); i += 4)
    most = std::max(most, std::abs(still->rgba[i] - moving->rgba[i]));
  EXPECT_GT(most, 0.2f);
}

TEST_F(CloudCommand, DrawsASequenceOfHoudiniParticles) {
  const std::vector<std::string> names = {"x",    "y",     "z",     "v[0]",  "v[1]",
                                          "v[2]", "Cd[0]", "Cd[1]", "Cd[2]", "pscale"};
  for (int i = 1; i <= 4; ++i)
    put(folder_ / ("anim.000" + std::to_string(i) + ".ply"),
        ply("", 500, names, sphere(500, 0.05 * i, 0, 0, false, [](double, double, double) {
              return " 1.2 0 0 0.5 0.25 0 0.1";
            })));
  const Outcome outcome =
      swept({"render", "anim.$F4.ply", "-o", "f.%04d.exr", "--frames", "1-3", "--size", "96x54"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_said(outcome.err, {"note: assumed: framed by the points of files 1, 2, 3, 4\n",
                            "its files are 1-4\n", "y up, which the file does not say\n",
                            "color from Cd[0], Cd[1], Cd[2]", "radius from pscale"});
  EXPECT_EQ(outcome.err.find("coloured by normals"), std::string::npos);
  for (const char* name : {"f.0001.exr", "f.0002.exr", "f.0003.exr"}) expect_well_framed(name);
  const Result<Image> image = read_exr(folder_ / "f.0002.exr");
  ASSERT_TRUE(image.ok());
  const float* middle = &image->rgba[4 * static_cast<std::size_t>(27 * 96 + 48)];
  EXPECT_NEAR(middle[0], 0.5f, 0.01f);
  EXPECT_NEAR(middle[1], 0.25f, 0.01f);
  // A farm renders frame by frame, and the camera must be the same; what is done is known again.
  const Outcome again = swept({"render", "anim.$F4.ply", "-o", "f.%04d.exr", "--frames", "2-4", "--size",
                               "96x54", "--skip-existing", "--dry-run"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.out,
            "frame 2: skip f.0002.exr\nframe 3: skip f.0003.exr\nframe 4: render f.0004.exr 500 points\n");
}

TEST_F(CloudCommand, DrawsARobotsCloudWithIntensities) {
  const std::string rows =
      sphere(600, 10, 2, 0, false, [](double, double, double z) { return z > 0 ? " 40" : " 20"; });
  put(folder_ / "scan.pcd",
      "VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 601\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 601\nDATA ascii\n" +
          rows + "nan nan nan 0\n");
  const std::string err = drawn("scan.pcd");
  expect_said(err,
              {"z up, as robots have it\n", "intensity from intensity",
               "note: assumed: an intensity of 40 is white, which 98% of the points do not exceed\n",
               "note: assumed: points that are not finite are left out, 1 of them\n", "dropped 1 of 601"});
  const Result<Image> image = read_exr(folder_ / "a.exr");
  ASSERT_TRUE(image.ok());
  const float* upper = &image->rgba[4 * static_cast<std::size_t>(12 * 96 + 48)];
  for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(upper[channel], 1.0f, 0.02f);
}

TEST_F(CloudCommand, IntensitiesThatHardlyDifferAreLeftOut) {
  const auto rows = [](const char* bright) {
    return sphere(600, 0, 0, 0, true, [&](double, double, double z) { return z > 0.7 ? bright : " 0.5"; });
  };
  const std::vector<std::string> names = {"x", "y", "z", "nx", "ny", "nz", "intensity"};
  put(folder_ / "flat.ply", ply("", 600, names, rows(" 0.45")));
  expect_said(drawn("flat.ply"), {"note: assumed: coloured by normals, for the intensities hardly differ\n",
                                  "unread: intensity\n"});
  // Of the side that is seen: the middle looks back at the eye.
  const Result<Image> image = read_exr(folder_ / "a.exr");
  ASSERT_TRUE(image.ok());
  EXPECT_GT(image->rgba[4 * static_cast<std::size_t>(27 * 96 + 48) + 2], 0.9f);
  put(folder_ / "told.ply", ply("", 600, names, rows(" 0.3")));
  expect_said(drawn("told.ply"), {"an intensity of 0.5 is white"});
}

TEST_F(CloudCommand, DrawsASurveyInTheMillions) {
  std::string rows;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x)
      rows += std::to_string(512345.25 + 0.25 * x) + ' ' + std::to_string(5412345.75 + 0.25 * y) + ' ' +
              std::to_string(310.0 + 0.01 * x) + '\n';
  // One that is far from the rest, as a bird or a fault of the instrument.
  rows += "512345.25 5412345.75 9310\n";
  put(folder_ / "survey.txt", rows);
  expect_said(
      drawn("survey.txt"),
      {"seen from the front and", "z up, as surveys have it, for the points are far from their origin\n",
       "note: assumed: framed by the points, but for 1 of 4801 that are far from the rest\n",
       "coloured by normals"});
  const Result<Image> image = read_exr(folder_ / "a.exr");
  ASSERT_TRUE(image.ok());
  // Estimated normals show their upper side: (0, 0, 1) is a light blue.
  const float* middle = &image->rgba[4 * static_cast<std::size_t>(27 * 96 + 48)];
  EXPECT_GT(middle[2], 0.95f);
}

TEST_F(CloudCommand, FramesTallFilmsAndOtherScales) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    std::ostringstream rows;
    for (int i = 0; i < 400; ++i)
      rows << scale * 3.0 * (i % 20) / 20.0 << ' ' << scale * (i / 20) / 20.0 << " 0 "
           << "0 0 1\n";
    put(folder_ / "plate.xyz", rows.str());
    const Outcome outcome = swept({"render", "plate.xyz", "-o", "a.exr", "--size", "40x80", "--overwrite"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    expect_well_framed("a.exr");
  }
}

TEST_F(CloudCommand, InfoSaysWhatIsAssumed) {
  put(folder_ / "cloud.ply", blender_ply());
  const Outcome outcome = swept({"info", "cloud.ply"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_said(outcome.out, {"points    600, 1 keys", "moves     points yes", "film      1920 x 1080 px",
                            "  assumed: framed by the points\n"});
}

TEST_F(CloudCommand, UpIsWhatIsAskedFor) {
  put(folder_ / "cloud.ply", blender_ply());
  Outcome outcome = swept({"info", "cloud.ply", "--up=-y", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto report = nlohmann::json::parse(outcome.out);
  EXPECT_NEAR(report["camera"]["right"][1].get<double>(), 0.0, 1e-12);
  EXPECT_GT(report["camera"]["down"][1].get<double>(), 0.9) << "down is y";
  EXPECT_GT(report["camera"]["forward"][2].get<double>(), 0.8);
  expect_said(outcome.out, {"up 0 -1 0, as asked"});
  ASSERT_EQ(swept({"init", "cloud.ply", "--up", "1,1,0"}).exit_code, 0);
  EXPECT_NE(test::content_of(folder_ / "scene.json").find("\"up\""), std::string::npos);
  // Of a scene it replaces that of the keys, and tells pictures apart.
  outcome = swept({"info", "scene.json", "--up", "z", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto turned = nlohmann::json::parse(outcome.out);
  EXPECT_NEAR(turned["camera"]["right"][2].get<double>(), 0.0, 1e-12);
  EXPECT_NE(turned["hash"], nlohmann::json::parse(swept({"info", "scene.json", "--json"}).out)["hash"]);
  for (const char* up : {"w", "", "1,2", "0,0,0", "nan,0,0", "--x", "x,"})
    EXPECT_EQ(swept({"info", "cloud.ply", std::string("--up=") + up}).exit_code, 2) << up;
}

TEST_F(CloudCommand, InitWritesTheSceneThatIsDrawn) {
  put(folder_ / "cloud.ply", blender_ply());
  Outcome outcome = swept({"init", "cloud.ply"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_said(outcome.err, {"assumed: framed by the points\n", "scene.json: written\n"});
  drawn("cloud.ply");
  ASSERT_EQ(swept({"render", "scene.json", "-o", "b.exr", "--size", "96x54"}).exit_code, 0);
  const Result<Image> direct = read_exr(folder_ / "a.exr"), written = read_exr(folder_ / "b.exr");
  ASSERT_TRUE(direct.ok() && written.ok());
  EXPECT_EQ(direct->rgba, written->rgba);

  outcome = swept({"init", "cloud.ply"});
  EXPECT_EQ(outcome.exit_code, 1);
  expect_said(outcome.err, {"scene.json: exists"});
  EXPECT_EQ(swept({"init", "cloud.ply", "--overwrite"}).exit_code, 0);
  EXPECT_EQ(swept({"init", "cloud.ply", "-o", "scene.txt"}).exit_code, 2);
  EXPECT_EQ(swept({"init", "scene.json", "-o", "other.json"}).exit_code, 2);
  // From another folder the points are found too.
  ASSERT_EQ(run_command("mkdir '" + (folder_ / "deep") + "'").exit_code, 0);
  ASSERT_EQ(swept({"init", "cloud.ply", "-o", "deep/scene.json"}).exit_code, 0);
  EXPECT_EQ(swept({"info", "deep/scene.json"}).exit_code, 0);
}

/// Two cameras on the z axis at 8 and 5, which look at the origin.
std::string transforms(const std::string& lens) {
  const auto frame = [](const char* z) {
    return std::string("{\"file_path\": \"a.png\", \"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,") + z +
           "],[0,0,0,1]]}";
  };
  return "{" + lens + ", \"frames\": [" + frame("8") + ", " + frame("5") + "]}";
}

TEST_F(CloudCommand, TakesTheCameraOfTransformsJson) {
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

TEST_F(CloudCommand, RefusesCamerasThatItHasNot) {
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

/// What is said in the README to work in one command does, on small files of the same kinds.
TEST_F(CloudCommand, TheCommandsOfTheReadmeDraw) {
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

  std::istringstream readme(test::content_of(SWEPT_README));
  std::vector<std::string> commands;
  for (std::string line; std::getline(readme, line);) {
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

TEST_F(CloudCommand, FailuresNameTheFileAndTheReason) {
  put(folder_ / "torn.ply", blender_ply().substr(0, 900));
  put(folder_ / "empty.xyz", "");
  put(folder_ / "far.xyz", "0 0 0\n1e200 0 0\n0 1e200 0\n");
  put(folder_ / "one.xyz", "1 2 3\n");
  const std::set<std::string> before = folder_.names();
  const auto expect_failure = [&](const std::string& points, const std::string& reason) {
    for (const std::vector<std::string>& line :
         {std::vector<std::string>{"render", points, "-o", "a.exr"}, {"info", points}}) {
      const Outcome outcome = swept(line);
      EXPECT_EQ(outcome.exit_code, 1) << points;
      EXPECT_EQ(outcome.out, "");
      expect_said(outcome.err, {points, reason});
      EXPECT_EQ(folder_.names(), before);
    }
  };
  expect_failure("none.ply", "no such file");
  expect_failure("torn.ply", "the header promises 600");
  expect_failure("empty.xyz", "no points");
  expect_failure("far.xyz", "all points coincide");
  expect_failure("one.xyz", "all points coincide");
  expect_failure("none.%04d.ply", "no such file");
}

}  // namespace
}  // namespace swept
