// Every point format read from files written here, byte for byte known, and broken in every way we know.
#include <cmath>

#include "splat/io/point_file.h"
#include "tests/point_files.h"

namespace {

using namespace swept;
using swept_test::float_ply;
using swept_test::kPlyFormats;
using swept_test::PlyBody;

using PointsIoTest = swept_test::PointFiles;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// Survey coordinates in double, odd order, lists within, before and after the vertices.
std::string rich_ply(const std::string& format) {
  std::string header = "ply\nformat " + format + " 1.0\ncomment made for a test\nobj_info nothing\n";
  header += "element camera 2\nproperty list uchar short keys\nproperty float zoom\n";
  header += "element nothing 4000000000\n";
  header += "element vertex 3\nproperty uchar red\nproperty list int double weights\nproperty double z\n";
  header += "property float32 vx\nproperty float32 vy\nproperty float32 vz\nproperty float64 x\n";
  header += "property uint8 green\nproperty uint8 blue\nproperty uchar alpha\nproperty double y\n";
  header += "property float confidence\nproperty float radius\n";
  header += "element face 2\nproperty uchar flags\nproperty list uchar uint vertex_indices\n";
  header += "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n";
  PlyBody body(format);
  for (const int length : {2, 0}) {
    body.put("uchar", length);
    for (int i = 0; i < length; ++i) body.put("short", -i);
    body.put("float", 1.5).end_row();
  }
  for (int i = 0; i < 3; ++i) {
    body.put("uchar", 255).put("int", i);
    for (int k = 0; k < i; ++k) body.put("double", 0.1 * k);
    body.put("double", -0.125 * i).put("float", 1 + i).put("float", 2).put("float", -3);
    body.put("double", 5400000.123456789 + i).put("uchar", 128).put("uchar", 10).put("uchar", 51 * i);
    body.put("double", 300000.000001 * i).put("float", 9).put("float", 0.25).end_row();
  }
  body.put("uchar", 1).put("uchar", 3).put("uint", 0).put("uint", 1).put("uint", 2).end_row();
  body.put("uchar", 1).put("uchar", 4);
  for (const int corner : {2, 1, 0, 1}) body.put("uint", corner);
  body.end_row();
  body.put("int", -1).put("int", 2).end_row();
  return header + body.bytes();
}

TEST_F(PointsIoTest, PlyReadsTheSameInEveryEncoding) {
  for (const std::string& format : kPlyFormats) {
    SCOPED_TRACE(format);
    const Result<PointSet> set = read_points(write("rich.ply", rich_ply(format)));
    ASSERT_TRUE(set.ok()) << set.error().message();
    ASSERT_EQ(set->size(), 3u);
    ASSERT_EQ(set->velocity.size(), 3u);
    ASSERT_EQ(set->color.size(), 3u);
    ASSERT_EQ(set->opacity.size(), 3u);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(set->position[i], Vector3d(5400000.123456789 + i, 300000.000001 * i, -0.125 * i));
      EXPECT_EQ(set->velocity[i], Vector3f(1.0f + static_cast<float>(i), 2.0f, -3.0f));
      EXPECT_FLOAT_EQ(set->opacity[i], 0.2f * static_cast<float>(i));
      // sRGB 128 and 10 of 255 in linear light, to 7 digits.
      EXPECT_EQ(set->color[i].x(), 1.0f);
      EXPECT_NEAR(set->color[i].y(), 0.2158605, 5e-8);
      EXPECT_NEAR(set->color[i].z(), 0.0030353, 5e-8);
    }
    EXPECT_EQ(set->radius, std::vector<float>(3, 0.25f));
    const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}, {2, 1, 0}, {2, 0, 1}};
    EXPECT_EQ(set->triangle, triangles);
    EXPECT_TRUE(set->normal.empty());
  }
}

TEST_F(PointsIoTest, BinaryPlyCutShortAnywhereIsAnError) {
  for (const std::string& format : {kPlyFormats[1], kPlyFormats[2]}) {
    const std::string whole = rich_ply(format);
    const std::size_t body = whole.find("end_header");
    for (std::size_t length = 0; length < whole.size(); length += length < body ? 13 : 1) {
      const Result<PointSet> set = read_points(write("cut.ply", whole.substr(0, length)));
      ASSERT_FALSE(set.ok()) << format << " cut to " << length;
      ASSERT_FALSE(set.error().field.empty());
    }
  }
}

TEST_F(PointsIoTest, PlyKnowsEveryTypeName) {
  for (const std::string& format : kPlyFormats) {
    for (const char* type : {"char", "int8", "uchar", "uint8", "short", "int16", "ushort", "uint16", "int",
                             "int32", "uint", "uint32", "float", "float32", "double", "float64"}) {
      const bool is_unsigned = type[0] == 'u';
      const double x = is_unsigned ? 113.0 : -113.0;
      PlyBody body(format);
      body.put(type, x).put(type, 2).put(type, 3).end_row();
      std::string bytes = "ply\r\nformat " + format + " 1.0\r\nelement vertex 1\r\n";
      for (const char* axis : {"x", "y", "z"}) bytes += std::string("property ") + type + " " + axis + "\r\n";
      const Result<PointSet> set = read_points(write("t.ply", bytes + "end_header\r\n" + body.bytes()));
      ASSERT_TRUE(set.ok()) << format << " " << type << ": " << set.error().message();
      EXPECT_EQ(set->position[0], Vector3d(x, 2, 3)) << format << " " << type;
    }
  }
}

TEST_F(PointsIoTest, AliasesWidthsAndRealColours) {
  const std::string path =
      write("a.ply", float_ply("ascii",
                               {"x", "y", "z", "normal_x", "normal_y", "normal_z", "velocity_x", "velocity_y",
                                "velocity_z", "r", "g", "b", "width", "opacity"},
                               {{1, 2, 3, 0, 3, 4, 7, 8, 9, 0.25, 2, 0, 0.5, 0.75}}));
  const Result<PointSet> set = read_points(path);
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_EQ(set->normal[0], Vector3f(0, 0.6f, 0.8f));
  EXPECT_EQ(set->velocity[0], Vector3f(7, 8, 9));
  EXPECT_EQ(set->color[0], Vector3f(0.25f, 2, 0));
  EXPECT_EQ(set->radius[0], 0.25f);
  EXPECT_EQ(set->opacity[0], 0.75f);
}

TEST_F(PointsIoTest, TheCallersNamesReplaceTheUsualOnes) {
  const std::string path =
      write("m.ply", float_ply("binary_big_endian", {"x", "y", "z", "vx", "vy", "vz", "a", "b"},
                               {{1, 2, 3, 4, 5, 6, 7, 8}}));
  ReadOptions options;
  options.attributes = {{"velocity", "a, b,x"}, {"position", "vz,vy,vx"}, {"radius", "b"}};
  const Result<PointSet> set = read_points(path, options);
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_EQ(set->position[0], Vector3d(6, 5, 4));
  EXPECT_EQ(set->velocity[0], Vector3f(7, 8, 1));
  EXPECT_EQ(set->radius[0], 8.0f);
  options.attributes = {{"velocity", ""}};
  EXPECT_TRUE(read_points(path, options)->velocity.empty());

  const auto field_of = [&](const char* attribute, const char* names) {
    ReadOptions wrong;
    wrong.attributes = {{attribute, names}};
    const Result<PointSet> read = read_points(path, wrong);
    return read.ok() ? "none" : read.error().field + "|" + read.error().reason;
  };
  EXPECT_EQ(field_of("velocity", "vx,vy,speed"), "attributes.velocity|the file has no property 'speed'");
  EXPECT_EQ(field_of("velocity", "vx,vy"), "attributes.velocity|names 2 properties, must name 3");
  EXPECT_EQ(field_of("speed", "vx").substr(0, 16), "attributes.speed");
  EXPECT_EQ(field_of("position", "").substr(0, 19), "attributes.position");
}

TEST_F(PointsIoTest, GaussianSplatsBecomeDiscsOfTheSameGaussian) {
  // A quarter turn about z, as a quaternion twice too long: x goes to y, y to -x.
  const double w = 2.0 * std::sqrt(0.5);
  const std::vector<std::string> names{"x",       "y",       "z",      "nx",     "ny",    "nz",
                                       "scale_0", "scale_1", "rot_0",  "rot_1",  "rot_2", "rot_3",
                                       "f_dc_0",  "f_dc_1",  "f_dc_2", "opacity"};
  const std::vector<double> row{1, 2, 3, 0, 0, 0, std::log(0.1), std::log(0.2), w, 0, 0, w, 0, 1, -9, 0};
  for (const double delta : {3.0, 0.5}) {
    ReadOptions options;
    options.delta = delta;
    const Result<PointSet> set = read_points(write("g.ply", float_ply("ascii", names, {row})), options);
    ASSERT_TRUE(set.ok()) << set.error().message();
    // exp(-delta (s/|a|)²) at s = one standard deviation is exp(-1/2) if |a| = s sqrt(2 delta). The file
    // holds floats: the log of the scale to half an ulp of 2, 1.2e-7, the quaternion to 6e-8.
    const float cutoff = static_cast<float>(std::sqrt(2.0 * delta));
    EXPECT_LE((set->axis_u[0] - Vector3f(0, 0.1f, 0) * cutoff).norm(), 5e-7f * 0.1f * cutoff);
    EXPECT_LE((set->axis_v[0] - Vector3f(-0.2f, 0, 0) * cutoff).norm(), 5e-7f * 0.2f * cutoff);
    EXPECT_TRUE(set->normal.empty());
    EXPECT_EQ(set->opacity[0], 0.5f);
    EXPECT_NEAR(set->color[0].x(), 0.2140411, 5e-8);  // sRGB 0.5
    EXPECT_NEAR(set->color[0].y(), 0.5739225, 1e-6);  // sRGB 0.7820948
    EXPECT_EQ(set->color[0].z(), 0.0f);               // below black
  }
  // In 3D the shortest axis goes, and what is left keeps it as its front.
  std::vector<std::string> names3 = names;
  names3.push_back("scale_2");
  std::vector<double> row3 = row;
  row3[7] = std::log(0.01);
  row3.push_back(std::log(0.3));
  const Result<PointSet> set =
      read_points(write("g3.ply", float_ply("binary_little_endian", names3, {row3})));
  ASSERT_TRUE(set.ok()) << set.error().message();
  const float cutoff = std::sqrt(6.0f);
  EXPECT_LE((set->axis_u[0] - Vector3f(0, 0, 0.3f) * cutoff).norm(), 5e-7f * 0.3f * cutoff);
  EXPECT_LE((set->axis_v[0] - Vector3f(0, 0.1f, 0) * cutoff).norm(), 5e-7f * 0.1f * cutoff);
  EXPECT_EQ(set->notes.size(), 1u);
}

TEST_F(PointsIoTest, AQuaternionsLengthDoesNotMatter) {
  for (const double length : {1e-300, 1e-160, 1.0, 1e38}) {
    PlyBody body("binary_little_endian");
    for (const double value : {0.0, 0.0, 0.0, 0.0, 0.0}) body.put("double", value);
    for (const double value : {1.0, 0.0, 0.0, 1.0}) body.put("double", length * value);
    std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n";
    for (const char* name : {"x", "y", "z", "scale_0", "scale_1", "rot_0", "rot_1", "rot_2", "rot_3"})
      header += std::string("property double ") + name + "\n";
    const Result<PointSet> set = read_points(write("q.ply", header + "end_header\n" + body.bytes()));
    ASSERT_TRUE(set.ok()) << set.error().message();
    const float cutoff = std::sqrt(6.0f);
    EXPECT_LE((set->axis_u[0] - Vector3f(0, cutoff, 0)).norm(), 0x1p-22f * cutoff) << length;
    EXPECT_LE((set->axis_v[0] - Vector3f(-cutoff, 0, 0)).norm(), 0x1p-22f * cutoff) << length;
  }
}

TEST_F(PointsIoTest, ColoursThatAFloatCannotHoldAreInvalid) {
  const std::vector<std::string> names{"x",     "y",     "z",     "scale_0", "scale_1", "rot_0",
                                       "rot_1", "rot_2", "rot_3", "f_dc_0",  "f_dc_1",  "f_dc_2"};
  const std::string path = write("c.ply", float_ply("ascii", names,
                                                    {{0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1e20, 1},
                                                     {0, 0, 0, 0, 0, 1, 0, 0, 0, 1, -1e20, 1e15}}));
  const Result<PointSet> strict = read_points(path);
  ASSERT_FALSE(strict.ok());
  EXPECT_EQ(strict.error().field, "f_dc_1");
  EXPECT_NE(strict.error().reason.find("too large for a colour"), std::string::npos);
  ReadOptions options;
  options.skip_invalid = true;
  const Result<PointSet> lenient = read_points(path, options);
  ASSERT_TRUE(lenient.ok()) << lenient.error().message();
  ASSERT_EQ(lenient->size(), 1u);
  EXPECT_TRUE(lenient->color[0].allFinite());
}

TEST_F(PointsIoTest, PcdMayCountItsPointsByWidthAndHeightAlone) {
  const std::string header = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
  const std::string points = "DATA ascii\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
  const Result<PointSet> set = read_points(write("w.pcd", header + "WIDTH 2\nHEIGHT 2\n" + points));
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_EQ(set->size(), 4u);
  EXPECT_TRUE(read_points(write("p.pcd", header + "POINTS 4\n" + points)).ok());
  EXPECT_FALSE(read_points(write("n.pcd", header + "WIDTH 4\n" + points)).ok());
}

TEST_F(PointsIoTest, InvalidPointsAreAnErrorOrDropped) {
  for (const std::string& format : kPlyFormats) {
    std::string bytes =
        float_ply(format, {"x", "y", "z"}, {{0, 0, 0}, {1, NAN, 0}, {2, 0, 0}, {3, 0, -INFINITY}, {4, 0, 0}});
    const std::string path = write("n.ply", bytes);
    const Result<PointSet> strict = read_points(path);
    ASSERT_FALSE(strict.ok());
    EXPECT_EQ(strict.error().file, path);
    EXPECT_EQ(strict.error().field, "y");
    EXPECT_NE(strict.error().reason.find("point 1 is nan"), std::string::npos) << strict.error().reason;
    ReadOptions options;
    options.skip_invalid = true;
    const Result<PointSet> lenient = read_points(path, options);
    ASSERT_TRUE(lenient.ok()) << lenient.error().message();
    ASSERT_EQ(lenient->size(), 3u);
    EXPECT_EQ(lenient->position[1].x(), 2.0);
    ASSERT_EQ(lenient->notes.size(), 1u);
    EXPECT_NE(lenient->notes[0].find("dropped 2 of 5"), std::string::npos);
  }
  // Triangles follow their corners, or go.
  ReadOptions options;
  options.skip_invalid = true;
  const Result<PointSet> mesh =
      read_points(write("n.off", "OFF\n4 2 0\nnan 0 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 1 2 3\n"), options);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message();
  EXPECT_EQ(mesh->triangle, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}}));
}

TEST_F(PointsIoTest, TextWithCommentsCommasAndNamedColumns) {
  const Result<PointSet> six = read_points(
      write("s.XYZ", "# x y z nx ny nz\n\n5400000.123456, 2,3, 0,0,2 # end\r\n// more\n+1;-2e0;3.5;1;0;0\n"));
  ASSERT_TRUE(six.ok()) << six.error().message();
  EXPECT_EQ(six->position[0], Vector3d(5400000.123456, 2, 3));
  EXPECT_EQ(six->position[1], Vector3d(1, -2, 3.5));
  EXPECT_EQ(six->normal[0], Vector3f(0, 0, 1));
  const std::string path = write("c.txt", "9 1 2 3 0.5\n8 4 5 6 0.25");
  EXPECT_FALSE(read_points(path).ok());
  ReadOptions options;
  options.attributes = {{"position", "2,3,4"}, {"radius", "5"}};
  const Result<PointSet> named = read_points(path, options);
  ASSERT_TRUE(named.ok()) << named.error().message();
  EXPECT_EQ(named->position[1], Vector3d(4, 5, 6));
  EXPECT_EQ(named->radius[1], 0.25f);
}

TEST_F(PointsIoTest, MeshFormatsKeepDoublesAndEveryFace) {
  // Three faces on one edge: no half-edge mesh would keep them.
  const std::string obj =
      "# a fin\nmtllib none\nv 5400000.123456 0 0 1\nv 1 0 0\nvn 0 0 1\nvt 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 "
      "0\ng a\n"
      "f 1 2 3\nf 1/1 2/1 4/1\nf 1//1 2//1 5//1\nf -5/1/1 -4/1/1 -3 -2\nl 1 2\n";
  const Result<PointSet> from_obj = read_points(write("m.obj", obj));
  ASSERT_TRUE(from_obj.ok()) << from_obj.error().message();
  ASSERT_EQ(from_obj->size(), 5u);
  EXPECT_EQ(from_obj->position[0].x(), 5400000.123456);
  const std::vector<std::array<std::uint32_t, 3>> triangles{
      {0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(from_obj->triangle, triangles);
  const std::string off =
      "OFF # comment\n# more\n5 4 0\n5400000.123456 0 0\n1 0 0 255 0 0\n0 1 0\n0 0 1\n0 -1 0\n\n"
      "3 0 1 2\n3 0 1 3 1 0 0\n3 0 1 4\n4 0 1 2 3\n";
  const Result<PointSet> from_off = read_points(write("m.off", off));
  ASSERT_TRUE(from_off.ok()) << from_off.error().message();
  EXPECT_EQ(from_off->position, from_obj->position);
  EXPECT_EQ(from_off->triangle, triangles);
}

TEST_F(PointsIoTest, StripsTurnEverySecondTriangleAndJoinNothing) {
  for (const std::string& format : kPlyFormats) {
    std::string header = "ply\nformat " + format + " 1.0\nelement tristrips 1\n";
    header += "property list int int vertex_indices\nelement vertex 4\n";
    header += "property float x\nproperty float y\nproperty float z\nend_header\n";
    PlyBody body(format);
    body.put("int", 13);
    for (const int index : {0, 1, 2, 3, -1, 3, 2, 2, 1, 0, -1, 0, 1}) body.put("int", index);
    body.end_row();
    for (int i = 0; i < 4; ++i) body.put("float", i).put("float", i * i).put("float", 0).end_row();
    const Result<PointSet> set = read_points(write("s.ply", header + body.bytes()));
    ASSERT_TRUE(set.ok()) << set.error().message();
    const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}, {2, 1, 3}, {2, 1, 0}};
    EXPECT_EQ(set->triangle, triangles) << format;
  }
}

}  // namespace
