// What someone meets who does not know the command yet: other files than it reads, patterns that a shell took
// apart, frames that are not there, pictures of nothing.
#include <filesystem>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/cloud_files.h"

namespace swept {
namespace {

using test::expect_said;
using test::Outcome;
using test::ply;
using test::put;
using test::sphere;

class Newcomer : public test::CloudCommandFolder {
 protected:
  void SetUp() override {
    for (int i = 1; i <= 3; ++i)
      put(folder_ / ("anim.000" + std::to_string(i) + ".ply"),
          ply("", 100, {"x", "y", "z"},
              sphere(100, 0.1 * i, 0, 0, false, [](double, double, double) { return ""; })));
  }
  Outcome render(const std::string& points, const std::string& output = "a.exr") const {
    return swept({"render", points, "-o", output, "--size", "32x18", "--overwrite"});
  }
};

TEST_F(Newcomer, FilesThatAreNotReadAreNamedForWhatTheyAre) {
  for (const char* extension : {".las", ".LAZ", ".e57"}) {
    put(folder_ / ("scan" + std::string(extension)), std::string("LASF\0\0\1", 7));
    const Outcome outcome = render("scan" + std::string(extension));
    EXPECT_EQ(outcome.exit_code, 1);
    expect_said(outcome.err, {" files are not read; PDAL and CloudCompare save them as .ply"});
    for (const auto& [name, advice] :
         {std::pair{"a.usd", ".usd files are not read; Houdini and Blender save their"},
          {"a.fbx", ".fbx files are not read; Blender saves them as .ply or .obj"},
          {"a.ksplat", ".ksplat files are not read; SuperSplat"},
          {"a.png", ".png files are not read; points, meshes and splats are"}}) {
      put(folder_ / name, "x");
      expect_said(render(name).err, {advice});
    }
    put(folder_ / "transforms.json", R"({"camera_angle_x": 1, "frames": []})");
    expect_said(render("transforms.json").err, {"one of cameras: swept render POINTS --camera FILE"});
    put(folder_ / "mesh.gltf",
        R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                                 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]})");
    expect_said(render("mesh.gltf").err,
                {"has no splats of KHR_gaussian_splatting, and its meshes are not read"});
  }
  put(folder_ / "points", "1 2 3\n4 5 6\n");
  expect_said(render("points").err,
              {"points: is no scene file, which is a JSON object, and its extension is none of"});
  // What may be a scene by its content still says where it is wrong.
  put(folder_ / "scene", " {\"swept\": 1,}");
  expect_said(render("scene").err, {"scene: line 1, column 14"});
  put(folder_ / "scene.json", "[]");
  expect_said(render("scene.json").err, {"a scene file is one JSON object"});
  std::filesystem::create_directory(folder_ / "frames");
  expect_said(render("frames").err, {"frames: is a folder; files in it are named as one"});
}

TEST_F(Newcomer, APatternThatTheShellTookApartIsExplained) {
  const Outcome outcome = swept({"render", "anim.0001.ply", "anim.0002.ply", "anim.0003.ply", "-o", "a.exr"});
  EXPECT_EQ(outcome.exit_code, 2);
  expect_said(outcome.err, {"Numbered files are one argument, in quotes: 'name.%04d.ply'"});
  EXPECT_EQ(swept({"render", "anim.0001.ply", "nonsense", "-o", "a.exr"}).err.find("Numbered"),
            std::string::npos);
}

TEST_F(Newcomer, AFolderThatIsNotThereIsNamed) {
  const Outcome outcome = render("anim.0001.ply", "out/of/here/a.exr");
  EXPECT_EQ(outcome.exit_code, 1);
  expect_said(outcome.err, {"out/of/here/a.exr: cannot be written: there is no folder out/of/here"});
}

TEST_F(Newcomer, FramesBeyondASequenceAreTold) {
  const auto told = [&](const std::string& frames) {
    return swept({"render", "anim.%04d.ply", "-o", "f.%d.exr", "--size", "32x18", "--frames", frames,
                  "--overwrite"})
        .err;
  };
  expect_said(told("3-5"), {"frames after the last file, 3, show its points"});
  expect_said(told("-2-0"), {"frames before the first file, 1, show its points"});
  EXPECT_EQ(told("1-3").find("show its points"), std::string::npos);
}

TEST_F(Newcomer, ColoursThatHalfFloatsDoNotHoldAreTold) {
  const auto told = [&](const std::string& red, const std::string& option) {
    std::vector<std::string> arguments = {"render",      "anim.0001.ply", "-o",          "half.exr",
                                          "--overwrite", "--background",  red + ",0,0,1"};
    if (!option.empty()) arguments.push_back(option);
    const Outcome outcome = swept(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.err.find("has colours above 65504") != std::string::npos;
  };
  EXPECT_TRUE(told("70000", "--half"));
  EXPECT_FALSE(told("65504", "--half"));
  EXPECT_FALSE(told("70000", ""));
}

TEST_F(Newcomer, APictureOfNothingIsTold) {
  const std::string scene =
      R"({"swept": 1, "film": {"width": 32, "height": 18}, "camera": {"fov": {"axis": "vertical",
    "degrees": 40}, "keys": [{"eye": [0, 0, 5], "target": [0, 0, 9]}]}, "objects": [)";
  put(folder_ / "behind.json", scene + R"({"source": {"file": "anim.0001.ply"}}]})");
  for (const char* method : {"sampled", "abuffer", "stochastic", "reference"}) {
    const Outcome outcome =
        swept({"render", "behind.json", "-o", "a.exr", "--overwrite", "--method", method});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    expect_said(outcome.err, {"note: frame 1 shows nothing"});
  }
  // A strip of a film may well be empty, and so may a scene.
  EXPECT_EQ(
      swept({"render", "behind.json", "-o", "a.exr", "--overwrite", "--part", "1/2"}).err.find("nothing"),
      std::string::npos);
  put(folder_ / "empty.json", scene + "]}");
  EXPECT_EQ(render("empty.json").err.find("nothing"), std::string::npos);
  EXPECT_EQ(render("anim.0001.ply").err.find("nothing"), std::string::npos);
}

TEST_F(Newcomer, NotesNameAFileOnce) {
  const std::string err = render("anim.0001.ply").err;
  expect_said(err, {"note: anim.0001.ply: radii estimated"});
  EXPECT_EQ(err.find("anim.0001.ply: anim.0001.ply"), std::string::npos);
  // Nor in a folder, nor by the name that a scene gives it.
  std::filesystem::create_directories(folder_ / "sub");
  std::filesystem::copy_file(folder_ / "anim.0001.ply", folder_ / "sub/anim.0001.ply");
  for (const char* scene : {"sub/anim.0001.ply", "named.json"}) {
    put(folder_ / "named.json", R"({"swept": 1, "film": {"width": 16, "height": 16}, "camera": {"fov": {
      "axis": "vertical", "degrees": 40}, "keys": [{"eye": [0, 0, 5], "target": [0, 0, 0]}]}, "objects": [
      {"name": "cloud", "source": {"file": "sub/anim.0001.ply"}}]})");
    const std::string said = render(scene).err;
    expect_said(said,
                {scene[0] == 's' ? "note: anim.0001.ply: radii estimated" : "note: cloud: radii estimated"});
    EXPECT_EQ(said.find("sub/anim.0001.ply: radii"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace swept
