// The names that attributes go by, in every format that has names; and that what has none of them is named
// too.
#include "splat/io/attribute_names.h"

#include <algorithm>

#include "splat/io/point_file.h"
#include "tests/point_files.h"
#include "tests/point_reports.h"

namespace {

using namespace swept;
using Eigen::Vector3d;
using Eigen::Vector3f;
using swept_test::expect_all_named;
using swept_test::float_ply;
using swept_test::has_part;
using swept_test::joined;
using swept_test::PlyBody;

using Names = std::vector<std::string>;

const std::vector<Names> kVelocities{{"vx", "vy", "vz"},
                                     {"v_x", "v_y", "v_z"},
                                     {"Vx", "Vy", "Vz"},
                                     {"VX", "VY", "VZ"},
                                     {"v[0]", "v[1]", "v[2]"},
                                     {"v.x", "v.y", "v.z"},
                                     {"velocity_x", "velocity_y", "velocity_z"},
                                     {"velocityX", "velocityY", "velocityZ"},
                                     {"Velocity_X", "Velocity_Y", "Velocity_Z"},
                                     {"velocity_0", "velocity_1", "velocity_2"},
                                     {"velocities_x", "velocities_y", "velocities_z"},
                                     {"vel_x", "vel_y", "vel_z"},
                                     {"velX", "velY", "velZ"},
                                     {"dx", "dy", "dz"},
                                     {"scalar_vx", "scalar_vy", "scalar_vz"},
                                     {"scalar_Velocity_X", "scalar_Velocity_Y", "scalar_Velocity_Z"}};

const std::vector<Names> kColors{{"red", "green", "blue"},
                                 {"r", "g", "b"},
                                 {"R", "G", "B"},
                                 {"Red", "Green", "Blue"},
                                 {"diffuse_red", "diffuse_green", "diffuse_blue"},
                                 {"Cd_r", "Cd_g", "Cd_b"},
                                 {"Cd[0]", "Cd[1]", "Cd[2]"},
                                 {"Cdx", "Cdy", "Cdz"},
                                 {"color_r", "color_g", "color_b"},
                                 {"colour_red", "colour_green", "colour_blue"},
                                 {"scalar_R", "scalar_G", "scalar_B"}};

struct Radius {
  const char* name;
  float radius;  ///< of a stored 0.5
};
const std::vector<Radius> kRadii{{"radius", 0.5f},        {"Radius", 0.5f}, {"pscale", 0.5f},
                                 {"scalar_radius", 0.5f}, {"width", 0.25f}, {"widths", 0.25f},
                                 {"Widths", 0.25f},       {"size", 0.25f},  {"diameter", 0.25f}};

const std::vector<const char*> kGreys{
    "intensity", "Intensity", "scalar_Intensity", "reflectivity", "scalar_Reflectance", "reflectance",
    "grey",      "i"};

/// The columns as a PLY, a PCD and two text files, one point.
std::vector<std::pair<std::string, std::string>> files_of(const Names& names,
                                                          const std::vector<double>& row) {
  std::string fields, sizes, types, numbers;
  for (std::size_t c = 0; c < names.size(); ++c) {
    fields += " " + names[c];
    sizes += " 4";
    types += " F";
    numbers += (c == 0 ? "" : " ") + std::to_string(row[c]);
  }
  std::string commas = fields.substr(1);
  std::replace(commas.begin(), commas.end(), ' ', ',');
  return {{"n.ply", float_ply("binary_little_endian", names, {row})},
          {"n.pcd", "FIELDS" + fields + "\nSIZE" + sizes + "\nTYPE" + types + "\nPOINTS 1\nDATA ascii\n" +
                        numbers + "\n"},
          {"n.txt", "//" + fields.substr(1) + "\n" + numbers + "\n"},
          {"n.csv", commas + "\n" + numbers + "\n"}};
}

Names with_positions(const Names& names) {
  Names all{"x", "y", "z"};
  all.insert(all.end(), names.begin(), names.end());
  all.push_back("confidence");
  return all;
}

class AttributeNamesTest : public swept_test::PointFiles {
 protected:
  /// Reads one point that has these columns in each format, and checks that each column is named.
  template <class Check>
  void in_every_format(const Names& names, const std::vector<double>& values, const Check& check) const {
    const Names all = with_positions(names);
    std::vector<double> row{1, 2, 3};
    row.insert(row.end(), values.begin(), values.end());
    row.push_back(9);
    for (const auto& [file, bytes] : files_of(all, row)) {
      SCOPED_TRACE(file + ": " + names[0]);
      const Result<PointSet> set = read_points(write(file, bytes));
      ASSERT_TRUE(set.ok()) << set.error().message();
      EXPECT_EQ(set->position[0], Vector3d(1, 2, 3));
      expect_all_named(set->report, all);
      EXPECT_EQ(set->report.unread, Names{"confidence"});
      check(*set);
    }
  }
};

TEST_F(AttributeNamesTest, SixteenSpellingsOfVelocity) {
  ASSERT_GE(kVelocities.size(), 12u);
  for (const Names& names : kVelocities) {
    in_every_format(names, {4, 5, 6}, [&](const PointSet& set) {
      ASSERT_EQ(set.velocity.size(), 1u);
      EXPECT_EQ(set.velocity[0], Vector3f(4, 5, 6));
      EXPECT_EQ(set.report.properties_of("velocity"), names);
    });
  }
}

TEST_F(AttributeNamesTest, ElevenSpellingsOfColour) {
  ASSERT_GE(kColors.size(), 6u);
  for (const Names& names : kColors) {
    in_every_format(names, {0.25, 0.5, 1}, [&](const PointSet& set) {
      ASSERT_EQ(set.color.size(), 1u);
      EXPECT_EQ(set.color[0], Vector3f(0.25f, 0.5f, 1));
      EXPECT_TRUE(set.normal.empty());
      EXPECT_EQ(set.report.properties_of("color"), names);
    });
  }
}

TEST_F(AttributeNamesTest, NineSpellingsOfRadius) {
  ASSERT_GE(kRadii.size(), 4u);
  for (const Radius& radius : kRadii) {
    in_every_format({radius.name}, {0.5}, [&](const PointSet& set) {
      EXPECT_EQ(set.radius, std::vector<float>{radius.radius});
      EXPECT_EQ(set.report.properties_of(radius.radius == 0.5f ? "radius" : "width"), Names{radius.name});
    });
  }
}

TEST_F(AttributeNamesTest, IntensitiesAreGreys) {
  for (const char* name : kGreys) {
    in_every_format({name}, {1.0}, [&](const PointSet& set) {
      ASSERT_EQ(set.color.size(), 1u);
      EXPECT_EQ(set.color[0], Vector3f(1, 1, 1));
      EXPECT_TRUE(has_part(set.report.assumed, "shown as grey")) << joined(set.report.assumed);
    });
  }
}

TEST_F(AttributeNamesTest, HoudinisPoints) {
  const Names names{"P[0]",   "P[1]", "P[2]",  "N[0]",  "N[1]",     "N[2]",     "v[0]",
                    "v[1]",   "v[2]", "Cd[0]", "Cd[1]", "Cd[2]",    "Alpha",    "id",
                    "pscale", "w[0]", "w[1]",  "w[2]",  "accel[0]", "accel[1]", "accel[2]"};
  std::vector<double> row;
  for (const double value : {1, 2, 3, 0, 0, 1, 4, 5, 6}) row.push_back(value);
  for (const double value : {0.25, 0.5, 2.0, 0.75, 17.0, 0.1}) row.push_back(value);
  for (int i = 0; i < 6; ++i) row.push_back(7);
  const Result<PointSet> set = read_points(write("h.ply", float_ply("ascii", names, {row})));
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_EQ(set->position[0], Vector3d(1, 2, 3));
  EXPECT_EQ(set->normal[0], Vector3f(0, 0, 1));
  EXPECT_EQ(set->velocity[0], Vector3f(4, 5, 6));
  EXPECT_EQ(set->color[0], Vector3f(0.25f, 0.5f, 2));  // linear, and brighter than 1
  EXPECT_EQ(set->opacity[0], 0.75f);
  EXPECT_EQ(set->radius[0], 0.1f);
  EXPECT_EQ(set->id, std::vector<std::int64_t>{17});
  EXPECT_EQ(set->angular_velocity[0], Vector3f(7, 7, 7));
  EXPECT_EQ(set->acceleration[0], Vector3f(7, 7, 7));
  EXPECT_EQ(set->report.unread, Names{});
  expect_all_named(set->report, names);
}

TEST_F(AttributeNamesTest, VectorsAsListsOfPly) {
  for (const std::string& format : swept_test::kPlyFormats) {
    std::string header = "ply\nformat " + format + " 1.0\nelement vertex 2\nproperty list uchar float P\n";
    header += "property list uchar float v\nproperty list uchar short weights\nproperty list int uchar Cd\n";
    header += "end_header\n";
    PlyBody body(format);
    for (int i = 0; i < 2; ++i) {
      body.put("uchar", 3).put("float", i).put("float", 2).put("float", 3);
      body.put("uchar", 3).put("float", 4).put("float", 5).put("float", 6 + i);
      body.put("uchar", i);
      for (int k = 0; k < i; ++k) body.put("short", 1);
      body.put("int", 3).put("uchar", 255).put("uchar", 0).put("uchar", 255).end_row();
    }
    const Result<PointSet> set = read_points(write("l.ply", header + body.bytes()));
    ASSERT_TRUE(set.ok()) << format << set.error().message();
    EXPECT_EQ(set->position[1], Vector3d(1, 2, 3));
    EXPECT_EQ(set->velocity[1], Vector3f(4, 5, 7));
    EXPECT_EQ(set->color[0], Vector3f(1, 0, 1));
    EXPECT_EQ(set->report.unread, Names{"weights"});
    ReadOptions options;
    options.attributes = {{"velocity", "P"}};
    EXPECT_EQ(read_points(folder_ / "l.ply", options)->velocity[1], Vector3f(1, 2, 3));
  }
  const std::string bytes =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property list uchar float velocity\nend_header\n1 2 3 2 5 6\n";
  const std::string path = write("two.ply", bytes);
  const Result<PointSet> two = read_points(path);
  ASSERT_FALSE(two.ok());
  EXPECT_EQ(two.error().field, "velocity");
  ReadOptions options;
  options.attributes = {{"velocity", ""}};
  EXPECT_TRUE(read_points(path, options).ok());
}

TEST_F(AttributeNamesTest, VectorsAsFieldsOfPcd) {
  const std::string header =
      "FIELDS x y z velocity weights Cd\nSIZE 4 4 4 4 4 1\nTYPE F F F F F U\nCOUNT 1 1 1 3 2 3\nPOINTS 1\n";
  PlyBody body("binary_little_endian");
  for (const double value : {1, 2, 3, 4, 5, 6, 8, 9}) body.put("float", value);
  for (int k = 0; k < 3; ++k) body.put("uchar", 255 * (k % 2));
  for (const std::string& data :
       {std::string("DATA ascii\n1 2 3 4 5 6 8 9 0 255 0\n"), "DATA binary\n" + body.bytes()}) {
    const Result<PointSet> set = read_points(write("v.pcd", header + data));
    ASSERT_TRUE(set.ok()) << set.error().message();
    EXPECT_EQ(set->velocity[0], Vector3f(4, 5, 6));
    EXPECT_EQ(set->color[0], Vector3f(0, 1, 0));
    EXPECT_EQ(set->report.unread, Names{"weights"});
  }
}

TEST_F(AttributeNamesTest, TheExactNameGoesBeforeOneThatFolds) {
  const Names names{"X", "x", "y", "z", "V_x", "vx", "vy", "vz"};
  const Result<PointSet> set =
      read_points(write("e.ply", float_ply("ascii", names, {{9, 1, 2, 3, 9, 4, 5, 6}})));
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_EQ(set->position[0], Vector3d(1, 2, 3));
  EXPECT_EQ(set->velocity[0], Vector3f(4, 5, 6));
  EXPECT_EQ(set->report.unread, (Names{"X", "V_x"}));
  ReadOptions options;
  options.attributes = {{"velocity", "V_X, VY, vz"}};
  EXPECT_EQ(read_points(folder_ / "e.ply", options)->velocity[0], Vector3f(9, 5, 6));
}

TEST_F(AttributeNamesTest, HalfAVelocityIsReportedAsUnread) {
  const Result<PointSet> set =
      read_points(write("h.ply", float_ply("ascii", {"x", "y", "z", "vx", "vy"}, {{1, 2, 3, 4, 5}})));
  ASSERT_TRUE(set.ok());
  EXPECT_TRUE(set->velocity.empty());
  EXPECT_EQ(set->report.unread, (Names{"vx", "vy"}));
}

TEST(AttributeNames, FoldingKeepsWhatTellsNamesApart) {
  EXPECT_EQ(folded("Velocity_X"), "velocityx");
  EXPECT_EQ(folded("scalar_Intensity"), "intensity");
  EXPECT_EQ(folded("x [m]"), "x");
  EXPECT_EQ(folded("X(m)"), "x");
  EXPECT_EQ(folded("v[0]"), "v0");
  EXPECT_EQ(folded("\"Coord. X\""), "coordx");
  EXPECT_EQ(folded(""), "");
  EXPECT_TRUE(is_vector_name("Cd"));
  EXPECT_TRUE(is_vector_name("velocities"));
  EXPECT_FALSE(is_vector_name("x"));
  EXPECT_FALSE(is_vector_name("weights"));
}

TEST(ReadReport, NumberedNamesAndLongListsAreShort) {
  EXPECT_EQ(listed({"a", "f_0", "f_1", "b"}), "a, f_0, f_1, b");
  EXPECT_EQ(listed({"f_0", "f_1", "f_2", "f_3", "b7"}), "f_0 to f_3, b7");
  EXPECT_EQ(listed({"bad\x01name"}), "bad?name");
  Names many;
  for (int i = 0; i < 100; ++i) many.emplace_back("n").append(std::to_string(2 * i)).append("x");
  EXPECT_NE(listed(many).find("and 76 more"), std::string::npos) << listed(many);
}

}  // namespace
