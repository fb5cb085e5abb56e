// What stored colours stand for: by their type, by their numbers, and as a caller says.
#include <cmath>
#include <limits>

#include "splat/io/point_file.h"
#include "tests/point_files.h"
#include "tests/point_reports.h"

namespace {

using namespace swept;
using Eigen::Vector3f;
using swept_test::has_part;
using swept_test::joined;
using swept_test::PlyBody;

using ColorRangeTest = swept_test::PointFiles;

/// sRGB 200 100 50 of 255 in linear light, to 6 digits.
const Vector3f kBrown(0.577580f, 0.127438f, 0.031896f);

/// Points with colours of a type.
std::string colored(const std::string& type, const std::vector<std::vector<double>>& colors) {
  std::string header = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(colors.size()) + "\n";
  for (const char* axis : {"x", "y", "z"}) header += std::string("property float ") + axis + "\n";
  for (const char* channel : {"red", "green", "blue", "alpha"}) {
    if (colors[0].size() == 3 && channel[0] == 'a') continue;
    header += "property " + type + " " + channel + "\n";
  }
  PlyBody body("ascii");
  for (const auto& color : colors) {
    body.put("float", 1).put("float", 2).put("float", 3);
    for (const double value : color) body.put(type, value);
    body.end_row();
  }
  return header + "end_header\n" + body.bytes();
}

struct Case {
  const char* type;
  std::vector<std::vector<double>> colors;
  Vector3f first;    ///< linear
  const char* said;  ///< in the report
};

TEST_F(ColorRangeTest, TypesAndNumbersDecide) {
  const double full = 65535.0;
  for (const Case& c : std::vector<Case>{
           {"uchar", {{200, 100, 50}}, kBrown, "from 0 to 255, sRGB"},
           {"uchar", {{1, 0, 1}}, Vector3f(3.03527e-4f, 0, 3.03527e-4f), "from 0 to 255, sRGB"},
           {"float", {{200, 100, 50}}, kBrown, "from 0 to 255, sRGB: most"},
           {"double", {{200, 100, 50}, {0, 0, 0}, {12.5, 0, 0}}, kBrown, "from 0 to 255, sRGB: most"},
           {"ushort", {{200, 100, 50}}, kBrown, "from 0 to 255, sRGB: no number exceeds 255"},
           {"short", {{200, 100, 50}}, kBrown, "from 0 to 255, sRGB: no number exceeds 255"},
           {"ushort", {{200 * 257, 100 * 257, 50 * 257}}, kBrown, "from 0 to 65535, sRGB"},
           {"ushort", {{full, 0, full}, {3, 2, 1}}, Vector3f(1, 0, 1), "from 0 to 65535, sRGB"},
           {"int", {{200, 100, 50}}, kBrown, "from 0 to 255, sRGB"},
           {"uint", {{200 * 257, 100 * 257, 50 * 257}}, kBrown, "from 0 to 65535, sRGB: numbers exceed"},
           {"float", {{200 * 257, 100 * 257, 50 * 257}}, kBrown, "from 0 to 65535, sRGB: whole"},
           {"float", {{0.25, 0.5, 1}}, Vector3f(0.25f, 0.5f, 1), "from 0 to 1, linear"},
           {"float", {{0, 0, 0}}, Vector3f(0, 0, 0), "from 0 to 1, linear"},
           // Light brighter than 1 stays what it is, and is told.
           {"float", {{0.25, 2, 0}, {0.5, 0.5, 0.5}}, Vector3f(0.25f, 2, 0), "brighter than 1"},
           {"float", {{1e4, 1e5, 0.5}}, Vector3f(1e4f, 1e5f, 0.5f), "brighter than 1"},
       }) {
    SCOPED_TRACE(std::string(c.type) + " " + c.said);
    const Result<PointSet> set = read_points(write("c.ply", colored(c.type, c.colors)));
    ASSERT_TRUE(set.ok()) << set.error().message();
    EXPECT_LE((set->color[0] - c.first).norm(), 2e-6f * (1.0f + c.first.norm())) << set->color[0].transpose();
    EXPECT_TRUE(has_part(set->report.assumed, c.said)) << joined(set->report.assumed);
  }
}

TEST_F(ColorRangeTest, ACallerSaysItBetter) {
  const std::string path = write("c.ply", colored("float", {{200, 100, 50}}));
  ReadOptions options;
  options.color_range = 1.0;
  EXPECT_EQ(read_points(path, options)->color[0], Vector3f(200, 100, 50));
  options.color_range = 200.0;
  options.color_space = ColorSpace::linear;
  EXPECT_EQ(read_points(path, options)->color[0], Vector3f(1, 0.5f, 0.25f));
  EXPECT_TRUE(has_part(read_points(path, options)->report.assumed, "from 0 to 200, linear, as stated"));
  // Linear bytes, as a Cd in 8 bits.
  const std::string bytes = write("b.ply", colored("uchar", {{255, 51, 0}}));
  options = {};
  options.color_space = ColorSpace::linear;
  EXPECT_EQ(read_points(bytes, options)->color[0], Vector3f(1, 0.2f, 0));
  // Encoded reals.
  options.color_space = ColorSpace::srgb;
  const Result<PointSet> encoded = read_points(write("e.ply", colored("float", {{0.5, 1, 0}})), options);
  EXPECT_NEAR(encoded->color[0].x(), 0.2140411, 5e-8);
  for (const double wrong : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    options.color_range = wrong;
    const Result<PointSet> refused = read_points(path, options);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().field, "color_range");
  }
  options.color_range = 1e-38;  // what no float could hold
  EXPECT_FALSE(read_points(path, options).ok());
}

TEST_F(ColorRangeTest, AlphaFollowsTheColours) {
  const auto opacity = [&](const std::string& type, const std::vector<std::vector<double>>& colors) {
    const Result<PointSet> set = read_points(write("a.ply", colored(type, colors)));
    return set.ok() ? set->opacity[0] : -1.0f;
  };
  EXPECT_FLOAT_EQ(opacity("uchar", {{1, 2, 3, 51}}), 0.2f);
  EXPECT_FLOAT_EQ(opacity("ushort", {{1, 2, 3, 51}}), 0.2f);
  EXPECT_FLOAT_EQ(opacity("ushort", {{1000, 2, 3, 13107}}), 0.2f);
  EXPECT_FLOAT_EQ(opacity("float", {{200, 100, 50, 51}}), 0.2f);
  EXPECT_FLOAT_EQ(opacity("float", {{200, 100, 50, 0.2}}), 0.2f);
  EXPECT_FLOAT_EQ(opacity("float", {{0.5, 0.5, 0.5, 0.2}}), 0.2f);
  EXPECT_EQ(opacity("float", {{0.5, 0.5, 0.5, 51}}), -1.0f);  // out of range
}

TEST_F(ColorRangeTest, IntensitiesFindTheirRange) {
  const auto grey = [&](const char* rows) {
    const Result<PointSet> set = read_points(write("i.txt", rows));
    return set.ok() && !set->color.empty() ? set->color[0].x() : -1.0f;
  };
  const float half = 0.2140411f;  // sRGB 0.5
  EXPECT_NEAR(grey("1 2 3 0.5\n4 5 6 0.25\n"), half, 1e-6);
  EXPECT_NEAR(grey("1 2 3 127.5\n4 5 6 255\n"), half, 1e-6);
  EXPECT_NEAR(grey("1 2 3 511.5\n4 5 6 1000\n"), half, 1e-6);
  EXPECT_NEAR(grey("1 2 3 2047.5\n4 5 6 4000\n"), half, 1e-6);
  EXPECT_NEAR(grey("1 2 3 32767.5\n4 5 6 60000\n"), half, 1e-6);
  EXPECT_NEAR(grey("1 2 3 500000\n4 5 6 1000000\n"), half, 1e-6);
  EXPECT_NEAR(grey("1 2 3 -0.5\n4 5 6 1000\n"), half, 1e-6);  // PTS, from −2048
  EXPECT_EQ(grey("1 2 3 nan\n4 5 6 1000\n"), 0.0f);
  EXPECT_EQ(grey("1 2 3 -5000\n4 5 6 1000\n"), -1.0f);
  EXPECT_TRUE(has_part(read_points(folder_ / "i.txt")->report.assumed, "intensities are not used"));
}

}  // namespace
