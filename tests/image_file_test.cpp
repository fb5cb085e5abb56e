// What all writers of files promise, and previews as PNG.
#include "splat/io/image_file.h"

#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <png.h>

#include "splat/io/atomic_file.h"
#include "tests/noise_image.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using test::content_of;
using test::noise;
using test::put;
using test::TemporaryFolder;

TEST(AtomicFile, AppearsOnlyWhenCommitted) {
  const TemporaryFolder folder;
  put(folder / "file", "old");
  {
    Result<AtomicFile> file = AtomicFile::create(folder / "file");
    ASSERT_TRUE(file.ok());
    std::fputs("new", file->stream());
    EXPECT_EQ(content_of(folder / "file"), "old");
    EXPECT_EQ(folder.names().size(), 2u);
  }
  EXPECT_EQ(content_of(folder / "file"), "old");
  EXPECT_EQ(folder.names().size(), 1u);
  ASSERT_TRUE(write_file(folder / "file", "new").ok());
  EXPECT_EQ(content_of(folder / "file"), "new");
  EXPECT_EQ(folder.names().size(), 1u);
}

TEST(AtomicFile, TwoWritersOfOnePathDoNotShareATemporary) {
  const TemporaryFolder folder;
  Result<AtomicFile> first = AtomicFile::create(folder / "file"),
                     second = AtomicFile::create(folder / "file");
  ASSERT_TRUE(first.ok() && second.ok());
  std::fputs("first", first->stream());
  std::fputs("second", second->stream());
  ASSERT_TRUE(first->commit().ok());
  EXPECT_EQ(content_of(folder / "file"), "first");
  *first = std::move(*second);
  ASSERT_TRUE(first->commit().ok());
  EXPECT_EQ(content_of(folder / "file"), "second");
  EXPECT_EQ(folder.names().size(), 1u);
}

/// Each writer of this target, by name.
using Writer = Status (*)(const std::string&);
const std::pair<const char*, Writer> kWriters[] = {
    {"exr", [](const std::string& path) { return write_exr(path, noise(0, 0, 64, 64, 64, 64)); }},
    {"png", [](const std::string& path) { return write_png(path, noise(0, 0, 64, 64, 64, 64)); }},
    {"text", [](const std::string& path) { return write_file(path, std::string(100000, 'x')); }},
};

TEST(Writers, AFolderThatCannotBeWrittenIsAnError) {
  const TemporaryFolder folder;
  put(folder / "file", "");
  for (const auto& [name, write] : kWriters) {
    for (const std::string& path : {folder / "file/image", folder / "missing/image", std::string()}) {
      const Status status = write(path);
      ASSERT_FALSE(status.ok()) << name << " " << path;
      EXPECT_EQ(status.error().file, path) << name;
    }
  }
  EXPECT_EQ(folder.names(), std::set<std::string>{"file"});
}

TEST(Writers, AFolderInTheWayIsAnErrorAndLeavesNothing) {
  const TemporaryFolder folder;
  ASSERT_TRUE(std::filesystem::create_directory(folder / "image"));
  for (const auto& [name, write] : kWriters) {
    const Status status = write(folder / "image");
    ASSERT_FALSE(status.ok()) << name;
    EXPECT_EQ(status.error().file, folder / "image") << name;
    EXPECT_EQ(folder.names(), std::set<std::string>{"image"}) << name;
  }
}

TEST(Writers, AFullDiskIsAnErrorAndKeepsTheOldFile) {
  const TemporaryFolder folder;
  put(folder / "image", "old");
  // The kernel refuses to let a file grow past the limit, as a full disk does.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  for (const auto& [name, write] : kWriters) {
    const rlimit tight{6000, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
    const Status status = write(folder / "image");
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    ASSERT_FALSE(status.ok()) << name;
    EXPECT_EQ(status.error().file, folder / "image") << name;
    EXPECT_EQ(content_of(folder / "image"), "old") << name;
    EXPECT_EQ(folder.names(), std::set<std::string>{"image"}) << name;
  }
  std::signal(SIGXFSZ, handler);
}

/// The bytes as the file has them.
std::vector<std::uint8_t> png_bytes(const std::string& path, int width, int height) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&header, path.c_str()), 0) << header.message;
  EXPECT_EQ(header.format, PNG_FORMAT_RGBA);
  EXPECT_EQ(header.width, static_cast<png_uint_32>(width));
  EXPECT_EQ(header.height, static_cast<png_uint_32>(height));
  std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(header));
  EXPECT_NE(png_image_finish_read(&header, nullptr, bytes.data(), 0, nullptr), 0) << header.message;
  return bytes;
}

TEST(WritePng, EveryLevelOfSrgbIsHit) {
  const TemporaryFolder folder;
  Image image{0, 0, 256, 1, 256, 1, {}, {}};
  std::vector<std::uint8_t> expected;
  for (int level = 0; level < 256; ++level) {
    // The inverse transfer of IEC 61966-2-1, premultiplied by an alpha that division undoes.
    const double encoded = level / 255.0;
    const double linear = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
    const int alpha = 1 + level % 255;
    for (int c = 0; c < 3; ++c) {
      image.rgba.push_back(static_cast<float>(linear * alpha / 255.0));
      expected.push_back(static_cast<std::uint8_t>(level));
    }
    image.rgba.push_back(static_cast<float>(alpha / 255.0));
    expected.push_back(static_cast<std::uint8_t>(alpha));
  }
  ASSERT_TRUE(write_png(folder / "image.png", image).ok());
  EXPECT_EQ(png_bytes(folder / "image.png", 256, 1), expected);
  EXPECT_NE(content_of(folder / "image.png").find("sRGB"), std::string::npos) << "no sRGB chunk";
}

TEST(WritePng, WritesTheCropAndClipsWhatAScreenCannotShow) {
  const TemporaryFolder folder;
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  const Image image{40,
                    30,
                    2,
                    2,
                    100,
                    50,
                    {
                        2.0f,
                        0.5f,
                        -1.0f,
                        1.0f,  // over and under
                        nan,
                        inf,
                        1.0f,
                        2.0f,  // 2: alpha clips first
                        0.25f,
                        1.0f,
                        1.0f,
                        0.0f,  // light without coverage
                        1.0f,
                        1.0f,
                        1.0f,
                        nan,
                    },
                    {}};
  ASSERT_TRUE(write_png(folder / "image.png", image).ok());
  // 1.055 · 0.5^(1/2.4) − 0.055 = 0.7354 = 187.5/255 + 0.0001
  const std::vector<std::uint8_t> expected = {255, 188, 0, 255, 0, 255, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(png_bytes(folder / "image.png", 2, 2), expected);
}

}  // namespace
}  // namespace swept
