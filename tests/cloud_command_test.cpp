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
using CloudCommand = test::CloudCommandFolder;

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
