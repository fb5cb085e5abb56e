// Sequences whose points change their order or their number: matched by id, moved by velocity, or refused.
#include <cmath>

#include "splat/io/cloud_source.h"
#include "splat/io/match_points.h"
#include "splat/io/scene_file.h"
#include "tests/point_files.h"
#include "tests/point_reports.h"

namespace {

using namespace swept;
using Eigen::Vector3d;
using Eigen::Vector3f;
using swept_test::float_ply;
using swept_test::has_part;
using swept_test::joined;

using MatchedPointsTest = swept_test::PointFiles;
using Rows = std::vector<std::vector<double>>;

const std::vector<std::string> kWithIds{"x", "y", "z", "nx", "ny", "nz", "radius", "id"};
const std::vector<std::string> kWithVelocities{"x", "y", "z", "nx", "ny", "nz", "radius", "vx", "vy", "vz"};

class Sequence {
 public:
  explicit Sequence(const swept::test::TemporaryFolder& folder) : folder_(folder) {}
  void add(const std::vector<std::string>& names, const Rows& rows) {
    const std::string path = folder_ / ("k" + std::to_string(source.files.size()) + ".ply");
    swept::test::put(path, float_ply("binary_little_endian", names, rows));
    source.files.push_back({static_cast<double>(source.files.size()), path});
  }
  CloudSource source;

 private:
  const swept::test::TemporaryFolder& folder_;
};

/// x of every point at a frame.
std::vector<double> x_at(const SurfelCloud& cloud, double frame) {
  std::vector<double> x;
  for (std::size_t i = 0; i < cloud.size(); ++i) x.push_back(surfel_at(cloud, i, frame).position.x());
  return x;
}

TEST_F(MatchedPointsTest, AnotherOrderIsPutRightById) {
  Sequence sequence(folder_);
  sequence.add(kWithIds, {{-1, 0, 0, 0, 0, 1, 0.1, 1}, {1, 0, 0, 0, 0, 1, 0.2, 2}});
  sequence.add(kWithIds, {{1, 0.5, 0, 0, 0, 1, 0.2, 2}, {-1, 0.5, 0, 0, 0, 1, 0.1, 1}});
  const Result<LoadedCloud> loaded = read_cloud(sequence.source, 0.25, 0.75);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  ASSERT_EQ(loaded->cloud.keys.size(), 2u);
  EXPECT_EQ(x_at(loaded->cloud, 0.5), (std::vector<double>{-1, 1}));
  const SurfelInstant first = surfel_at(loaded->cloud, 0, 0.5);
  EXPECT_EQ(first.position.y(), 0.25);
  EXPECT_NEAR(first.axis_u.norm(), 0.1, 1e-7);  // its radius came along
  EXPECT_TRUE(has_part(loaded->report.assumed, "same by id")) << joined(loaded->report.assumed);
  // Unread on request, and then the two cross.
  sequence.source.attributes["id"] = "";
  EXPECT_EQ(x_at(read_cloud(sequence.source, 0.25, 0.75)->cloud, 0.5), (std::vector<double>{0, 0}));
}

TEST_F(MatchedPointsTest, ThePointsAreThoseOfTheNearestFile) {
  std::vector<std::string> names = kWithIds;
  for (const char* v : {"vx", "vy", "vz"}) names.push_back(v);
  Sequence sequence(folder_);
  sequence.add(names, {{0, 0, 0, 0, 0, 1, 0.1, 7, 0, 0, 0}});
  sequence.add(names, {{1, 0, 0, 0, 0, 1, 0.1, 7, 24, 0, 0},
                       {5, 0, 0, 0, 0, 1, 0.1, 8, 48, 0, 0},
                       {9, 0, 0, 0, 0, 1, 0.1, 9, 0, 0, 0}});
  sequence.add(names, {{9, 0, 0, 0, 0, 1, 0.1, 9, 0, 0, 0},
                       {2, 0, 0, 0, 0, 1, 0.1, 7, 0, 0, 0},
                       {20, 0, 0, 0, 0, 1, 0.1, 11, 0, 0, 0}});
  const Result<LoadedCloud> loaded = read_cloud(sequence.source, 0.75, 1.25);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  EXPECT_EQ(x_at(loaded->cloud, 1.0), (std::vector<double>{1, 5, 9}));
  // Point 8 is in the middle file alone, with 48 a second, 2 a frame; 9 is born there.
  EXPECT_EQ(x_at(loaded->cloud, 0.5), (std::vector<double>{0.5, 4, 9}));
  EXPECT_EQ(x_at(loaded->cloud, 1.5), (std::vector<double>{1.5, 6, 9}));
  const auto& said = loaded->report.assumed;
  EXPECT_TRUE(has_part(said, "2 points of " + (folder_ / "k1.ply") + " are not in " + (folder_ / "k0.ply")));
  EXPECT_TRUE(has_part(said, "1 points of " + (folder_ / "k2.ply") + " are not in " + (folder_ / "k1.ply") +
                                 ", and are left out"))
      << joined(said);
  EXPECT_TRUE(has_part(said, "move along their velocities")) << joined(said);
  sequence.source.velocity_unit = VelocityUnit::ignore;
  const Result<LoadedCloud> still = read_cloud(sequence.source, 0.75, 1.25);
  EXPECT_EQ(x_at(still->cloud, 1.5), (std::vector<double>{1.5, 5, 9}));
  EXPECT_TRUE(has_part(still->report.assumed, "stand still")) << joined(still->report.assumed);
}

TEST_F(MatchedPointsTest, CountsThatChangeWithoutIdsNeedVelocities) {
  Sequence sequence(folder_);
  sequence.add(kWithVelocities, {{0, 0, 0, 0, 0, 1, 0.1, 12, 0, 0}});
  sequence.add(kWithVelocities, {{0.5, 0, 0, 0, 0, 1, 0.1, 12, 0, 0}, {3, 0, 0, 0, 0, 1, 0.1, 24, 0, 0}});
  sequence.add(kWithVelocities, {{4, 0, 0, 0, 0, 1, 0.1, 24, 0, 0}});
  const Result<LoadedCloud> loaded = read_cloud(sequence.source, 0.75, 1.25);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  EXPECT_EQ(loaded->cloud.keys.size(), 1u);
  EXPECT_EQ(x_at(loaded->cloud, 1.5), (std::vector<double>{0.75, 3.5}));
  EXPECT_EQ(x_at(loaded->cloud, 0.5), (std::vector<double>{0.25, 2.5}));
  EXPECT_TRUE(has_part(loaded->report.assumed, "numbers of points differ")) << joined(loaded->report.assumed);
  EXPECT_TRUE(has_part(loaded->report.assumed, "per second, at 24")) << joined(loaded->report.assumed);
  // Of two at the same distance the earlier.
  EXPECT_EQ(read_cloud(sequence.source, 0.25, 0.75)->cloud.size(), 1u);
  sequence.source.velocity_unit = VelocityUnit::ignore;
  const Result<LoadedCloud> refused = read_cloud(sequence.source, 0.75, 1.25);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "points");
}

TEST_F(MatchedPointsTest, IdsThatAreNoneDoNotMatter) {
  // A label that many points share is no id; neither is a fraction.
  for (const double second : {1.0, 2.5}) {
    Sequence sequence(folder_);
    sequence.add(kWithIds, {{0, 0, 0, 0, 0, 1, 0.1, 1}, {5, 0, 0, 0, 0, 1, 0.1, second}});
    sequence.add(kWithIds, {{1, 0, 0, 0, 0, 1, 0.1, 1}, {6, 0, 0, 0, 0, 1, 0.1, second}});
    const Result<LoadedCloud> loaded = read_cloud(sequence.source, 0, 1);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message();
    EXPECT_EQ(x_at(loaded->cloud, 0.5), (std::vector<double>{0.5, 5.5}));
    EXPECT_TRUE(has_part(loaded->report.assumed, "ids are not used")) << joined(loaded->report.assumed);
  }
  // Some files with ids, some without: neither way would be certain.
  Sequence mixed(folder_);
  mixed.add(kWithIds, {{0, 0, 0, 0, 0, 1, 0.1, 1}, {5, 0, 0, 0, 0, 1, 0.1, 2}});
  mixed.add(kWithIds, {{0, 0, 0, 0, 0, 1, 0.1, 1}, {5, 0, 0, 0, 0, 1, 0.1, 1}});
  const Result<LoadedCloud> refused = read_cloud(mixed.source, 0, 1);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "id");
  EXPECT_EQ(refused.error().file, folder_ / "k1.ply");
}

TEST_F(MatchedPointsTest, ColoursGoWithThePointsOfTheNearestFile) {
  const std::vector<std::string> names{"x", "y", "z", "radius", "id", "red", "green", "blue"};
  Sequence sequence(folder_);
  sequence.add(names, {{0, 0, 0, 1, 1, 1, 0, 0}, {1, 0, 0, 1, 2, 0, 1, 0}, {0, 1, 0, 1, 3, 0, 0, 1}});
  sequence.add(names, {{0, 1, 0, 1, 3, 0, 0, 0.5}, {1, 0, 0, 1, 2, 0, 0.5, 0}, {0, 0, 0, 1, 1, 0.5, 0, 0}});
  const Result<LoadedCloud> loaded = read_cloud(sequence.source, 0.5, 1.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  EXPECT_EQ(loaded->cloud.color[0], Vector3f(0, 0, 0.5f));
  EXPECT_EQ(surfel_at(loaded->cloud, 0, 0.0).position, Vector3d(0, 1, 0));
}

TEST_F(MatchedPointsTest, FilesOfOneSequenceWithOtherAttributesAreTold) {
  Sequence sequence(folder_);
  sequence.add({"x", "y", "z", "radius"}, {{0, 0, 0, 1}});
  sequence.add({"x", "y", "z", "pscale"}, {{1, 0, 0, 1}});
  const Result<LoadedCloud> loaded = read_cloud(sequence.source, 0, 1);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  EXPECT_TRUE(has_part(loaded->report.assumed, "other attributes")) << joined(loaded->report.assumed);
}

TEST_F(MatchedPointsTest, WhatAMissingPointNeedsMustBeThere) {
  PointSet reference, other;
  reference.position = {{0, 0, 0}, {1, 0, 0}};
  reference.id = {1, 2};
  other.position = {{5, 0, 0}};
  other.id = {2};
  const auto matched = match_by_id(reference, other, 1.0);
  ASSERT_TRUE(matched.ok());
  EXPECT_EQ(matched->missing, 1u);
  EXPECT_EQ(matched->extra, 0u);
  EXPECT_EQ(matched->set.position, (std::vector<Vector3d>{{0, 0, 0}, {5, 0, 0}}));
  other.radius = {1.0f};
  EXPECT_FALSE(match_by_id(reference, other, 1.0).ok());
}

TEST_F(MatchedPointsTest, WhatIsMissingIsToldToo) {
  const auto said = [&](const std::vector<std::string>& names, const Rows& rows) {
    Sequence sequence(folder_);
    sequence.add(names, rows);
    return read_cloud(sequence.source, 0, 0)->report.assumed;
  };
  const auto bare = said({"x", "y", "z", "radius"}, {{0, 0, 0, 1}});
  EXPECT_TRUE(has_part(bare, "no velocities: the points stand still")) << joined(bare);
  EXPECT_TRUE(has_part(bare, "no colours: white")) << joined(bare);
  const auto still = said({"x", "y", "z", "radius", "vx", "vy", "vz"}, {{0, 0, 0, 1, 0, 0, 0}});
  EXPECT_TRUE(has_part(still, "all zero")) << joined(still);
}

constexpr const char* kCamera =
    R"("camera": {"fov": {"axis": "vertical", "degrees": 40}, "keys": [{"eye": [0,0,5], "target": [0,0,0]}]})";

TEST_F(MatchedPointsTest, ASceneStatesRangeAndSpaceAndTellsWhatWasRead) {
  write("c.ply",
        float_ply("ascii", {"x", "y", "z", "radius", "red", "green", "blue", "vx", "vy", "vz", "mass"},
                  {{0, 0, 0, 1, 100, 50, 25, 1, 2, 3, 4}}));
  const auto load = [&](const std::string& members) {
    const std::string text = std::string(R"({"swept": 1, )") + kCamera +
                             R"(, "objects": [{"name": "dot", "source": {"file": "c.ply")" + members + "}}]}";
    return scene_from_text(text, folder_ / "scene.json");
  };
  Result<SceneFile> file = load(R"(, "color_range": 100, "color_space": "linear")");
  ASSERT_TRUE(file.ok()) << file.error().message();
  const auto no_generator = [](const std::string&, std::size_t, const std::map<std::string, double>&) {
    return Result<SurfelCloud>(Error{"", "generator", "none"});
  };
  const Result<const Scene*> scene = file->scene_at(1.0, no_generator);
  ASSERT_TRUE(scene.ok()) << scene.error().message();
  EXPECT_EQ((*scene)->objects[0].cloud.color[0], Vector3f(1, 0.5f, 0.25f));
  const std::vector<std::string> notes = file->notes();
  for (const char* part :
       {"dot: read: position from x, y, z; velocity from vx, vy, vz; color from red, green, "
        "blue; radius from radius",
        "dot: unread: mass", "colours from 0 to 100, linear, as stated",
        "velocities are per second, at 24 frames per second"}) {
    EXPECT_TRUE(has_part(notes, part)) << part << "\n" << joined(notes);
  }
  for (const auto& [wrong, pointer] : {std::pair{R"(, "color_range": 0)", "/objects/0/source/color_range"},
                                       {R"(, "color_range": "255")", "/objects/0/source/color_range"},
                                       {R"(, "color_space": "sRGB")", "/objects/0/source/color_space"}}) {
    const Result<SceneFile> refused = load(wrong);
    ASSERT_FALSE(refused.ok()) << wrong;
    EXPECT_EQ(refused.error().field, pointer);
  }
  const Result<SceneFile> sequence = scene_from_text(
      std::string(R"({"swept": 1, )") + kCamera +
          R"(, "objects": [{"source": {"sequence": "c%d.ply", "first": 1, "last": 2, "color_space": "srgb"}}]})",
      folder_ / "scene.json");
  ASSERT_TRUE(sequence.ok()) << sequence.error().message();
  EXPECT_EQ(std::get<SequenceSource>(sequence->sources()[0].points).stored.space, ColorSpace::srgb);
}

}  // namespace
