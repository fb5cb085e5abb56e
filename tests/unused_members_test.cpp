// Members of a scene file that change nothing are told, and those that change something are not.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "datasets/generators.h"
#include "splat/io/scene_file.h"
#include "tests/command.h"
#include "tests/temporary_folder.h"
#include "tests/unused_scenes.h"
#include "tools/unused_members.h"

namespace swept {
namespace {

using nlohmann::json;
using test::put;
using test::TemporaryFolder;

/// What is put into a scene, and where.
struct Case {
  std::string scene, pointer;
  json value;
  std::string told;          ///< the pointer in the note; empty: none, and it changes the picture
  std::string options = "";  ///< of the render
};

class UnusedMembers : public ::testing::Test {
 protected:
  void SetUp() override {
    const json ball = {{"source", {{"generator", "sphere"}, {"points", 60}}}};
    scenes_["still"] = test::unused_scene(json::array({ball}));
    scenes_["moving"] = scenes_["still"];
    scenes_["moving"]["objects"][0]["transform"] = test::turning();
    put(folder_ / "one.obj", test::one_triangle);
    scenes_["mesh"] = test::unused_scene(
        {{{"source", {{"file", "one.obj"}}}, {"draw", "triangles"}, {"transform", test::turning()}}});
    const std::string head =
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
        "property float radius\n";
    put(folder_ / "plain.ply", head + "end_header\n0 0 0 0.5\n1 0 0 0.3\n");
    scenes_["plain"] = test::unused_scene({{{"source", {{"file", "plain.ply"}}}}});
    put(folder_ / "fast.ply",
        head +
            "property float vx\nproperty float vy\nproperty float vz\nproperty float t\n"
            "property uchar red\nproperty uchar green\nproperty uchar blue\n"
            "end_header\n0 0 0 0.5 9 0 0 0 9 99 200\n1 0 0 0.3 0 9 0 0.01 99 9 50\n");
    scenes_["fast"] = test::unused_scene({{{"source", {{"file", "fast.ply"}}}}});
    scenes_["lens"] = scenes_["moving"];
    scenes_["lens"]["camera"]["lens"] = {{"aperture", 0.5}, {"focus", 3}};
    scenes_["pulled"] = scenes_["lens"];
    scenes_["pulled"]["camera"]["lens"].erase("focus");
    scenes_["pulled"]["camera"]["keys"][0]["focus"] = 3;
    scenes_["pinhole"] = scenes_["lens"];
    scenes_["pinhole"]["camera"]["lens"] = {{"aperture", 0}};
  }

  [[nodiscard]] test::Outcome render(const json& scene, const std::string& name, const std::string& options) {
    put(folder_ / (name + ".json"), scene.dump());
    return test::run_command("cd '" + folder_ / "" + "' && " SWEPT_COMMAND " render --overwrite " + options +
                             " -o " + name + ".exr " + name + ".json");
  }
  [[nodiscard]] std::vector<float> pixels(const std::string& name) const {
    return test::pixels_of(folder_ / (name + ".exr"));
  }

  std::map<std::string, json> scenes_;
  TemporaryFolder folder_;
};

TEST_F(UnusedMembers, AreToldExactlyWhereTheyChangeNoBit) {
  const Case cases[] = {
      {"moving", "/shutter", {{"open", -0.25}, {"close", 0.25}, {"opening", 0.5}}, "/shutter/opening"},
      {"moving", "/shutter", {{"open", -0.25}, {"close", 0.25}, {"delta", 9}}, "/shutter/delta"},
      {"moving", "/shutter", {{"open", -0.25}, {"close", 0.25}, {"rates", {1, 2}}}, "/shutter/rates"},
      {"moving", "/shutter", {{"open", -0.25}, {"close", 0.25}, {"curve", "gaussian"}, {"delta", 9}}, ""},
      {"still", "/shutter", {{"open", -0.25}, {"close", 0.25}, {"row_delay", 0.01}}, "/shutter/row_delay"},
      {"moving", "/motion", {{"path", "spline"}}, "/motion/path"},
      {"mesh", "/image", {{"depth_tolerance", 3}}, "/image/depth_tolerance"},
      {"moving", "/image", {{"depth_tolerance", 0}}, ""},
      {"moving", "/image", {{"edge_weight", 0.1}}, ""},
      {"moving", "/splats", {{"near", 3}}, "/splats/near"},
      {"mesh", "/objects/0/segments", 3, "/objects/0/segments"},
      {"mesh", "/objects/0/segments", 3, "/objects/0/segments", "--exact"},
      {"still", "/objects/0/segments", 3, "/objects/0/segments", "--exact"},
      {"moving", "/objects/0/segments", 1, "", "--exact"},
      {"plain", "/objects/0/velocity", {{"unit", "per_frame"}}, "/objects/0/velocity/unit"},
      {"fast", "/objects/0/velocity", {{"unit", "per_frame"}}, ""},
      {"plain", "/objects/0/source/frame", 3, "/objects/0/source/frame"},
      {"fast", "/objects/0/source/frame", 3, ""},
      {"plain", "/objects/0/source/color_space", "srgb", "/objects/0/source/color_space"},
      {"fast", "/objects/0/source/color_space", "linear", ""},
      {"fast", "/objects/0/source/attributes", {{"time", "t"}}, "/objects/0/source/attributes/time"},
      {"pinhole", "/camera/lens/focus", 3, "/camera/lens/focus"},
      {"pinhole", "/camera/lens/blades", 5, "/camera/lens/blades"},
      {"pinhole", "/camera/lens/samples", 50, "/camera/lens/samples"},
      {"lens", "/camera/lens/blades", 3, "", "--max-error 40dB"},
      {"lens", "/camera/lens/focus", 2, "", "--max-error 40dB"},
      {"pulled", "/camera/lens/focus", 2, "/camera/lens/focus", "--max-error 40dB"},
      {"lens", "/camera/lens/samples", 9, "", "--exact"},
  };
  for (const Case& c : cases) {
    json with = scenes_[c.scene];
    with[json::json_pointer(c.pointer)] = c.value;
    const test::Outcome told = render(with, "with", c.options),
                        plain = render(scenes_[c.scene], "without", c.options);
    const std::string at =
        c.scene + ' ' + c.pointer + ' ' + c.value.dump() + ' ' + c.options + '\n' + told.err;
    ASSERT_EQ(told.exit_code, 0) << at;
    ASSERT_EQ(plain.exit_code, 0) << at;
    EXPECT_EQ(plain.err.find("change nothing"), std::string::npos) << plain.err;
    EXPECT_EQ(plain.err.find("changes nothing"), std::string::npos) << plain.err;
    if (c.told.empty()) {
      EXPECT_EQ(told.err.find("changes nothing"), std::string::npos) << at;
      EXPECT_NE(pixels("with"), pixels("without")) << at;
    } else {
      EXPECT_NE(told.err.find("note: with.json: " + c.told + " changes nothing: "), std::string::npos) << at;
      EXPECT_EQ(pixels("with"), pixels("without")) << at;
    }
  }
}

TEST_F(UnusedMembers, KeysThatTheExposureIsBeyondAreAllButOne) {
  json all = scenes_["plain"], lone = scenes_["plain"];
  const json first = {{"frame", 5}, {"translate", {0.3, 0, 0}}},
             last = {{"frame", 7}, {"translate", {0, 1, 0}}};
  all["objects"][0]["transform"] = {{"keys", {first, last}}};
  for (const bool before : {true, false}) {
    lone["objects"][0]["transform"] = {{"keys", {before ? first : last}}};
    const std::string frame = before ? "--frames 1" : "--frames 9";
    const test::Outcome told = render(all, "with", frame), alone = render(lone, "without", frame);
    EXPECT_NE(
        told.err.find("with.json: /objects/0/transform/keys but for one change nothing: the exposure is " +
                      std::string(before ? "before the first" : "after the last")),
        std::string::npos)
        << told.err;
    EXPECT_EQ(alone.err.find("change nothing"), std::string::npos) << alone.err;
    EXPECT_EQ(pixels("with"), pixels("without"));
  }
  // Among frames that show the motion, none is told of; nor is what only some of the frames make no use of.
  put(folder_ / "all.json", all.dump());
  const std::string at = "cd '" + folder_ / "" + "' && " SWEPT_COMMAND " ";
  const test::Outcome clip = test::run_command(at + "render all.json --dry-run --frames 1-9");
  EXPECT_EQ(clip.err.find("change nothing"), std::string::npos) << clip.err;
  const test::Outcome rest = test::run_command(at + "render all.json --dry-run --frames 8-12");
  EXPECT_NE(rest.err.find("after the last of them"), std::string::npos) << rest.err;
  json camera = scenes_["plain"];
  camera["camera"]["keys"] = {{{"frame", 5}, {"eye", {0, 0, 5}}, {"target", {0, 0, 0}}},
                              {{"frame", 6}, {"eye", {1, 0, 5}}, {"target", {0, 0, 0}}}};
  put(folder_ / "camera.json", camera.dump());
  const test::Outcome info = test::run_command(at + "info camera.json");
  EXPECT_NE(info.out.find("camera.json: /camera/keys but for one change nothing"), std::string::npos)
      << info.out;
}

TEST_F(UnusedMembers, AreNotToldOfWhatOptionsReplaceNorOfPointsAlone) {
  json scene = scenes_["moving"];
  scene["image"] = {{"edge_weight", 0.1}, {"coverage", "hard"}};
  EXPECT_NE(render(scene, "with", "").err.find("/image/edge_weight changes nothing"), std::string::npos);
  const test::Outcome replaced = render(scene, "with", "--edge-weight 0.2");
  EXPECT_EQ(replaced.err.find("/image/edge_weight"), std::string::npos) << replaced.err;
  const test::Outcome points =
      test::run_command("cd '" + folder_ / "" + "' && " SWEPT_COMMAND " info plain.ply");
  EXPECT_EQ(points.out.find("changes nothing"), std::string::npos) << points.out;
}

/// What is shown to others is no bad example.
TEST_F(UnusedMembers, AreInNoneOfTheDatasets) {
  SceneOverrides few;
  few.points_scale = 0.01;
  std::size_t scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SWEPT_SCENES)) {
    if (entry.path().extension() != ".json" || entry.path().filename() == "scene.schema.json") continue;
    Result<SceneFile> file = read_scene_file(entry.path(), few);
    ASSERT_TRUE(file.ok()) << file.error().message();
    const Result<const Scene*> scene = file->scene_at(file->scene().frame, generate);
    ASSERT_TRUE(scene.ok()) << scene.error().message();
    for (const UnusedMember& unused : unused_members({}, *file, **scene))
      ADD_FAILURE() << unused.text(file->path());
    ++scenes;
  }
  EXPECT_GE(scenes, 7u);
}

}  // namespace
}  // namespace swept
