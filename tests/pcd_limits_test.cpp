// PCD files that are small and would take much memory: refused before they do.
#include <sys/resource.h>

#include <cstdint>
#include <cstring>

#include "splat/io/point_file.h"
#include "tests/point_files.h"

namespace {

using namespace swept;

using PcdLimitsTest = swept_test::PointFiles;

constexpr std::size_t kMiB = std::size_t{1} << 20;

std::string u32(std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  std::string bytes(sizeof word, '\0');
  std::memcpy(bytes.data(), &word, sizeof word);
  return bytes;
}

/// `count` zeros in as few bytes of LZF as can be: one as it is, then 264 in every three bytes.
std::string packed_zeros(std::size_t count) {
  const std::string one(2, '\0'), many{'\xe0', '\xff', '\0'};
  std::string packed = one;
  std::size_t left = count - 1;
  for (; left >= 264; left -= 264) packed += many;
  for (; left > 0; --left) packed += one;
  return packed;
}

/// Points of x y z, all at the origin.
std::string pcd_of_zeros(std::size_t points, const std::string& packed) {
  const std::string count = std::to_string(points);
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS " + count + "\nDATA binary_compressed\n" +
         u32(packed.size()) + u32(12 * points) + packed;
}

/// The most memory this process has held so far.
std::size_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

TEST_F(PcdLimitsTest, SmallFilesMayUnpackToWhatTheyLike) {
  const std::size_t points = 100'000;
  const std::string packed = packed_zeros(12 * points);
  EXPECT_GT(12 * points, 80 * packed.size());
  const Result<PointSet> set = read_points(write("zeros.pcd", pcd_of_zeros(points, packed)));
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_EQ(set->size(), points);
  EXPECT_EQ(set->position.back(), Eigen::Vector3d::Zero());
}

TEST_F(PcdLimitsTest, LargeOnesThatUnpackToFarMoreThanPointsDoAreRefusedAtOnce) {
  // 7 MB that are 616 MB of points, which as doubles are twice as many again, twice over.
  const std::size_t points = 51'000'000;
  const std::string path = write("bomb.pcd", pcd_of_zeros(points, packed_zeros(12 * points)));
  const std::size_t before = peak_bytes();
  const Result<PointSet> set = read_points(path);
  ASSERT_FALSE(set.ok());
  EXPECT_EQ(set.error().field, "DATA");
  EXPECT_NE(set.error().reason.find("write them with DATA binary"), std::string::npos) << set.error().reason;
  EXPECT_LT(peak_bytes() - before, 32 * kMiB);
}

TEST_F(PcdLimitsTest, TheLimitIsSixteenToOneBeyond64MiB) {
  const std::size_t points = 64 * kMiB / 12 + 1;
  const std::size_t packed = (12 * points) / 16;
  // As long as the limit asks for: refused for what is in it, or one byte less for how much.
  const auto reason = [&](std::size_t bytes) {
    const Result<PointSet> set =
        read_points(write("limit.pcd", pcd_of_zeros(points, std::string(bytes, '\xff'))));
    return set.ok() ? "" : set.error().reason;
  };
  EXPECT_NE(reason(packed).find("damaged"), std::string::npos) << reason(packed);
  EXPECT_NE(reason(packed - 1).find("would unpack"), std::string::npos) << reason(packed - 1);
}

TEST_F(PcdLimitsTest, EndlessHeaders) {
  std::string fields = "FIELDS", lines;
  while (fields.size() < 16 * kMiB) fields += " a";
  while (lines.size() < 16 * kMiB) (lines += std::to_string(lines.size())) += "k\n";
  const std::string as_fields = write("fields.pcd", fields + "\nDATA ascii\n1 2 3\n");
  const std::string as_lines = write("lines.pcd", lines + "\nDATA ascii\n1 2 3\n");
  const std::size_t before = peak_bytes();
  for (const std::string& path : {as_fields, as_lines}) {
    const Result<PointSet> set = read_points(path);
    ASSERT_FALSE(set.ok());
    EXPECT_EQ(set.error().field, "DATA");
    EXPECT_NE(set.error().reason.find("within 4 MiB"), std::string::npos) << set.error().reason;
  }
  EXPECT_LT(peak_bytes() - before, 48 * kMiB);
}

}  // namespace
