// Files that lie, stop, or talk nonsense: each gives one error with file, field and reason, at once.
#include <cstdint>

#include "splat/io/point_file.h"
#include "tests/point_files.h"

namespace {

using namespace swept;

using PointsMalformedTest = swept_test::PointFiles;

struct Case {
  const char* name;
  std::string bytes;
  const char* field;   ///< of the error
  const char* reason;  ///< a part of it
};

std::string ply(const std::string& after_format, const std::string& body = "", const char* format = "ascii") {
  return std::string("ply\nformat ") + format + " 1.0\n" + after_format + "end_header\n" + body;
}
std::string vertices(const std::string& count) {
  return "element vertex " + count + "\nproperty float x\nproperty float y\nproperty float z\n";
}
const std::string kFace = "element face 1\nproperty list char int vertex_indices\n";

std::vector<Case> ply_cases() {
  const char* const little = "binary_little_endian";
  const std::string points(36, '\0');
  return {
      {"empty.ply", "", "header", "ply"},
      {"magic.ply", "plyx\n", "header", "ply"},
      {"endless.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", "header", "end_header"},
      {"format.ply", "ply\nformat utf8 1.0\nend_header\n", "format", "ascii"},
      {"noformat.ply", "ply\n" + vertices("1") + "end_header\n1 2 3\n", "format", "not give"},
      {"keyword.ply", ply("vertices 3\n"), "header", "'vertices'"},
      {"type.ply", ply("element vertex 1\nproperty half x\n", "1\n"), "x", "type"},
      {"orphan.ply", ply("property float x\n"), "property", "before"},
      {"twice.ply", ply("element vertex 1\nproperty float x\nproperty float x\n"), "x", "twice"},
      {"twins.ply", ply(vertices("1") + vertices("1")), "vertex", "twice"},
      {"count.ply", ply("element vertex many\n"), "vertex", "whole number"},
      {"negative.ply", ply("element vertex -1\n"), "vertex", "whole number"},
      {"realcount.ply", ply("element face 1\nproperty list float int vertex_indices\n"), "vertex_indices",
       "reals"},
      {"novertex.ply", ply(kFace, "3 0 1 2\n"), "vertex", "no such element"},
      {"nox.ply", ply("element vertex 1\nproperty float y\nproperty float z\n", "1 2\n"), "x",
       "no such property"},
      {"noz.ply", ply("element vertex 1\nproperty float x\nproperty float y\n", "1 2\n"), "z",
       "no such property"},
      {"listx.ply",
       ply("element vertex 1\nproperty list char float x\nproperty float y\nproperty float z\n", "0 1 2\n"),
       "x", "no such property"},
      {"none.ply", ply(vertices("0")), "", "no points"},
      {"lie.ply", ply(vertices("4000000000"), points, little), "vertex", "promises 4000000000"},
      {"liar.ply", ply(vertices("18446744073709551615"), points, little), "vertex", "promises"},
      {"asciilie.ply", ply(vertices("1000000000000"), "1 2 3\n"), "vertex", "promises"},
      {"before.ply", ply("element junk 999999999999\nproperty double q\n" + vertices("1"), points, little),
       "junk", "promises"},
      {"one.ply", ply(vertices("4"), points, little), "vertex", "36 bytes left"},
      {"word.ply", ply(vertices("2"), "1 2 3\n4 five 6\n"), "y", "'five' is not a number"},
      {"hex.ply", ply(vertices("1"), "1 0x10 6\n"), "y", "'0x10'"},
      {"shortrow.ply", ply(vertices("2"), "1 2\n3 4 5\n6 7\n"), "z", "vertex 0: the line ends"},
      {"longrow.ply", ply(vertices("2"), "1 2 3 4\n3 4 5\n6 7\n"), "z", "vertex 0: the line goes on"},
      {"huge.ply", ply(vertices("1"), "1 1e39 6\n"), "y", "float"},
      {"overflow.ply", ply(vertices("1"), "1 1e999 6\n"), "y", "inf"},
      {"corner.ply", ply(vertices("3") + kFace, "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "vertex_indices",
       "3 vertices"},
      {"minus.ply", ply(vertices("3") + kFace, "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"), "vertex_indices",
       "3 vertices"},
      {"half.ply", ply(vertices("3") + kFace, "0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n"), "vertex_indices",
       "3 vertices"},
      {"length.ply", ply(vertices("3") + kFace, points + "\xff", little), "vertex_indices", "length"},
      {"list.ply",
       ply(vertices("3") + "element face 1\nproperty list uint int vertex_indices\n",
           points + std::string("\xff\xff\xff\xff", 4), little),
       "vertex_indices", "4294967295 entries"},
      {"radius.ply", ply(vertices("1") + "property float radius\n", "1 2 3 -1\n"), "radius", "negative"},
      {"opacity.ply", ply(vertices("1") + "property float opacity\n", "1 2 3 1.5\n"), "opacity", "[0, 1]"},
      {"quaternion.ply",
       ply(vertices("1") + "property float scale_0\nproperty float scale_1\nproperty float rot_0\n"
                           "property float rot_1\nproperty float rot_2\nproperty float rot_3\n",
           "1 2 3 0 0 0 0 0 0\n"),
       "rot_0", "length zero"},
      {"scale.ply",
       ply(vertices("1") + "property float scale_0\nproperty float scale_1\nproperty float rot_0\n"
                           "property float rot_1\nproperty float rot_2\nproperty float rot_3\n",
           "1 2 3 0 89 1 0 0 0\n"),
       "scale_1", "too large"},
  };
}

std::string pcd(const std::string& fields, const std::string& size, const std::string& type,
                const std::string& points, const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " + size + "\nTYPE " + type + "\nWIDTH " +
         points + "\nHEIGHT 1\nPOINTS " + points + "\nDATA " + data;
}

std::vector<Case> other_cases() {
  const std::string points(24, '\0');
  const auto u32 = [](std::uint32_t value) { return std::string(reinterpret_cast<const char*>(&value), 4); };
  return {
      {"no.pcd", "VERSION 0.7\n", "DATA", "header"},
      {"nofields.pcd", "DATA ascii\n", "FIELDS", "not give"},
      {"sizes.pcd", pcd("x y z", "4 4", "F F F", "1", "ascii\n1 2 3\n"), "SIZE", "FIELDS"},
      {"type.pcd", pcd("x y z", "4 2 4", "F F F", "1", "ascii\n1 2 3\n"), "y", "unknown"},
      {"zero.pcd", pcd("x y z", "4 4 4", "F F F", "0", "ascii\n"), "WIDTH", "whole number"},
      {"nox.pcd", pcd("u y z", "4 4 4", "F F F", "1", "ascii\n1 2 3\n"), "x", "no such property"},
      {"encoding.pcd", pcd("x y z", "4 4 4", "F F F", "1", "base64\n"), "DATA", "ascii"},
      {"word.pcd", pcd("x y z", "4 4 4", "F F F", "1", "ascii\n1 two 3\n"), "y", "'two'"},
      {"short.pcd", pcd("x y z", "4 4 4", "F F F", "2", "ascii\n10 20 30\n40 50\n"), "DATA", "point 1"},
      {"asciilie.pcd", pcd("x y z", "4 4 4", "F F F", "4000000000", "ascii\n1 2 3\n"), "POINTS", "promises"},
      {"lie.pcd", pcd("x y z", "4 4 4", "F F F", "4000000000", "binary\n" + points), "POINTS", "promises"},
      {"cut.pcd", pcd("x y z", "4 4 4", "F F F", "3", "binary\n" + points), "POINTS", "24 bytes left"},
      {"nan.pcd", pcd("x y z", "4 4 4", "F F F", "1", "ascii\n1 nan 3\n"), "y", "nan"},
      {"cut2.pcd", pcd("x y z", "4 4 4", "F F F", "2", "binary_compressed\n1234"), "DATA", "ends"},
      {"cut3.pcd", pcd("x y z", "4 4 4", "F F F", "2", "binary_compressed\n" + u32(99) + u32(24) + points),
       "DATA", "99 compressed"},
      {"lie2.pcd", pcd("x y z", "4 4 4", "F F F", "2", "binary_compressed\n" + u32(24) + u32(25) + points),
       "POINTS", "promises"},
      {"bomb.pcd",
       pcd("x y z", "4 4 4", "F F F", "300000000",
           "binary_compressed\n" + u32(24) + u32(3600000000u) + points),
       "DATA", "damaged"},
      {"damage.pcd",
       pcd("x y z", "4 4 4", "F F F", "2",
           "binary_compressed\n" + u32(24) + u32(24) + std::string(24, '\xff')),
       "DATA", "damaged"},
      {"none.xyz", "# nothing\n\n", "", "no points"},
      {"two.xyz", "1 2\n", "line 1", "2 numbers"},
      {"ragged.xyz", "1 2 3\n# c\n1 2 3 4 5 6\n", "line 3", "6 numbers"},
      {"word.xyz", "1 2 3\n1 2 c\n", "line 2, z", "'c' is not a number"},
      {"inf.xyz", "1 2 3\n1 -inf 2\n", "y", "point 1 is -inf"},
      {"none.obj", "# nothing\n", "", "no points"},
      {"word.obj", "v 1 2 3\nv 1 abc 2\n", "line 2, y", "'abc'"},
      {"short.obj", "v 1 2\n", "line 1, z", "fewer than three"},
      {"zero.obj", "v 1 2 3\nf 0 1 1\n", "line 2, face", "names no vertex"},
      {"beyond.obj", "v 1 2 3\nf 1 1 2\n", "face", "index 2"},
      {"back.obj", "v 1 2 3\nf -1 -2 -1\n", "line 2, face", "names no vertex"},
      {"corner.obj", "v 1 2 3\nf 1 x 1\n", "line 2, face", "'x'"},
      {"magic.off", "FOO\n", "header", "OFF"},
      {"binary.off", "OFF BINARY\n", "header", "binary"},
      {"counts.off", "OFF\nmany 1 0\n", "line 2, header", "numbers of vertices"},
      {"lie.off", "OFF\n4000000000000 1 0\n0 0 0\n", "vertex", "the file has 1"},
      {"lief.off", "OFF\n1 4000000000000 0\n0 0 0\n", "face", "the file has 0"},
      {"list.off", "OFF\n1 1 0\n0 0 0\n9000000000 0 0\n", "line 4, face", "fewer"},
      {"corner.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "line 4, face", "index 1"},
      {"word.off", "OFF\n1 0 0\n0 zz 0\n", "line 3, y", "'zz'"},
      {"what.las", "LASF", "", "extension"},
  };
}

TEST_F(PointsMalformedTest, EveryFaultNamesFileFieldAndReason) {
  std::vector<Case> cases = ply_cases();
  for (Case& c : other_cases()) cases.push_back(std::move(c));
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const std::string path = write(c.name, c.bytes);
    const Result<PointSet> set = read_points(path);
    ASSERT_FALSE(set.ok());
    EXPECT_EQ(set.error().file, path);
    EXPECT_EQ(set.error().field, c.field);
    EXPECT_NE(set.error().reason.find(c.reason), std::string::npos) << set.error().reason;
  }
}

TEST_F(PointsMalformedTest, WhatIsNoFileIsSaidToBeNone) {
  EXPECT_EQ(read_points(folder_ / "absent.ply").error().reason, "no such file");
  std::filesystem::create_directory(folder_ / "folder.ply");
  EXPECT_EQ(read_points(folder_ / "folder.ply").error().reason, "is not a regular file");
}

// Damage of any kind may be refused or go unseen, but never more than that; the sanitizers watch.
TEST_F(PointsMalformedTest, FlippedBytesNeverDoHarm) {
  const std::string points(24, '\1');
  const std::vector<std::pair<const char*, std::string>> files{
      {"f.ply", ply(vertices("2") + kFace, points + std::string("\3\0\0\0\0\1\0\0\0\0\0\0\0", 13),
                    "binary_little_endian")},
      {"f.pcd", pcd("x y z", "4 4 4", "F F F", "2",
                    std::string("binary_compressed\n\x1a\0\0\0\x18\0\0\0\x17", 27) + points + "\x20\1")},
      {"f.obj", "v 1 2 3\nv 4 5 6\nv 7 8 10\nf 1 2 3\n"},
      {"f.off", "OFF\n3 1 0\n1 2 3\n4 5 6\n7 8 10\n3 0 1 2\n"},
      {"f.xyz", "1 2 3\n4 5 6\n"}};
  for (const auto& [name, bytes] : files) {
    int refused = 0;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      for (const int flip : {0x11, 0xff}) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ flip);
        const Result<PointSet> set = read_points(write(name, damaged));
        if (set.ok()) {
          EXPECT_GT(set->size(), 0u);
          for (const auto& triangle : set->triangle) {
            for (const std::uint32_t corner : triangle) ASSERT_LT(corner, set->size());
          }
        } else {
          ++refused;
          EXPECT_FALSE(set.error().reason.empty());
        }
      }
    }
    EXPECT_GT(refused, 0) << name;
  }
}

}  // namespace
