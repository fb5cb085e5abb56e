// Splats as they are trained, in PLY: every number where it belongs, and what a file may leave out.
#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/io/read_splats.h"
#include "tests/point_files.h"

namespace {

using namespace swept;
using swept_test::float_ply;
using swept_test::kPlyFormats;

class SplatPlyTest : public swept_test::PointFiles {
 protected:
  Result<LoadedSplats> read(const std::string& bytes, bool skip_invalid = false) const {
    SplatReadOptions options;
    options.skip_invalid = skip_invalid;
    return read_splats(write("splats.ply", bytes), options);
  }
  LoadedSplats loaded(const std::string& bytes) const {
    Result<LoadedSplats> result = read(bytes);
    EXPECT_TRUE(result.ok()) << result.error().message();
    if (!result.ok()) return {};
    EXPECT_TRUE(result->splats.validate().ok()) << result->splats.validate().error().message();
    return *std::move(result);
  }
};

/// Names and one value each, distinct, of a splat with `rest` numbers of f_rest.
struct Fields {
  std::vector<std::string> names{"x",       "y",       "z",       "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
                                 "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};
  std::vector<double> values{1, 2, 3, 0.25, 0.5, -0.75, 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, -2.0};

  explicit Fields(std::size_t rest = 0) {
    for (std::size_t k = 0; k < rest; ++k) add("f_rest_" + std::to_string(k), static_cast<double>(k) / 64.0);
  }
  void add(const std::string& name, double value) {
    names.push_back(name);
    values.push_back(value);
  }
  void set(const std::string& name, double value) {
    for (std::size_t k = 0; k < names.size(); ++k)
      if (names[k] == name) values[k] = value;
  }
  void drop(const std::string& name) {
    for (std::size_t k = names.size(); k-- > 0;) {
      if (names[k] != name) continue;
      names.erase(names.begin() + static_cast<std::ptrdiff_t>(k));
      values.erase(values.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }
  [[nodiscard]] std::string bytes(const std::string& format = "binary_little_endian") const {
    return float_ply(format, names, {values});
  }
};

TEST_F(SplatPlyTest, EveryNumberIsWhereItBelongsInEveryOrderAndFormat) {
  for (const std::string& format : kPlyFormats) {
    for (const bool backwards : {false, true}) {
      Fields fields(24);
      if (backwards) {
        std::reverse(fields.names.begin(), fields.names.end());
        std::reverse(fields.values.begin(), fields.values.end());
      }
      const LoadedSplats file = loaded(fields.bytes(format));
      const SplatCloud& cloud = file.splats;
      ASSERT_EQ(cloud.size(), 1u) << format;
      EXPECT_EQ(cloud.position[0], Eigen::Vector3d(1, 2, 3));
      for (int k = 0; k < 3; ++k) EXPECT_FLOAT_EQ(cloud.scale[0][k], std::exp(static_cast<float>(k) - 1.0f));
      EXPECT_EQ(cloud.rotation[0].coeffs(), Eigen::Vector4f(0, 0, -1, 0));  // x y z w
      EXPECT_EQ(cloud.opacity[0], 0.5f);
      EXPECT_EQ(cloud.degree, 2);
      ASSERT_EQ(cloud.harmonics.size(), 27u);
      EXPECT_EQ(cloud.harmonics[0], 0.25f);
      EXPECT_EQ(cloud.harmonics[2], -0.75f);
      // The file has them channel by channel: eight of red, eight of green, eight of blue.
      for (std::size_t k = 0; k < 8; ++k)
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_EQ(cloud.harmonics[3 * (k + 1) + c], static_cast<float>(8 * c + k) / 64.0f);
      EXPECT_FALSE(cloud.flat);
      EXPECT_EQ(cloud.filter, SplatFilter::dilated);
      EXPECT_EQ(cloud.colors, SplatColors::srgb);
      EXPECT_TRUE(cloud.velocity.empty());
      EXPECT_TRUE(file.report.unread.empty());
      EXPECT_EQ(file.report.points, 1u);
    }
  }
}

TEST_F(SplatPlyTest, QuaternionsAreReadAsWXYZ) {
  Fields fields;
  fields.set("rot_0", 4.0);
  fields.set("rot_1", 2.0);
  fields.set("rot_2", -2.0);
  fields.set("rot_3", 1.0);
  const LoadedSplats file = loaded(fields.bytes());
  ASSERT_EQ(file.splats.size(), 1u);
  EXPECT_EQ(file.splats.rotation[0].coeffs(), Eigen::Vector4f(0.4f, -0.4f, 0.2f, 0.8f));
}

TEST_F(SplatPlyTest, DegreeComesFromTheNumberOfHarmonics) {
  for (const auto& [rest, degree] : {std::pair{0u, 0}, {9u, 1}, {24u, 2}, {45u, 3}})
    EXPECT_EQ(loaded(Fields(rest).bytes()).splats.degree, degree);
  for (const std::size_t rest : {1u, 8u, 10u, 44u, 46u, 72u}) {
    const Result<LoadedSplats> file = read(Fields(rest).bytes());
    ASSERT_FALSE(file.ok()) << rest;
    EXPECT_EQ(file.error().field, "f_rest_0");
    EXPECT_NE(file.error().reason.find(std::to_string(rest) + " such"), std::string::npos);
  }
  Fields gap(9);
  for (std::string& name : gap.names)
    if (name == "f_rest_4") name = "f_rest_9";
  EXPECT_EQ(read(gap.bytes()).error().field, "f_rest_4");
}

TEST_F(SplatPlyTest, InfiniteOpacitiesAreOpaqueOrNothing) {
  Fields fields;
  fields.set("opacity", INFINITY);
  EXPECT_EQ(loaded(fields.bytes()).splats.opacity[0], 1.0f);
  fields.set("opacity", -INFINITY);
  EXPECT_EQ(loaded(fields.bytes()).splats.opacity[0], 0.0f);
  fields.set("opacity", -1000.0);
  EXPECT_EQ(loaded(fields.bytes()).splats.opacity[0], 0.0f);
}

TEST_F(SplatPlyTest, WithoutTheThirdScaleTheyAreFlat) {
  Fields fields;
  fields.drop("scale_2");
  const LoadedSplats file = loaded(fields.bytes());
  ASSERT_EQ(file.splats.size(), 1u);
  EXPECT_TRUE(file.splats.flat);
  EXPECT_EQ(file.splats.scale[0].z(), 0.0f);
  EXPECT_FLOAT_EQ(file.splats.scale[0].x(), std::exp(-1.0f));
}

TEST_F(SplatPlyTest, WhatIsMissingIsAssumedAndTold) {
  Fields fields;
  for (const char* name : {"opacity", "f_dc_0", "f_dc_1", "f_dc_2"}) fields.drop(name);
  const LoadedSplats grey = loaded(fields.bytes());
  ASSERT_EQ(grey.splats.size(), 1u);
  EXPECT_EQ(grey.splats.opacity[0], 1.0f);
  EXPECT_EQ(grey.splats.harmonics, (std::vector<float>{0, 0, 0}));
  EXPECT_EQ(grey.report.assumed.size(), 3u);
  fields.add("red", 1.0);
  fields.add("green", 0.5);
  fields.add("blue", 0.0);
  const LoadedSplats colored = loaded(fields.bytes());
  ASSERT_EQ(colored.splats.size(), 1u);
  EXPECT_FLOAT_EQ(colored.splats.harmonics[0], 0.5f / 0.28209479f);
  EXPECT_EQ(colored.splats.harmonics[1], 0.0f);
  EXPECT_EQ(colored.report.assumed.size(), 2u);
}

TEST_F(SplatPlyTest, MoreFieldsAndElementsAreReported) {
  Fields fields;
  fields.add("nx", 0.0);
  fields.add("segment", 7.0);
  fields.add("vx", 0.5);
  fields.add("vy", -1.0);
  fields.add("vz", 2.0);
  std::string bytes = fields.bytes("ascii");
  const std::string before = "element vertex";
  bytes.insert(bytes.find(before), "element camera 2\nproperty list uchar int view\nproperty int id\n");
  bytes.insert(bytes.find("end_header\n") + 11, "2 5 6 1\n0 2\n");
  const LoadedSplats file = loaded(bytes);
  ASSERT_EQ(file.splats.size(), 1u);
  EXPECT_EQ(file.splats.position[0], Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(file.splats.velocity.size(), 1u);
  EXPECT_EQ(file.splats.velocity[0], Eigen::Vector3f(0.5f, -1.0f, 2.0f));
  EXPECT_EQ(file.report.unread, (std::vector<std::string>{"nx", "segment", "camera.view", "camera.id"}));
}

TEST_F(SplatPlyTest, CommentsSayWhetherTrainingWasAntialiased) {
  const auto filter = [&](const std::string& comment) {
    std::string bytes = Fields().bytes();
    bytes.insert(bytes.find("element"), comment + "\n");
    return loaded(bytes).splats.filter;
  };
  for (const char* yes : {"comment SplatRenderMode: mip", "comment antialiased 1",
                          "comment antialiased: true", "comment  Antialiased=1"})
    EXPECT_EQ(filter(yes), SplatFilter::antialiased) << yes;
  for (const char* no : {"comment SplatRenderMode: default", "comment antialiased 0", "comment",
                         "comment trained without antialiased 1"})
    EXPECT_EQ(filter(no), SplatFilter::dilated) << no;
}

TEST_F(SplatPlyTest, EveryFaultNamesFieldAndSplat) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect = [&](const char* field, double value, const std::string& reason) {
    Fields fields(9);
    const std::vector<double> good = fields.values;
    fields.set(field, value);
    const std::string bytes = float_ply("binary_big_endian", fields.names, {good, fields.values});
    const Result<LoadedSplats> file = read(bytes);
    ASSERT_FALSE(file.ok()) << field;
    EXPECT_EQ(file.error().field, field);
    EXPECT_EQ(file.error().reason.find("splat 1 "), 0u) << file.error().reason;
    EXPECT_NE(file.error().reason.find(reason), std::string::npos) << file.error().reason;
    const Result<LoadedSplats> kept = read(bytes, true);
    ASSERT_TRUE(kept.ok()) << kept.error().message();
    EXPECT_EQ(kept->splats.size(), 1u);
    EXPECT_TRUE(kept->splats.validate().ok());
    EXPECT_EQ(kept->report.dropped, 1u);
    EXPECT_EQ(kept->notes.size(), 1u);
  };
  expect("y", nan, "is nan");
  expect("z", -INFINITY, "is -inf");
  expect("opacity", nan, "is nan");
  expect("scale_1", 89.0, "beyond the range of float");
  expect("scale_2", nan, "standard deviation of nan");
  expect("rot_2", INFINITY, "is inf");
  expect("f_dc_1", nan, "is nan");
  expect("f_rest_7", nan, "is nan");
}

TEST_F(SplatPlyTest, QuaternionsOfNoLengthAreRefused) {
  Fields fields;
  fields.set("rot_3", 0.0);
  const Result<LoadedSplats> file = read(fields.bytes());
  ASSERT_FALSE(file.ok());
  EXPECT_EQ(file.error().field, "rot_0");
  EXPECT_EQ(file.error().reason, "splat 0 starts a quaternion of length zero");
  EXPECT_EQ(read(fields.bytes(), true).error().reason, "has no splat with finite numbers");
}

TEST_F(SplatPlyTest, PointsAreNoSplats) {
  const std::string points = float_ply("ascii", {"x", "y", "z"}, {{1, 2, 3}});
  EXPECT_EQ(read(points).error().field, "scale_0");
  EXPECT_FALSE(holds_splats(write("points.ply", points)));
  EXPECT_TRUE(holds_splats(write("splats.ply", Fields(45).bytes())));
  EXPECT_FALSE(holds_splats(folder_ / "absent.ply"));
  EXPECT_FALSE(holds_splats(write("points.xyz", "1 2 3\n")));
  EXPECT_FALSE(is_splat_file_name("a.ply"));
  EXPECT_EQ(read_splats(folder_ / "points.xyz").error().file, folder_ / "points.xyz");
}

TEST_F(SplatPlyTest, EmptyAndUnknownKindsAreRefused) {
  const Fields fields;
  EXPECT_EQ(read(float_ply("ascii", fields.names, {})).error().reason, "has no splats");
  Fields alone;
  alone.add("trbf_center", 0.5);
  EXPECT_EQ(read(alone.bytes()).error().field, "trbf_center");
}

/// A splat of SpacetimeGaussians' lite model.
Fields moving() {
  Fields fields;
  fields.add("trbf_center", 0.5);
  fields.add("trbf_scale", std::log(0.25));
  for (int k = 0; k < 9; ++k) fields.add("motion_" + std::to_string(k), k + 1.0);
  for (int k = 0; k < 4; ++k) fields.add("omega_" + std::to_string(k), k == 0 ? 8.0 : 0.0);
  return fields;
}

TEST_F(SplatPlyTest, SplatsThatMoveByThemselves) {
  SplatReadOptions options;
  options.motion = true;
  const auto read_moving = [&](const Fields& fields) {
    return read_splats(write("moving.ply", fields.bytes()), options);
  };
  const Result<LoadedSplats> file = read_moving(moving());
  ASSERT_TRUE(file.ok()) << file.error().message();
  ASSERT_TRUE(file->motion.has_value());
  ASSERT_TRUE(file->motion->validate(1).ok());
  EXPECT_TRUE(file->report.unread.empty());
  // f_dc are the colours themselves.
  EXPECT_FLOAT_EQ(file->splats.harmonics[0], -0.25f / 0.28209479f);
  const SplatCloud rest = splats_at(file->splats, *file->motion, 0.5);
  EXPECT_EQ(rest.position[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(rest.opacity[0], 0.5f);
  const SplatCloud later = splats_at(file->splats, *file->motion, 0.75);
  EXPECT_TRUE(later.validate().ok());
  const double t = 0.25;
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(later.position[0][k], k + 1.0 + t * (k + 1.0) + t * t * (k + 4.0) + t * t * t * (k + 7.0),
                1e-12);
  EXPECT_FLOAT_EQ(later.opacity[0], 0.5f * std::exp(-1.0f));
  // (0, 0, 0, −2) + ¼ (8, 0, 0, 0) is (2, 0, 0, −2).
  EXPECT_LT((later.rotation[0].coeffs() - Eigen::Vector4f(0, 0, -std::sqrt(0.5f), std::sqrt(0.5f))).norm(),
            1e-6f);

  EXPECT_EQ(read(moving().bytes()).error().field, "trbf_center");
  Fields fields = moving();
  fields.drop("motion_4");
  EXPECT_EQ(read_moving(fields).error().field, "motion_4");
  fields = moving();
  fields.add("f_dc_3", 0.0);
  EXPECT_EQ(read_moving(fields).error().field, "f_dc_3");
  fields = moving();
  fields.set("omega_2", NAN);
  EXPECT_EQ(read_moving(fields).error().field, "omega_2");
  fields = moving();
  fields.set("trbf_scale", -200.0);
  EXPECT_EQ(read_moving(fields).error().field, "trbf_scale");
  options.skip_invalid = true;
  EXPECT_EQ(read_moving(fields).error().reason, "has no splat with finite numbers");
}

TEST_F(SplatPlyTest, EveryTruncationIsRefused) {
  for (const std::string& format : kPlyFormats) {
    Fields fields(9);  // the last number has one digit: a longer one could be cut and be a number still
    std::reverse(fields.names.begin(), fields.names.end());
    std::reverse(fields.values.begin(), fields.values.end());
    const std::string bytes = fields.bytes(format);
    // The last blank and line end of a text may be missing.
    const std::size_t whole = bytes.size() - (format == "ascii" ? 2 : 0);
    for (std::size_t size = 0; size < whole; ++size) {
      const Result<LoadedSplats> file = io::read_splat_ply("cut.ply", bytes.substr(0, size), {});
      ASSERT_FALSE(file.ok()) << size;
      EXPECT_FALSE(file.error().reason.empty());
    }
  }
}

TEST_F(SplatPlyTest, TheTrainedSampleIsReadWhole) {
  SWEPT_DATA_OR_SKIP(data);
  const std::string path = data + "gaussians/try_it7000.ply";
  ASSERT_TRUE(holds_splats(path));
  const Result<LoadedSplats> file = read_splats(path);
  ASSERT_TRUE(file.ok()) << file.error().message();
  EXPECT_TRUE(file->splats.validate().ok());
  EXPECT_EQ(file->splats.size(), 9080u);
  EXPECT_EQ(file->splats.degree, 3);
  EXPECT_EQ(file->report.unread, (std::vector<std::string>{"nx", "ny", "nz"}));
}

}  // namespace
