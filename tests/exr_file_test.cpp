// OpenEXR in and out, and files of others.
#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <ImathMatrix.h>
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfDoubleAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfRational.h>
#include <ImfRgbaFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTiledRgbaFile.h>
#include <gtest/gtest.h>

#include "splat/io/image_file.h"
#include "tests/noise_image.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using test::content_of;
using test::noise;
using test::put;
using test::TemporaryFolder;

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float x, float y) {
    return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y);
  });
}

void expect_same(const Image& a, const Image& b) {
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.film_width, b.film_width);
  EXPECT_EQ(a.film_height, b.film_height);
  EXPECT_TRUE(same_bits(a.rgba, b.rgba));
  EXPECT_TRUE(same_bits(a.depth, b.depth));
}

TEST(WriteExr, KeepsEveryBitOfACrop) {
  const TemporaryFolder folder;
  Image image = noise(5, 3, 37, 70, 64, 80);  // more rows than the reader takes in one strip
  const float inf = std::numeric_limits<float>::infinity();
  const float odd[] = {inf, -inf, std::nanf("1"), -0.0f, 1e-45f, -3.5f, 3.4e38f};
  std::copy(std::begin(odd), std::end(odd), image.rgba.begin() + 11);
  image.depth[0] = inf;
  ASSERT_TRUE(write_exr(folder / "image.exr", image).ok());
  const Result<Image> read = read_exr(folder / "image.exr");
  ASSERT_TRUE(read.ok()) << read.error().message();
  expect_same(*read, image);
  EXPECT_EQ(folder.names(), std::set<std::string>{"image.exr"});
}

TEST(WriteExr, LeavesOutDepthThatIsNotThere) {
  const TemporaryFolder folder;
  Image image = noise(-2, -1, 9, 5, 4, 4);  // overscan on every side
  image.depth.clear();
  ASSERT_TRUE(write_exr(folder / "image.exr", image).ok());
  const Result<Image> read = read_exr(folder / "image.exr");
  ASSERT_TRUE(read.ok()) << read.error().message();
  expect_same(*read, image);
}

TEST(WriteExr, HalfKeepsElevenBitsOfColourAndAllOfDepth) {
  const TemporaryFolder folder;
  const Image image = noise(0, 0, 64, 64, 64, 64);
  ASSERT_TRUE(write_exr(folder / "image.exr", image, {}, ExrPixels::float16).ok());
  const Result<Image> read = read_exr(folder / "image.exr");
  ASSERT_TRUE(read.ok()) << read.error().message();
  EXPECT_TRUE(same_bits(read->depth, image.depth));
  bool rounded = false;
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    // Rounding to nearest: half a unit in the 11th digit, or of the subnormals' spacing of 2⁻²⁴.
    const float bound = std::max(image.rgba[i] * 0x1p-11f, 0x1p-25f);
    EXPECT_LE(std::abs(read->rgba[i] - image.rgba[i]), bound);
    rounded |= read->rgba[i] != image.rgba[i];
  }
  EXPECT_TRUE(rounded) << "the file holds more than half floats";
}

TEST(WriteExr, SameImageSameBytes) {
  const TemporaryFolder folder;
  const Image image = noise(0, 0, 50, 40, 50, 40);
  ASSERT_TRUE(write_exr(folder / "a.exr", image).ok());
  ASSERT_TRUE(write_exr(folder / "b.exr", image).ok());
  EXPECT_EQ(content_of(folder / "a.exr"), content_of(folder / "b.exr"));
}

TEST(WriteExr, HeaderSaysHowTheImageCameToBe) {
  const TemporaryFolder folder;
  ImageMetadata metadata;
  metadata.fps_numerator = 24000;
  metadata.fps_denominator = 1001;
  metadata.exposure_seconds = 0.03125;
  metadata.shutter_open = -0.25;
  metadata.shutter_close = 0.5;
  metadata.world_to_camera << 0, 1, 0, 2, -1, 0, 0, 3, 0, 0, 1, 4, 0, 0, 0, 1;
  metadata.scene_hash = "0123abcd";
  metadata.method = "abuffer";
  metadata.software = "swept 1.2.3";
  ASSERT_TRUE(write_exr(folder / "image.exr", noise(3, 2, 4, 5, 20, 10), metadata).ok());

  const Imf::InputFile file((folder / "image.exr").c_str());
  const Imf::Header& header = file.header();
  EXPECT_EQ(header.displayWindow(), Imath::Box2i({0, 0}, {19, 9}));
  EXPECT_EQ(header.dataWindow(), Imath::Box2i({3, 2}, {6, 6}));
  EXPECT_EQ(header.compression(), Imf::ZIP_COMPRESSION);
  EXPECT_EQ(Imf::framesPerSecond(header).n, 24000);
  EXPECT_EQ(Imf::framesPerSecond(header).d, 1001u);
  EXPECT_EQ(Imf::expTime(header), 0.03125f);
  EXPECT_EQ(header.typedAttribute<Imf::FloatAttribute>("shutterAngle").value(), 270.0f);
  EXPECT_EQ(header.typedAttribute<Imf::DoubleAttribute>("shutterOpen").value(), -0.25);
  EXPECT_EQ(header.typedAttribute<Imf::DoubleAttribute>("shutterClose").value(), 0.5);
  EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("sceneHash").value(), "0123abcd");
  EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("software").value(), "swept 1.2.3");
  EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("method").value(), "abuffer");
  // ITU-R BT.709: the primaries and D65.
  const Imf::Chromaticities& primaries = Imf::chromaticities(header);
  EXPECT_EQ(primaries.red, Imath::V2f(0.64f, 0.33f));
  EXPECT_EQ(primaries.green, Imath::V2f(0.30f, 0.60f));
  EXPECT_EQ(primaries.blue, Imath::V2f(0.15f, 0.06f));
  EXPECT_EQ(primaries.white, Imath::V2f(0.3127f, 0.3290f));
  // Row vectors: Imath's own product takes the world point where the column-vector matrix does.
  EXPECT_EQ(Imath::V3f(5, 6, 7) * Imf::worldToCamera(header), Imath::V3f(6 + 2, -(-5 + 3), 7 + 4));
}

TEST(WriteExr, RefusesWhatDoesNotFit) {
  const TemporaryFolder folder;
  const auto field_of = [&](const Image& image, const ImageMetadata& metadata) {
    const Status exr = write_exr(folder / "image.exr", image, metadata);
    return exr.ok() ? "written" : exr.error().field;
  };
  Image image = noise(0, 0, 4, 4, 4, 4);
  ASSERT_EQ(field_of(image, {}), "written");
  ASSERT_TRUE(std::filesystem::remove(folder / "image.exr"));

  Image bad = image;
  bad.rgba.pop_back();
  EXPECT_EQ(field_of(bad, {}), "rgba");
  EXPECT_EQ(write_png(folder / "image.png", bad).error().field, "rgba");
  bad = image;
  bad.depth.push_back(0);
  EXPECT_EQ(field_of(bad, {}), "depth");
  bad = image;
  bad.width = 0;
  EXPECT_EQ(field_of(bad, {}), "width, height");
  bad = image;
  bad.film_height = -1;
  EXPECT_EQ(field_of(bad, {}), "film_width, film_height");
  bad = image;
  bad.x = std::numeric_limits<int>::max() - 2;
  EXPECT_EQ(field_of(bad, {}), "x, y");

  const double nan = std::nan("");
  ImageMetadata metadata;
  metadata.fps_denominator = 0;
  EXPECT_EQ(field_of(image, metadata), "fps");
  metadata = {};
  metadata.exposure_seconds = nan;
  EXPECT_EQ(field_of(image, metadata), "exposure_seconds");
  metadata = {};
  metadata.shutter_open = 1;
  EXPECT_EQ(field_of(image, metadata), "shutter");
  metadata = {};
  metadata.world_to_camera(1, 2) = nan;
  EXPECT_EQ(field_of(image, metadata), "world_to_camera");
  EXPECT_TRUE(folder.names().empty());
}

TEST(ReadExr, ReadsScanLinesAndTilesOfOthers) {
  const TemporaryFolder folder;
  // Windows that start anywhere, half floats, no alpha, another compression.
  const Imath::Box2i display({10, 20}, {109, 219}), data({12, 15}, {81, 164});
  const int width = 70, height = 150;
  std::vector<Imf::Rgba> pixels;
  for (int i = 0; i < width * height; ++i) {
    pixels.emplace_back(0.25f * static_cast<float>(i % 7), static_cast<float>(i / width), -1.0f, 0.5f);
  }
  const Imf::Rgba* base = pixels.data() - 12 - 15 * width;
  {
    Imf::Header header(display, data, 1, {0, 0}, 1, Imf::INCREASING_Y, Imf::PIZ_COMPRESSION);
    Imf::RgbaOutputFile scan_lines((folder / "scan.exr").c_str(), header, Imf::WRITE_RGB);
    scan_lines.setFrameBuffer(base, 1, width);
    scan_lines.writePixels(height);
    Imf::TiledRgbaOutputFile tiles((folder / "tiles.exr").c_str(), header, Imf::WRITE_RGBA, 32, 24,
                                   Imf::ONE_LEVEL);
    tiles.setFrameBuffer(base, 1, width);
    tiles.writeTiles(0, tiles.numXTiles() - 1, 0, tiles.numYTiles() - 1);
  }
  for (const auto& [name, alpha] : {std::pair{"scan.exr", 1.0f}, {"tiles.exr", 0.5f}}) {
    SCOPED_TRACE(name);
    const Result<Image> read = read_exr(folder / name);
    ASSERT_TRUE(read.ok()) << read.error().message();
    EXPECT_EQ(read->x, 2);
    EXPECT_EQ(read->y, -5);
    EXPECT_EQ(read->width, width);
    EXPECT_EQ(read->height, height);
    EXPECT_EQ(read->film_width, 100);
    EXPECT_EQ(read->film_height, 200);
    EXPECT_TRUE(read->depth.empty());
    for (int i = 0; i < width * height; ++i) {
      const float* rgba = &read->rgba[4 * static_cast<std::size_t>(i)];
      ASSERT_EQ(rgba[0], 0.25f * static_cast<float>(i % 7)) << i;
      ASSERT_EQ(rgba[1], static_cast<float>(i / width)) << i;
      ASSERT_EQ(rgba[2], -1.0f) << i;
      ASSERT_EQ(rgba[3], alpha) << i;
    }
  }
}

TEST(ReadExr, NamesTheChannelThatIsMissing) {
  const TemporaryFolder folder;
  {
    Imf::Header header(4, 4);
    Imf::RgbaOutputFile file((folder / "grey.exr").c_str(), header, Imf::WRITE_YA);
    const std::vector<Imf::Rgba> pixels(16);
    file.setFrameBuffer(pixels.data(), 1, 4);
    file.writePixels(4);
  }
  const Result<Image> read = read_exr(folder / "grey.exr");
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().field, "R");
  EXPECT_NE(read.error().reason.find("A, Y"), std::string::npos) << read.error().reason;
}

TEST(ReadExr, ErrorsNameTheFile) {
  const TemporaryFolder folder;
  put(folder / "empty.exr", "");
  put(folder / "text.exr", "This is not the image you are looking for, however long it goes on.");
  for (const std::string& path :
       {folder / "missing.exr", folder / "empty.exr", folder / "text.exr", folder / ""}) {
    const Result<Image> read = read_exr(path);
    ASSERT_FALSE(read.ok()) << path;
    EXPECT_EQ(read.error().file, path);
    EXPECT_FALSE(read.error().reason.empty()) << path;
  }
}

TEST(ReadExr, ATruncatedFileIsAnError) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_exr(folder / "whole.exr", noise(1, 1, 12, 20, 30, 30)).ok());
  const std::string whole = content_of(folder / "whole.exr");
  const auto try_length = [&](std::size_t length) {
    put(folder / "cut.exr", whole.substr(0, length));
    EXPECT_FALSE(read_exr(folder / "cut.exr").ok()) << length << " of " << whole.size() << " bytes";
  };
  for (std::size_t length = 0; length < whole.size(); length += 11) try_length(length);
  try_length(whole.size() - 1);
}

TEST(ReadExr, ADamagedByteGivesAnImageOrAnError) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_exr(folder / "whole.exr", noise(1, 1, 3, 20, 30, 30)).ok());
  const std::string whole = content_of(folder / "whole.exr");
  constexpr unsigned char kDamage[] = {0x01, 0x80, 0xff};
  std::size_t refused = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) ^ kDamage[at % 3]);
    put(folder / "damaged.exr", damaged);
    const Result<Image> read = read_exr(folder / "damaged.exr");
    if (read.ok()) {
      EXPECT_TRUE(read->validate().ok()) << "byte " << at;
    } else {
      EXPECT_EQ(read.error().file, folder / "damaged.exr");
      ++refused;
    }
  }
  // Magic number, version, names and types of the attributes that must be there: these cannot go unseen.
  EXPECT_GT(refused, 100u);
}

TEST(ReadExr, AHeaderThatPromisesTooMuchCostsNothing) {
  const TemporaryFolder folder;
  const Image image = noise(0, 0, 6, 20, 30, 30);
  ASSERT_TRUE(write_exr(folder / "honest.exr", image).ok());
  const std::string honest = content_of(folder / "honest.exr");
  const std::string tag("dataWindow\0box2i\0\x10\0\0\0", 21);
  const std::size_t window = honest.find(tag);
  ASSERT_NE(window, std::string::npos);
  for (const auto& [x, y] : {std::pair{2000000000, 19},
                             {5, 2000000000},
                             {60000, 60000},
                             {2000000000, 2000000000},
                             {-7, 19},
                             {0x7fffffff, 0x7fffffff}}) {
    std::string lying = honest;
    std::memcpy(&lying[window + tag.size() + 8], &x, 4);
    std::memcpy(&lying[window + tag.size() + 12], &y, 4);
    put(folder / "lying.exr", lying);
    const Result<Image> read = read_exr(folder / "lying.exr");
    EXPECT_FALSE(read.ok()) << x << ", " << y;
  }
  // An honest window for one of OpenEXR's readers, and another for the other.
  std::string twice = honest;
  std::string second = honest.substr(window, tag.size() + 16);
  const int x = 500000000;
  std::memcpy(&second[tag.size() + 8], &x, 4);
  twice.insert(window + second.size(), second);
  put(folder / "twice.exr", twice);
  const Result<Image> read = read_exr(folder / "twice.exr");
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().field, "dataWindow");
  // The largest honest reading of the file is 64 MiB; the process itself takes far less than the rest.
  rusage usage{};
  ASSERT_EQ(getrusage(RUSAGE_SELF, &usage), 0);
  EXPECT_LT(usage.ru_maxrss, 512 * 1024) << "KiB";
}

}  // namespace
}  // namespace swept
