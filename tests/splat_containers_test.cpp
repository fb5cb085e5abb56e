// .splat files and PlayCanvas' packed PLY, written here by their descriptions.
#include <cmath>
#include <limits>

#include "splat/io/read_splats.h"
#include "tests/point_files.h"

namespace {

using namespace swept;

template <class T>
std::string raw(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

using Read = Result<LoadedSplats> (*)(const std::string&, std::string_view, const SplatReadOptions&);

std::string refusal(Read read, const std::string& bytes) {
  const Result<LoadedSplats> file = read("a.file", bytes, {});
  if (file.ok()) return "none";
  EXPECT_EQ(file.error().file, "a.file");
  return file.error().field + ": " + file.error().reason;
}

std::string splat(float x, float scale, std::array<int, 4> rgba, std::array<int, 4> rotation) {
  std::string bytes = raw(x) + raw(2.0f) + raw(-3.0f) + raw(scale) + raw(0.25f) + raw(0.0f);
  for (const int byte : rgba) bytes += static_cast<char>(byte);
  for (const int byte : rotation) bytes += static_cast<char>(byte);
  return bytes;
}

TEST(SplatContainersTest, SplatFiles) {
  const std::string bytes = splat(1.5f, 0.5f, {255, 51, 0, 102}, {255, 128, 128, 128}) +
                            splat(-1.0f, 4.0f, {0, 0, 0, 255}, {128, 0, 128, 218});
  const Result<LoadedSplats> file = io::read_splat("a.splat", bytes, {});
  ASSERT_TRUE(file.ok()) << file.error().message();
  const SplatCloud& cloud = file->splats;
  EXPECT_TRUE(cloud.validate().ok());
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.degree, 0);
  EXPECT_EQ(cloud.position[0], Eigen::Vector3d(1.5, 2, -3));
  EXPECT_EQ(cloud.scale[1], Eigen::Vector3f(4, 0.25f, 0));
  EXPECT_FLOAT_EQ(cloud.opacity[0], 0.4f);
  EXPECT_FLOAT_EQ(cloud.harmonics[0], 0.5f / 0.28209479f);
  EXPECT_FLOAT_EQ(cloud.harmonics[1], -0.3f / 0.28209479f);
  EXPECT_NEAR(cloud.rotation[0].w(), 1.0f, 1e-4f);
  // x y z w of the second: a byte is 1/127.5, and the writer's lengths need not be 1.
  EXPECT_LT((cloud.rotation[1].coeffs() - Eigen::Vector4f(-1, 0, 0.7059f, 0).normalized()).norm(), 0.01f);
}

TEST(SplatContainersTest, SplatFilesThatAreWrong) {
  const std::string good = splat(1, 1, {1, 2, 3, 4}, {255, 128, 128, 128});
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_NE(refusal(io::read_splat, good + good.substr(0, size)), size == 0 ? "" : "none");
  EXPECT_EQ(refusal(io::read_splat, ""), ": has no splats");
  EXPECT_EQ(refusal(io::read_splat, good.substr(1)),
            ": has 31 bytes, which is no multiple of the 32 of a splat");
  EXPECT_EQ(refusal(io::read_splat, good + splat(1, -1, {1, 2, 3, 4}, {255, 128, 128, 128})),
            "scale: splat 1 is -1, must not be negative");
  EXPECT_EQ(
      refusal(io::read_splat, splat(std::numeric_limits<float>::infinity(), 1, {1, 2, 3, 4}, {255, 0, 0, 0}))
          .find("position: splat 0 is inf"),
      0u);
}

/// Packed PLY: chunks, splats and harmonics as bytes, and the header that goes with them.
struct Packed {
  std::string vertex_count, chunk_count = "1", sh_count;
  std::string chunk, vertex, sh;
  bool colors = true;
  int rest = 9;

  explicit Packed(std::size_t count) : vertex_count(std::to_string(count)), sh_count(vertex_count) {
    for (const float x : {-1.0f, -2.0f, -3.0f, 1.0f, 2.0f, 5.0f, -4.0f, -4.0f, -4.0f, 0.0f, 0.0f, 1.0f, 0.0f,
                          0.0f, 0.0f, 2.0f, 1.0f, 1.0f})
      chunk += raw(x);
    for (std::size_t i = 0; i < count; ++i) {
      const auto n = static_cast<std::uint32_t>(i);
      vertex += raw(std::uint32_t{2047} << 21 | std::uint32_t{0} << 11 | (n % 2048));
      vertex += raw((n % 4) << 30 | 1023u << 20 | 512u << 10 | 0u);
      vertex += raw(std::uint32_t{0} << 21 | std::uint32_t{1023} << 11 | 2047u);
      vertex += raw(255u << 24 | 51u << 16 | 0u << 8 | (n % 256));
      for (int k = 0; k < 9; ++k) sh += static_cast<char>(k == 0 ? 0 : k == 1 ? 255 : 128 + k);
    }
  }

  [[nodiscard]] std::string bytes() const {
    std::string header = "ply\nformat binary_little_endian 1.0\nelement chunk " + chunk_count + "\n";
    std::vector<const char*> names{"min_x",       "min_y",       "min_z",       "max_x",
                                   "max_y",       "max_z",       "min_scale_x", "min_scale_y",
                                   "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z"};
    if (colors) names.insert(names.end(), {"min_r", "min_g", "min_b", "max_r", "max_g", "max_b"});
    for (const char* name : names) header += std::string("property float ") + name + "\n";
    header += "element vertex " + vertex_count + "\n";
    for (const char* name : {"packed_position", "packed_rotation", "packed_scale", "packed_color"})
      header += std::string("property uint ") + name + "\n";
    if (rest > 0) header += "element sh " + sh_count + "\n";
    for (int k = 0; k < rest; ++k) header += "property uchar f_rest_" + std::to_string(k) + "\n";
    return header + "end_header\n" + chunk + vertex + (rest > 0 ? sh : "");
  }
};

TEST(SplatContainersTest, PackedPly) {
  const Result<LoadedSplats> file = io::read_splat_ply("a.ply", Packed(4).bytes(), {});
  ASSERT_TRUE(file.ok()) << file.error().message();
  const SplatCloud& cloud = file->splats;
  EXPECT_TRUE(cloud.validate().ok());
  ASSERT_EQ(cloud.size(), 4u);
  EXPECT_EQ(cloud.degree, 1);
  EXPECT_TRUE(cloud.position[1].isApprox(Eigen::Vector3d(1.0, -2.0, -3.0 + 8.0 / 2047.0), 1e-12));
  EXPECT_FLOAT_EQ(cloud.scale[0].x(), std::exp(-4.0f));
  EXPECT_FLOAT_EQ(cloud.scale[0].y(), 1.0f);
  EXPECT_FLOAT_EQ(cloud.scale[0].z(), std::exp(1.0f));
  EXPECT_FLOAT_EQ(cloud.opacity[3], 3.0f / 255.0f);
  // Red spans 0 to 2, the others 0 to 1.
  EXPECT_FLOAT_EQ(cloud.harmonics[0], 1.5f / 0.28209479f);
  EXPECT_FLOAT_EQ(cloud.harmonics[1], -0.3f / 0.28209479f);
  // 0.7071, 0.0007 and −0.7071, and the largest of w x y z is left out in turn.
  const float r = std::sqrt(0.5f);
  const Eigen::Vector4f expected[4] = {
      {r, 0, -r, 0}, {0, 0, -r, r}, {0, 0, -r, r}, {0, -r, 0, r}};  // x y z w
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT((cloud.rotation[i].coeffs() - expected[i]).cwiseAbs().maxCoeff(), 0.002f) << i;
  // Three of red, three of green, three of blue: 0 and 255 are the ends.
  EXPECT_EQ(cloud.harmonics[3], -4.0f);
  EXPECT_EQ(cloud.harmonics[6], 4.0f);
  EXPECT_EQ(cloud.harmonics[4], (131.5f / 256.0f - 0.5f) * 8.0f);
}

TEST(SplatContainersTest, PackedPlyWithoutColorRangesAndHarmonics) {
  Packed packed(1);
  packed.colors = false;
  packed.chunk.resize(48);
  packed.rest = 0;
  const Result<LoadedSplats> file = io::read_splat_ply("a.ply", packed.bytes(), {});
  ASSERT_TRUE(file.ok()) << file.error().message();
  EXPECT_EQ(file->splats.degree, 0);
  EXPECT_FLOAT_EQ(file->splats.harmonics[0], 0.5f / 0.28209479f);
}

TEST(SplatContainersTest, PackedPlyThatLies) {
  const auto refused = [](const Packed& packed) { return refusal(io::read_splat_ply, packed.bytes()); };
  EXPECT_EQ(refused(Packed(257)), "chunk: there are 1 of them for 257 splats, not 2");
  Packed few(2);
  few.sh_count = "1";
  EXPECT_EQ(refused(few), "sh: there are 1 of them for 2 splats");
  Packed many(1);
  many.vertex_count = "18446744073709551615";
  many.chunk_count = "72057594037927936";
  EXPECT_EQ(refused(many), "sh: there are 1 of them for 18446744073709551615 splats");
  many.sh_count = many.vertex_count;
  EXPECT_EQ(refused(many).find("chunk: the header promises 72057594037927936"), 0u);
  Packed harmonics(1);
  harmonics.rest = 8;
  EXPECT_EQ(refused(harmonics).find("f_rest_0: 8 such properties"), 0u);
  Packed infinite(1);
  infinite.chunk.replace(4, 4, raw(std::numeric_limits<float>::infinity()));
  EXPECT_NE(refused(infinite), "none");
  infinite = Packed(1);
  infinite.chunk.replace(11 * 4, 4, raw(1000.0f));
  EXPECT_EQ(refused(infinite).find("min_scale_z, max_scale_z: splat 0 gives"), 0u) << refused(infinite);
  std::string words = Packed(1).bytes();
  words.replace(words.find("property uint packed_scale"), 26, "property int  packed_scale");
  EXPECT_EQ(refusal(io::read_splat_ply, words), "packed_scale: must be of type uint");
  std::string alone = Packed(1).bytes();
  alone.replace(alone.find("element chunk"), 13, "element chunc");
  EXPECT_EQ(refusal(io::read_splat_ply, alone), "chunk: the file has no such element");
}

TEST(SplatContainersTest, EveryTruncationOfPackedPlyIsRefused) {
  const std::string whole = Packed(3).bytes();
  ASSERT_EQ(refusal(io::read_splat_ply, whole), "none");
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(refusal(io::read_splat_ply, whole.substr(0, size)), "none") << size;
}

}  // namespace
