// OBJ and OFF as tools really write them, and PLY files of other kinds: read whole, or refused by name.
#include "splat/io/cloud_source.h"
#include "splat/io/surfel_estimate.h"
#include "tests/point_files.h"
#include "tests/point_reports.h"

namespace {

using namespace swept;
using Eigen::Vector3d;
using Eigen::Vector3f;
using swept_test::has_part;
using swept_test::joined;

using MeshFilesTest = swept_test::PointFiles;
using Names = std::vector<std::string>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// sRGB 200 100 50 of 255 in linear light, to 6 digits.
const Vector3f kBrown(0.577580f, 0.127438f, 0.031896f);

TEST_F(MeshFilesTest, ObjLinesGoOnAfterABackslash) {
  const Triangles square{{0, 1, 3}, {0, 3, 2}};
  for (const std::string end : {"\n", "\r\n"}) {
    const std::string text = "v 0 0 0" + end + "v 1 0 \\" + end + " 0" + end + "v 0 \\" + end + "\\" + end +
                             "1 0" + end + "v 1 1 0" + end + "f 1 2 \\" + end + " 4 3" + end;
    const Result<PointSet> set = read_points(write("c.obj", text));
    ASSERT_TRUE(set.ok()) << set.error().message();
    ASSERT_EQ(set->size(), 4u);
    EXPECT_EQ(set->position[1], Vector3d(1, 0, 0));
    EXPECT_EQ(set->position[2], Vector3d(0, 1, 0));
    EXPECT_EQ(set->triangle, square);
  }
  // Without blanks before the rest, and with nothing after the last.
  const Result<PointSet> joint = read_points(write("j.obj", "v 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nf 1 2 3\\"));
  ASSERT_TRUE(joint.ok()) << joint.error().message();
  EXPECT_EQ(joint->triangle, (Triangles{{0, 1, 2}}));
  // A keyword that is not read takes its continuation with it.
  const Result<PointSet> other = read_points(write("o.obj", "vp 0 0 \\\nv 9 9 9\nv 1 2 3\nv 2 2 3\n"));
  ASSERT_TRUE(other.ok());
  EXPECT_EQ(other->position[0], Vector3d(1, 2, 3));
}

TEST_F(MeshFilesTest, ObjVertexColours) {
  const auto colors = [&](const char* one, const char* two) {
    const Result<PointSet> set = read_points(
        write("c.obj", std::string("v 0 0 0") + one + "\nv 1 0 0" + two + "\nv 0 1 0" + one + "\nf 1 2 3\n"));
    EXPECT_TRUE(set.ok()) << set.error().message();
    return set.ok() ? *set : PointSet{};
  };
  EXPECT_EQ(colors(" 1 0.5 0.25", " 0 0 0").color[0], Vector3f(1, 0.5f, 0.25f));
  EXPECT_LT((colors(" 200 100 50", " 9 9 9").color[0] - kBrown).norm(), 1e-5f);
  EXPECT_FLOAT_EQ(colors(" 1 0.5 0.25 0.125", " 0 0 0 1").opacity[0], 0.125f);
  EXPECT_EQ(colors(" 1", " 1").report.unread, Names{"w of the vertices"});
  // Some vertices have colours, others none: said, not guessed.
  const PointSet mixed = colors(" 1 0 0", "");
  EXPECT_TRUE(mixed.color.empty());
  EXPECT_TRUE(has_part(mixed.report.unread, "not all vertices")) << joined(mixed.report.unread);
}

TEST_F(MeshFilesTest, ObjSaysWhichLinesItDidNotRead) {
  const Result<PointSet> set = read_points(
      write("u.obj",
            "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 1\nusemtl red\nf 1//1 2//1 3//2\n"));
  ASSERT_TRUE(set.ok());
  EXPECT_EQ(set->report.unread, (Names{"1 line mtllib", "1 line usemtl", "2 lines vn"}));
}

TEST_F(MeshFilesTest, ObjPointsWithoutFacesTakeTheirNormals) {
  const Result<PointSet> set =
      read_points(write("n.obj", "v 1 2 3 1 0 0\nvn 0 0 2\nv 4 5 6 0 1 0\nvn \\\n0 -3 0\np 1 2\n"));
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_EQ(set->normal, (std::vector<Vector3f>{{0, 0, 1}, {0, -1, 0}}));
  EXPECT_EQ(set->color[1], Vector3f(0, 1, 0));
  EXPECT_EQ(set->report.unread, Names{"1 line p"});
  EXPECT_TRUE(has_part(set->report.assumed, "vn for each v")) << joined(set->report.assumed);
  EXPECT_TRUE(read_points(write("f.obj", "v 1 2 3\nv 4 5 6\nvn 0 0 1\n"))->normal.empty());
  const Result<PointSet> bad = read_points(write("b.obj", "v 1 2 3\nvn 0 a 1\n"));
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().field, "line 2, vn");
}

TEST_F(MeshFilesTest, OffInItsSpellings) {
  const std::string square = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n";
  for (const char* head : {"OFF\n4 2 0\n", "OFF 4 2 0\n", "OFF4 2 0\n", "OFF # c\n\n4 2\n"}) {
    const Result<PointSet> set = read_points(write("s.off", head + square));
    ASSERT_TRUE(set.ok()) << head << set.error().message();
    EXPECT_EQ(set->size(), 4u);
    EXPECT_EQ(set->triangle, (Triangles{{0, 1, 2}, {1, 3, 2}}));
    EXPECT_TRUE(set->report.unread.empty()) << joined(set->report.unread);
  }
  for (const char* head : {"OFFX 4 2 0\n", "OF 4 2 0\n", "4OFF 4 2 0\n", "STOFF\n4 2 0\n", "4 2 0\n"})
    EXPECT_FALSE(read_points(write("n.off", head + square)).ok()) << head;
}

TEST_F(MeshFilesTest, OffColoursAndNormals) {
  const auto read = [&](const std::string& text) {
    const Result<PointSet> set = read_points(write("c.off", text));
    EXPECT_TRUE(set.ok()) << set.error().message();
    return set.ok() ? *set : PointSet{};
  };
  const PointSet ints = read("COFF\n2 0 0\n0 0 0 200 100 50 255\n1 0 0 200 100 50 51\n");
  EXPECT_LT((ints.color[1] - kBrown).norm(), 1e-5f);
  EXPECT_FLOAT_EQ(ints.opacity[1], 0.2f);
  const PointSet reals = read("COFF\n2 0 0\n0 0 0 1 0.5 0.25 1\n1 0 0 0 0 0 0.5\n");
  EXPECT_EQ(reals.color[0], Vector3f(1, 0.5f, 0.25f));
  EXPECT_EQ(reals.opacity[1], 0.5f);
  const PointSet both = read("CNOFF\n2 0 0\n0 0 0 0 0 2 200 100 50\n1 0 0 0 1 0 9 9 9\n");
  EXPECT_EQ(both.normal[0], Vector3f(0, 0, 1));
  EXPECT_LT((both.color[0] - kBrown).norm(), 1e-5f);
  EXPECT_EQ(read("NOFF\n1 0 0\n0 0 0 0 0 2\n").normal[0], Vector3f(0, 0, 1));
  // Colours that the header is silent about.
  const PointSet silent = read("OFF\n1 0 0\n0 0 0 200 100 50\n");
  EXPECT_LT((silent.color[0] - kBrown).norm(), 1e-5f);
  EXPECT_TRUE(has_part(silent.report.assumed, "does not say so")) << joined(silent.report.assumed);
  // What is not read is named.
  EXPECT_EQ(read("OFF\n1 0 0\n0 0 0 7\n").report.unread, Names{"number 4 of the vertices"});
  EXPECT_EQ(read("COFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\nmore\n").report.unread,
            (Names{"colours of 1 faces", "1 lines after the last face"}));
}

TEST_F(MeshFilesTest, LinesAfterTheLastPointOfAPcdAreTold) {
  const Result<PointSet> set = read_points(
      write("a.pcd",
            "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n"
            "0 0 0\n1 0 0\n\n2 0 0\n"));
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_EQ(set->report.unread, Names{"2 lines after the last point"});
}

TEST_F(MeshFilesTest, WhatStandsAfterTheLastElementOfAPlyIsTold) {
  const auto unread = [&](const std::string& format, const std::string& body) {
    const Result<PointSet> set = read_points(
        write("a.ply", "ply\nformat " + format +
                           " 1.0\nelement vertex 2\nproperty uchar x\nproperty uchar y\nproperty uchar z\n"
                           "end_header\n" +
                           body));
    EXPECT_TRUE(set.ok()) << set.error().message();
    return set.ok() ? set->report.unread : Names{};
  };
  EXPECT_EQ(unread("ascii", "0 0 0\n1 0 0 \n\n"), Names{});
  EXPECT_EQ(unread("ascii", "0 0 0\n1 0 0\n2 0 0"), Names{"6 bytes after the last element"});
  EXPECT_EQ(unread("binary_little_endian", "abcdef"), Names{});
  EXPECT_EQ(unread("binary_little_endian", "abcdefghi"), Names{"3 bytes after the last element"});
}

TEST_F(MeshFilesTest, ALooseVertexFacesAsItsNeighboursDo) {
  // A grid that faces −x or +x, and a vertex beside it: a plane fit has no side.
  for (const double side : {-1.0, 1.0}) {
    std::vector<Vector3d> points;
    Triangles triangles;
    constexpr std::uint32_t n = 7;
    for (std::uint32_t j = 0; j < n; ++j)
      for (std::uint32_t i = 0; i < n; ++i) points.emplace_back(0.0, i, j);
    for (std::uint32_t j = 0; j + 1 < n; ++j) {
      for (std::uint32_t i = 0; i + 1 < n; ++i) {
        const std::uint32_t a = j * n + i, b = a + 1, c = a + n, d = c + 1;
        for (Triangles::value_type t : {Triangles::value_type{a, b, c}, {b, d, c}}) {
          if (side < 0.0) std::swap(t[1], t[2]);
          triangles.push_back(t);
        }
      }
    }
    const std::size_t lone = points.size();
    for (const double y : {-0.5, 3.3, 6.7}) points.emplace_back(0.0, y, 2.4);
    const auto surfels = surfels_from_mesh(points, triangles);
    ASSERT_TRUE(surfels.ok());
    for (std::size_t v = 0; v < points.size(); ++v) {
      const Vector3f front = surfels->pose.axis_u[v].cross(surfels->pose.axis_v[v]).normalized();
      EXPECT_GT(front.x() * side, 0.99) << (v < lone ? "grid " : "loose ") << v;
    }
  }
}

TEST_F(MeshFilesTest, PlyTypesInCapitalsAndUnknownOnesByName) {
  const std::string head = "ply\nformat ascii 1.0\nelement vertex 1\n";
  const Result<PointSet> set = read_points(
      write("u.ply", head + "property DOUBLE X\nproperty Float Y\nproperty Int16 Z\nend_header\n1.5 2 3\n"));
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_EQ(set->position[0], Vector3d(1.5, 2, 3));
  const Result<PointSet> half = read_points(write("h.ply", head + "property float16 x\nend_header\n1\n"));
  ASSERT_FALSE(half.ok());
  EXPECT_EQ(half.error().field, "x");
  EXPECT_NE(half.error().reason.find("float16"), std::string::npos) << half.error().reason;
  EXPECT_NE(half.error().reason.find("uchar"), std::string::npos) << half.error().reason;
}

TEST_F(MeshFilesTest, ACompressedSplatFileIsRefusedByItsName) {
  const Result<PointSet> set =
      read_points(write("p.ply",
                        "ply\nformat binary_little_endian 1.0\nelement chunk 1\nproperty float min_x\n"
                        "element vertex 1\nproperty uint packed_position\nproperty uint packed_rotation\n"
                        "property uint packed_scale\nproperty uint packed_color\nend_header\n" +
                            std::string(20, '\1')));
  ASSERT_FALSE(set.ok());
  EXPECT_EQ(set.error().field, "packed_position");
  EXPECT_NE(set.error().reason.find("PlayCanvas"), std::string::npos) << set.error().reason;
  const Result<PointSet> other =
      read_points(write("o.ply",
                        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float lon\n"
                        "property float lat\nend_header\n1 2\n"));
  EXPECT_NE(other.error().reason.find("it has lon, lat"), std::string::npos) << other.error().reason;
}

TEST_F(MeshFilesTest, PlyNamesWhatItsOtherElementsHold) {
  const Result<PointSet> set = read_points(
      write("f.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 1\nproperty list uchar int vertex_indices\nproperty uchar red\n"
            "element empty 0\nproperty int none\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255\n"));
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_EQ(set->report.unread, Names{"face.red"});
}

TEST_F(MeshFilesTest, NormalsOfAMeshAreSaidToBeUnused) {
  CloudSource source;
  source.files = {{0.0, write("n.off", "NOFF\n3 1 0\n0 0 0 1 0 0\n1 0 0 1 0 0\n0 1 0 1 0 0\n3 0 1 2\n")}};
  const Result<LoadedCloud> loaded = read_cloud(source, 0, 0);
  ASSERT_TRUE(loaded.ok());
  EXPECT_TRUE(has_part(loaded->report.assumed, "normals are not used")) << joined(loaded->report.assumed);
}

}  // namespace
