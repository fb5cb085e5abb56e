// Text files: what their columns are taken for, with a header line and without, and that nothing is guessed
// silently.
#include "splat/io/point_file.h"
#include "tests/point_files.h"
#include "tests/point_reports.h"

namespace {

using namespace swept;
using Eigen::Vector3d;
using Eigen::Vector3f;
using swept_test::expect_all_named;
using swept_test::has_part;
using swept_test::joined;

using TextLayoutsTest = swept_test::PointFiles;
using Names = std::vector<std::string>;

/// sRGB 200 100 50 in linear light, to 6 digits.
const Vector3f kBrown(0.577580f, 0.127438f, 0.031896f);

struct Layout {
  const char* file;
  std::string text;  ///< two points, the first at 1 2 3
  Names columns;     ///< as the report names them
  Names attributes;  ///< beside the position
  Names unread;
};

std::vector<Layout> layouts() {
  const Names xyz{"x", "y", "z"}, rgb{"red", "green", "blue"};
  const auto with = [](Names names, const Names& more) {
    names.insert(names.end(), more.begin(), more.end());
    return names;
  };
  const Names xyzn = with(xyz, {"nx", "ny", "nz"}), xyzrgb = with(xyz, rgb);
  return {
      {"xyz.xyz", "1 2 3\n4 5 6\n", xyz, {}, {}},
      {"intensity.txt", "1 2 3 0.5\n4 5 6 1\n", with(xyz, {"intensity"}), {"intensity"}, {}},
      {"rgb.xyz", "1 2 3 200 100 50\n4 5 6 0 0 0\n", xyzrgb, {"color"}, {}},
      {"normals.xyz", "1 2 3 0 0 1\n4 5 6 0.6 0 -0.8\n", xyzn, {"normal"}, {}},
      {"named.xyzrgb", "1 2 3 0 0 1\n4 5 6 1 0 0\n", xyzrgb, {"color"}, {}},
      {"named.xyzn", "1 2 3 0 0 2\n4 5 6 3 0 0\n", xyzn, {"normal"}, {}},
      {"rgbi.txt",
       "1 2 3 200 100 50 0.5\n4 5 6 0 0 0 0.25\n",
       with(xyzrgb, {"intensity"}),
       {"color"},
       {"intensity"}},
      {"scan.pts",
       "2\n1 2 3 -612 200 100 50\n4 5 6 10 0 0 0\n",
       with(with(xyz, {"intensity"}), rgb),
       {"color"},
       {"intensity"}},
      {"nrgb.txt", "1 2 3 0 0 1 200 100 50\n4 5 6 0 1 0 9 9 9\n", with(xyzn, rgb), {"normal", "color"}, {}},
      {"rgbn.txt",
       "1 2 3 200 100 50 0 0 1\n4 5 6 9 9 9 0 1 0\n",
       with(xyzrgb, {"nx", "ny", "nz"}),
       {"normal", "color"},
       {}},
      {"cloudcompare.txt",
       "//X Y Z R G B Nx Ny Nz Dip\n2\n1 2 3 200 100 50 0 0 1 45\n4 5 6 9 9 9 0 1 0 45\n",
       {"X", "Y", "Z", "R", "G", "B", "Nx", "Ny", "Nz", "Dip"},
       {"normal", "color"},
       {"Dip"}},
      {"comment.asc",
       "# made today\n# x y z vx vy vz\n1 2 3 7 8 9\n4 5 6 7 8 9\n",
       {"x", "y", "z", "vx", "vy", "vz"},
       {"velocity"},
       {}},
      {"table.csv",
       "\"X\",\"Y\",\"Z\",\"Intensity\",\"Class\"\n1,2,3,0.5,7\n4,5,6,1,7\n",
       {"X", "Y", "Z", "Intensity", "Class"},
       {"intensity"},
       {"Class"}},
      {"semicolons.csv", "x;y;z;radius\n1;2;3;0.5\n4;5;6;0.5\n", {"x", "y", "z", "radius"}, {"radius"}, {}},
      {"tabs.txt", "id\tx\ty\tz\r\n8\t1\t2\t3\r\n9\t4\t5\t6\r\n", {"id", "x", "y", "z"}, {"id"}, {}},
      {"survey.txt",
       "Easting,Northing,Height,Code\n1,2,3,7\n4,5,6,7\n",
       {"Easting", "Northing", "Height", "Code"},
       {},
       {"Code"}},
      {"mark.csv", "\xef\xbb\xbfx,y,z\n1,2,3\n4,5,6\n", xyz, {}, {}},
      {"units.txt", "x [m] y [m] z [m]\n1 2 3\n", {}, {}, {}},
  };
}

TEST_F(TextLayoutsTest, EachIsReadOrRefusedAndEveryColumnIsNamed) {
  ASSERT_GE(layouts().size(), 8u);
  for (const Layout& layout : layouts()) {
    SCOPED_TRACE(layout.file);
    const Result<PointSet> set = read_points(write(layout.file, layout.text));
    if (layout.columns.empty()) {
      ASSERT_FALSE(set.ok());
      continue;
    }
    ASSERT_TRUE(set.ok()) << set.error().message();
    ASSERT_EQ(set->size(), 2u);
    EXPECT_EQ(set->position[0], Vector3d(1, 2, 3));
    EXPECT_EQ(set->position[1], Vector3d(4, 5, 6));
    expect_all_named(set->report, layout.columns);
    EXPECT_EQ(set->report.unread, layout.unread);
    for (const std::string& attribute : layout.attributes)
      EXPECT_FALSE(set->report.properties_of(attribute).empty()) << attribute;
    EXPECT_EQ(set->report.used.size(), 1 + layout.attributes.size());
    if (layout.text.find("200") != std::string::npos) {
      EXPECT_LT((set->color[0] - kBrown).norm(), 1e-5f);
    }
  }
}

TEST_F(TextLayoutsTest, WhatWasGuessedIsSaid) {
  const auto said = [&](const char* name, const char* text, const char* part) {
    const Result<PointSet> set = read_points(write(name, text));
    ASSERT_TRUE(set.ok()) << set.error().message();
    EXPECT_TRUE(has_part(set->report.assumed, part)) << joined(set->report.assumed);
  };
  said("a.xyz", "1 2 3 200 100 50\n", "columns 4 to 6 are colours");
  said("a.xyz", "1 2 3 200 100 50\n", "colours from 0 to 255, sRGB");
  said("b.xyz", "1 2 3 0 0 1\n", "columns 4 to 6 are normals");
  said("z.xyz", "1 2 3 0 0 0\n4 5 6 0 0 0\n", "all are zero");
  said("c.xyz", "1 2 3 17\n", "column 4 is an intensity");
  said("c.xyz", "1 2 3 17\n", "intensities from 0 to 255, sRGB");
  said("d.xyz", "# x y z time\n1 2 3\n", "4 names for 3 columns");
}

TEST_F(TextLayoutsTest, WhatFitsNothingOrTwoThingsIsAnError) {
  const auto refused = [&](const char* name, const char* text, const char* field, const char* part) {
    const Result<PointSet> set = read_points(write(name, text));
    ASSERT_FALSE(set.ok()) << text;
    EXPECT_EQ(set.error().field, field);
    EXPECT_NE(set.error().reason.find(part), std::string::npos) << set.error().reason;
  };
  refused("a.xyz", "1 2 3 -4 5 6\n", "columns 4 to 6", "\"color\": \"4,5,6\"");
  refused("b.xyz", "1 2 3 10 20 30 40\n", "columns 4 to 7", "either order");
  refused("b.xyz", "1 2 3 0.1 0.2 0.3 0.4\n", "columns 4 to 7", "not colours");
  refused("c.xyz", "1 2 3 4 5 6 7 8 9\n", "columns 4 to 9", "unit vector");
  refused("d.xyz", "1 2 3 4 5\n", "line 1", "5 numbers");
  refused("e.csv", "x,y,z\n1,2,3,4\n", "line 1", "3 names for 4 columns");
  refused("f.csv", "a,b,c\n1,2,3\n", "x", "it has a, b, c");
  refused("g.pts", "3\n1 2 3\n4 5 6\n", "header", "says it has 3, and has 2");
  refused("h.txt", "1,5;2,5;3,5\n", "line 1", "decimal points");
  refused("h.txt", "1,5 2,5 3,5\n", "line 1", "decimal points");
  refused("i.csv", "x,y,z\nv,w,u\n", "line 2, x", "'v' is not a number");
  ReadOptions named;
  named.attributes = {{"position", "a,b,c"}};
  EXPECT_TRUE(read_points(folder_ / "f.csv", named).ok());
  named.attributes = {{"position", "3,2,1"}};
  EXPECT_EQ(read_points(folder_ / "f.csv", named)->position[0], Vector3d(3, 2, 1));
}

TEST_F(TextLayoutsTest, LeavingAnAttributeOutDoesNotUnnameTheRest) {
  // Sequences leave velocities out, and text files lost their normals over it.
  ReadOptions options;
  options.attributes = {{"velocity", ""}};
  const Result<PointSet> set = read_points(write("a.xyz", "1 2 3 0 0 1\n"), options);
  ASSERT_TRUE(set.ok());
  EXPECT_EQ(set->normal[0], Vector3f(0, 0, 1));
}

TEST_F(TextLayoutsTest, NumbersBeyondDoubleAreInfiniteOrZeroByTheirSize) {
  const std::string zeros(800, '0');
  const auto x = [&](const std::string& number) {
    ReadOptions options;
    const Result<PointSet> set = read_points(write("n.xyz", number + " 0 0\n"), options);
    return set.ok() ? set->position[0].x() : INFINITY;
  };
  EXPECT_EQ(x("1" + zeros + "e-400"), INFINITY);
  EXPECT_EQ(x("-1" + zeros + "e-400"), INFINITY);  // refused alike
  EXPECT_EQ(x("1" + zeros + "e-800"), 1.0);
  EXPECT_EQ(x("0." + zeros + "1"), 0.0);
  EXPECT_EQ(x("0." + zeros + "1e+1201"), INFINITY);
  EXPECT_EQ(x("1e-99999999999999999999"), 0.0);
  EXPECT_EQ(x("1e+99999999999999999999"), INFINITY);
}

}  // namespace
