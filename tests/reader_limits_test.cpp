// Headers that are long or lie: work in proportion to the file, and refused before memory is taken.
#include <sys/resource.h>

#include <ctime>
#include <filesystem>

#include "splat/io/image_file.h"
#include "splat/io/point_file.h"
#include "tests/point_files.h"

namespace {

using namespace swept;

using ReaderLimitsTest = swept_test::PointFiles;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// `count` lines of one kind before what a PLY file needs.
std::string long_header(int count, const std::string& before, const std::string& after) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  for (int i = 0; i < count; ++i) text += before + std::to_string(i) + after + "\n";
  return text + "end_header\n1 2 3\n";
}

TEST_F(ReaderLimitsTest, LinesOfAPlyHeaderCostTheSameEach) {
  constexpr int many = 150'000;
  std::string row = "1 2 3";
  for (int i = 0; i < many; ++i) row += " 0";
  const std::string properties = long_header(many, "property uchar p", "");
  const std::vector<std::pair<std::string, std::string>> files{
      {"e.ply", long_header(many, "element e", " 0")},
      {"p.ply", properties.substr(0, properties.rfind("1 2 3")) + row + "\n"},
      {"ep.ply", long_header(many, "element e", " 0\nproperty int a")},
      {"c.ply", long_header(many, "comment ", "")},
  };
  for (const auto& [name, bytes] : files) {
    const std::string path = write(name, bytes);
    const double start = cpu_seconds();
    const Result<PointSet> set = read_points(path);
    const double seconds = cpu_seconds() - start;
    ASSERT_TRUE(set.ok()) << name << ": " << set.error().message();
    // A look at every line before for each line took 32 s; a look at a table takes 0.2.
    EXPECT_LT(seconds, 5.0) << name;
  }
  // The last of many is still told from the first.
  std::string twice = long_header(many, "element e", " 0");
  twice.insert(twice.find("end_header"), "element e7 0\n");
  const Result<PointSet> refused = read_points(write("t.ply", twice));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "e7");
}

TEST_F(ReaderLimitsTest, ManyColumnsOfTextAndFieldsOfPcd) {
  constexpr int many = 150'000;
  std::string names = "x y z", numbers = "1 2 3", fours, floats;
  for (int i = 0; i < many; ++i) {
    names += " c" + std::to_string(i);
    numbers += " 0";
  }
  for (int i = 0; i < many + 3; ++i) {
    fours += " 4";
    floats += " F";
  }
  const double start = cpu_seconds();
  const Result<PointSet> text = read_points(write("w.txt", names + "\n" + numbers + "\n"));
  ASSERT_TRUE(text.ok()) << text.error().message();
  const Result<PointSet> pcd =
      read_points(write("w.pcd", "FIELDS " + names + "\nSIZE" + fours + "\nTYPE" + floats +
                                     "\nPOINTS 1\nDATA ascii\n" + numbers + "\n"));
  ASSERT_TRUE(pcd.ok()) << pcd.error().message();
  EXPECT_LT(cpu_seconds() - start, 5.0);
  EXPECT_EQ(text->report.unread.size(), static_cast<std::size_t>(many));
  // A row of millions is no point.
  std::string row;
  for (int i = 0; i < 2'000'000; ++i) row += "0 ";
  const Result<PointSet> wide = read_points(write("r.txt", row));
  ASSERT_FALSE(wide.ok());
  EXPECT_EQ(wide.error().field, "line 1");
  ReadOptions options;
  options.attributes = {{"position", "3,2,1"}};
  EXPECT_FALSE(read_points(write("r.txt", row), options).ok());
}

TEST_F(ReaderLimitsTest, HeadersThatPromiseTooMuchTakeNoMemory) {
  rusage before{};
  ASSERT_EQ(getrusage(RUSAGE_SELF, &before), 0);
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"a.ply",
            "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
            "property float y\nproperty float z\nend_header\n0123"},
           {"b.ply",
            "ply\nformat ascii 1.0\nelement junk 4000000000\nproperty list uchar float a\nend_header\n0"},
           {"c.off", "COFF 4000000000 4000000000 0\n0 0 0\n"},
           {"d.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n"},
           {"e.pts", "4000000000\n1 2 3\n"},
           {"f.obj", "v 0 0 0\nf 4000000000 1 1\n"},
           {"g.pcd",
            "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 4000000000\nHEIGHT 1\nDATA binary\n0123"}}) {
    EXPECT_FALSE(read_points(write(name, bytes)).ok()) << name;
  }
  rusage after{};
  ASSERT_EQ(getrusage(RUSAGE_SELF, &after), 0);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 64 * 1024) << "KiB";
}

TEST_F(ReaderLimitsTest, ASparseFileBeyondAllMemoryIsRefused) {
  const std::string path = write("s.ply", "ply\n");
  std::error_code code;
  std::filesystem::resize_file(path, std::uintmax_t{1} << 43, code);
  if (code) GTEST_SKIP() << "the file system holds no sparse file of 8 TiB";
  const Result<PointSet> set = read_points(path);
  ASSERT_FALSE(set.ok());
  EXPECT_NE(set.error().reason.find("memory"), std::string::npos) << set.error().reason;
}

TEST_F(ReaderLimitsTest, AttributesOfAnImageAreCountedBeforeTheyAreSorted) {
  Image image{0, 0, 4, 4, 4, 4, {}, {}};
  image.rgba.assign(4 * image.pixel_count(), 0.5f);
  ASSERT_TRUE(write_exr(folder_ / "s.exr", image).ok());
  const std::string plain = swept::test::content_of(folder_ / "s.exr");
  constexpr std::size_t magic_and_version = 8;
  const auto with_attributes = [&](int count) {
    std::string attributes;
    // In falling order, the worst for a list that is kept sorted.
    for (int i = count; i > 0; --i) {
      std::string number = std::to_string(i);
      number.insert(0, 7 - number.size(), '0');
      attributes += "a" + number + std::string("\0int\0\4\0\0\0\0\0\0\0", 13);
    }
    return plain.substr(0, magic_and_version) + attributes + plain.substr(magic_and_version);
  };
  EXPECT_TRUE(read_exr_window(write("few.exr", with_attributes(4000))).ok());
  const double start = cpu_seconds();
  const Result<Image> many = read_exr_window(write("many.exr", with_attributes(200'000)));
  EXPECT_LT(cpu_seconds() - start, 5.0);  // 84 s where they were sorted first
  ASSERT_FALSE(many.ok());
  EXPECT_NE(many.error().reason.find("attributes"), std::string::npos) << many.error().reason;
}

TEST_F(ReaderLimitsTest, TheWindowOfAnImageComesWithoutItsPixels) {
  // Black packs to nothing: the pixels would take 64 MiB.
  Image image{2, 1, 2048, 2048, 5000, 4200, {}, {}};
  image.rgba.assign(4 * image.pixel_count(), 0.0f);
  ASSERT_TRUE(write_exr(folder_ / "b.exr", image).ok());
  image = Image{};
  const double start = cpu_seconds();
  const Result<Image> window = read_exr_window(folder_ / "b.exr");
  EXPECT_LT(cpu_seconds() - start, 1.0);
  ASSERT_TRUE(window.ok()) << window.error().message();
  EXPECT_EQ(window->x, 2);
  EXPECT_EQ(window->height, 2048);
  EXPECT_EQ(window->film_width, 5000);
  EXPECT_TRUE(window->rgba.empty());
  EXPECT_FALSE(read_exr_window(write("n.exr", "no image")).ok());
  EXPECT_FALSE(read_exr_window(folder_ / "absent.exr").ok());
}

}  // namespace
