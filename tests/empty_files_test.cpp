// Sequences in which some files have no points: those are frames of nothing, and no errors.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "abuffer/sampled.h"
#include "splat/io/cloud_scene.h"
#include "splat/io/cloud_source.h"
#include "splat/io/scene_file.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using nlohmann::json;
using test::put;
using test::TemporaryFolder;

std::string ply(const std::string& properties, const std::vector<std::string>& rows) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(rows.size()) + "\n" +
                     properties + "end_header\n";
  for (const std::string& row : rows) text += row + "\n";
  return text;
}
const std::string xyz = "property float x\nproperty float y\nproperty float z\nproperty float radius\n";
const std::string with_id = xyz + "property int id\n";

/// Nothing at 1 and 2, points at 3 and 4, nothing at 5.
class EmptyFiles : public ::testing::Test {
 protected:
  void write(const std::string& properties, const std::vector<std::vector<std::string>>& files) const {
    for (std::size_t k = 0; k < files.size(); ++k)
      put(folder_ / ("p." + std::to_string(k + 1) + ".ply"), ply(properties, files[k]));
  }
  [[nodiscard]] Result<SceneFile> scene(const std::string& pattern) const {
    json text = json::parse(R"({"swept": 1, "film": {"width": 32, "height": 32},
      "camera": {"fov": {"axis": "vertical", "degrees": 60}, "keys": [{"eye": [0, 0, 5], "target": [0, 0, 0]}]}})");
    text["objects"] = json::array({{{"source", {{"sequence", pattern}}}}});
    return scene_from_text(text.dump(), folder_ / "scene.json");
  }
  static bool says(const SceneFile& file, const std::string& what) {
    const std::vector<std::string> notes = file.notes();
    return std::any_of(notes.begin(), notes.end(),
                       [&](const std::string& note) { return note.find(what) != std::string::npos; });
  }

  TemporaryFolder folder_;
};

const Generator none = {};

TEST_F(EmptyFiles, AreFramesWithoutPoints) {
  write(xyz, {{}, {}, {"0 0 0 1", "1 0 0 1"}, {"0 1 0 1", "1 1 0 1"}, {}});
  Result<SceneFile> file = scene("p.%d.ply");
  ASSERT_TRUE(file.ok()) << file.error().message();
  const std::size_t counts[] = {0, 0, 2, 2, 0};
  for (int frame = 1; frame <= 5; ++frame) {
    const Result<const Scene*> loaded = file->scene_at(frame, none);
    ASSERT_TRUE(loaded.ok()) << frame << loaded.error().message();
    EXPECT_EQ((*loaded)->objects[0].cloud.size(), counts[frame - 1]) << frame;
    EXPECT_TRUE(says(*file, "has no points")) << frame;
    EXPECT_TRUE((*loaded)->validate().ok()) << frame;
    const Result<Rendered> rendered = render_sampled(**loaded);
    ASSERT_TRUE(rendered.ok()) << frame << rendered.error().message();
    const std::vector<float>& rgba = rendered->image.rgba;
    EXPECT_EQ(std::any_of(rgba.begin(), rgba.end(), [](float v) { return v > 0.0f; }), counts[frame - 1] > 0)
        << frame;
  }
}

TEST_F(EmptyFiles, HavePointsBesideThemFromHalfwayOn) {
  const std::vector<std::vector<std::string>> with_ids = {
      {}, {}, {"0 0 0 1 7", "1 0 0 1 8"}, {"1 1 0 1 8"}, {}};
  const std::vector<std::vector<std::string>> without = {
      {}, {}, {"0 0 0 1", "1 0 0 1"}, {"0 1 0 1", "1 1 0 1"}, {}};
  for (const bool ids : {false, true}) {
    write(ids ? with_id : xyz, ids ? with_ids : without);
    CloudSource source;
    source.may_be_empty = true;
    for (int k = 1; k <= 5; ++k)
      source.files.push_back({static_cast<double>(k), folder_ / ("p." + std::to_string(k) + ".ply")});
    const Result<LoadedCloud> early = read_cloud(source, 2.0, 3.0), late = read_cloud(source, 4.0, 5.0);
    ASSERT_TRUE(early.ok() && late.ok());
    ASSERT_EQ(early->cloud.lifetime.size(), early->cloud.size());
    ASSERT_GE(early->cloud.size(), 2u);
    for (const Lifetime& life : early->cloud.lifetime) EXPECT_EQ(life.born, 2.5);
    ASSERT_EQ(late->cloud.lifetime.size(), late->cloud.size());
    for (const Lifetime& life : late->cloud.lifetime) EXPECT_EQ(life.gone, 4.5);
    // An exposure that reaches none of the boundaries is that of the other files alone.
    const Result<LoadedCloud> middle = read_cloud(source, 3.0, 3.4);
    ASSERT_TRUE(middle.ok());
    EXPECT_TRUE(middle->cloud.lifetime.empty());
    // Before and after: nothing.
    EXPECT_EQ(read_cloud(source, 1.0, 1.9)->cloud.size(), 0u);
    EXPECT_EQ(read_cloud(source, 5.0, 9.0)->cloud.size(), 0u);
  }
}

TEST_F(EmptyFiles, BetweenOthersHideTheFartherOnesAndSaySo) {
  write(xyz, {{"0 0 0 1"}, {}, {"0 2 0 1", "1 2 0 1"}});
  CloudSource source;
  source.may_be_empty = true;
  for (int k = 1; k <= 3; ++k)
    source.files.push_back({static_cast<double>(k), folder_ / ("p." + std::to_string(k) + ".ply")});
  const Result<LoadedCloud> loaded = read_cloud(source, 1.0, 3.5);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  EXPECT_EQ(loaded->cloud.size(), 2u);
  const std::vector<std::string>& assumed = loaded->report.assumed;
  EXPECT_TRUE(std::any_of(assumed.begin(), assumed.end(), [](const std::string& line) {
    return line.find("are left out") != std::string::npos;
  }));
}

TEST_F(EmptyFiles, AreErrorsWhereTheyStandAloneOrHaveNoHeader) {
  write(xyz, {{}});
  CloudSource alone;
  alone.files = {{1.0, folder_ / "p.1.ply"}};
  EXPECT_FALSE(read_cloud(alone, 1.0, 1.0).ok());
  put(folder_ / "t.1.xyz", "");
  put(folder_ / "t.2.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  Result<SceneFile> text = scene("t.%d.xyz");
  ASSERT_TRUE(text.ok());
  EXPECT_FALSE(text->scene_at(1.0, none).ok());
}

TEST_F(EmptyFiles, OfOtherFormatsAreFramesToo) {
  put(folder_ / "q.1.pcd",
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\nHEIGHT "
      "1\nPOINTS 0\n"
      "DATA ascii\n");
  put(folder_ / "q.2.pcd",
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT "
      "1\nPOINTS 3\n"
      "DATA ascii\n0 0 0\n1 0 0\n0 1 0\n");
  std::string splats = "property float x\nproperty float y\nproperty float z\n";
  for (const char* name : {"f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0",
                           "rot_1", "rot_2", "rot_3"})
    splats += "property float " + std::string(name) + "\n";
  put(folder_ / "o.1.off", "OFF\n0 0 0\n");
  put(folder_ / "o.2.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  put(folder_ / "s.1.ply", ply(splats, {}));
  put(folder_ / "s.2.ply", ply(splats, {"0 0 0 1 0 1 2 -1 -1 -1 1 0 0 0"}));
  for (const char* pattern : {"q.%d.pcd", "o.%d.off", "s.%d.ply"}) {
    Result<SceneFile> file = scene(pattern);
    ASSERT_TRUE(file.ok()) << file.error().message();
    const Result<const Scene*> empty = file->scene_at(1.0, none);
    ASSERT_TRUE(empty.ok()) << pattern << empty.error().message();
    EXPECT_EQ((*empty)->objects[0].cloud.size() + (*empty)->objects[0].splats.size(), 0u) << pattern;
    EXPECT_TRUE(says(*file, "has no points")) << pattern;
    const Result<const Scene*> full = file->scene_at(2.0, none);
    ASSERT_TRUE(full.ok()) << pattern << full.error().message();
    EXPECT_GT((*full)->objects[0].cloud.size() + (*full)->objects[0].splats.size(), 0u) << pattern;
  }
}

TEST_F(EmptyFiles, AreLeftOutWhereACameraIsSought) {
  write(xyz, {{}, {}, {}, {}, {}, {}, {}, {"5 5 5 1", "7 5 5 1"}, {}});
  const Result<CloudScene> framed = scene_of_points(folder_ / "p.%d.ply", folder_ / "");
  ASSERT_TRUE(framed.ok()) << framed.error().message();
  write(xyz, {{}, {}, {}, {}, {}, {}, {}, {}, {}});
  const Result<CloudScene> nothing = scene_of_points(folder_ / "p.%d.ply", folder_ / "");
  ASSERT_FALSE(nothing.ok());
  EXPECT_NE(nothing.error().reason.find("none of its files has points"), std::string::npos);
}

}  // namespace
}  // namespace swept
