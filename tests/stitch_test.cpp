// Crops of a frame that are rendered one by one and put together are the frame, byte for byte.
#include "splat/io/stitch_exr.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/io/image_file.h"
#include "tests/command.h"
#include "tests/noise_image.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using test::content_of;
using test::run_command;
using test::TemporaryFolder;

const std::string scene_text = R"({"swept": 1, "film": {"width": 150, "height": 90},
 "camera": {"fov": {"axis": "vertical", "degrees": 40},
            "keys": [{"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]}]},
 "objects": [{"source": {"generator": "sphere", "points": 3000},
              "transform": {"keys": [{"frame": 0, "translate": [-1, 0, 0]}, {"frame": 2, "translate": [1, 0, 0]}]}},
             {"source": {"generator": "plane", "points": 500},
              "transform": {"keys": [{"frame": 0, "translate": [0, 0, -2]}]}}]})";

/// A scene's frame in parts that cut through the cells in which errors are decided, and whole.
class Crops {
 public:
  Crops() { test::put(folder / "scene.json", scene_text); }

  [[nodiscard]] std::string file(const std::string& name) const { return folder / name; }

  test::Outcome render(const std::string& name, const std::string& options) const {
    return run_command(SWEPT_COMMAND " render '" + file("scene.json") + "' -o '" + file(name) + "' " +
                       options);
  }
  std::vector<std::string> render_parts(const std::string& options) const {
    std::vector<std::string> files;
    for (const char* crop : {"0,0,150,21", "61,21,89,40", "0,21,61,69", "61,61,89,29"}) {
      const std::string name = "part" + std::to_string(files.size()) + ".exr";
      const test::Outcome outcome = render(name, options + " --overwrite --crop " + crop);
      EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
      files.push_back(file(name));
    }
    return files;
  }

  const TemporaryFolder folder;
};

/// Deep images of `crops`, and the whole one.
std::vector<std::string> deep_parts(const Crops& crops, const std::string& options) {
  std::vector<std::string> files;
  const char* windows[] = {"--crop 0,0,150,21", "--crop 61,21,89,40", "--crop 0,21,61,69",
                           "--crop 61,61,89,29", ""};
  for (const char* window : windows) {
    files.push_back(crops.file("deep" + std::to_string(files.size()) + ".exr"));
    const test::Outcome outcome = crops.render(
        "flat.exr", options + " --overwrite --exact " + window + " --deep '" + files.back() + "'");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  return files;
}

TEST(Stitch, DeepPartsAreTheFrameByteForByte) {
  const Crops crops;
  for (const char* options : {"", "--half"}) {
    std::vector<std::string> parts = deep_parts(crops, options);
    const std::string whole = content_of(parts.back());
    parts.pop_back();
    std::swap(parts[0], parts[2]);
    Status stitched = stitch_exr(parts, crops.file("stitched.exr"));
    ASSERT_TRUE(stitched.ok()) << options << ": " << stitched.error().message();
    EXPECT_TRUE(content_of(crops.file("stitched.exr")) == whole) << options;
    // The same again where parts overlap.
    const std::string wide = crops.file("wide.exr");
    ASSERT_EQ(crops
                  .render("flat.exr", std::string(options) +
                                          " --overwrite --exact --crop 30,10,100,70 --deep '" + wide + "'")
                  .exit_code,
              0);
    parts.insert(parts.begin(), wide);
    stitched = stitch_exr(parts, crops.file("stitched.exr"));
    ASSERT_TRUE(stitched.ok()) << options << ": " << stitched.error().message();
    EXPECT_TRUE(content_of(crops.file("stitched.exr")) == whole) << options;
    std::filesystem::remove(wide);
  }
}

TEST(Stitch, DeepPartsThatDoNotFitAreRefused) {
  const Crops crops;
  std::vector<std::string> parts = deep_parts(crops, "--size 150x90");
  parts.pop_back();
  // One is missing, one is flat, one is of another method.
  std::vector<std::string> some(parts.begin(), parts.end() - 1);
  Status refused = stitch_exr(some, crops.file("stitched.exr"));
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().reason.find("--crop 61,61,89,29"), std::string::npos)
      << refused.error().message();
  ASSERT_EQ(crops.render("flat.exr", "--overwrite --exact --crop 61,61,89,29").exit_code, 0);
  some.push_back(crops.file("flat.exr"));
  refused = stitch_exr(some, crops.file("stitched.exr"));
  EXPECT_EQ(refused ? "" : refused.error().field, "type");
  // Another picture that says that it belongs to them.
  DeepImage other;
  other.width = 150;
  other.height = 90;
  other.film_width = 150;
  other.film_height = 90;
  other.first.resize(other.pixel_count() + 1);
  ImageMetadata metadata;
  metadata.whole_hash = "0123456789abcdef";
  metadata.method = "m";
  ASSERT_TRUE(write_deep_exr(crops.file("a.exr"), other, metadata).ok());
  for (std::size_t i = 4001; i < other.first.size(); ++i) other.first[i] = 1;
  other.rgba = {0.5f, 0.5f, 0.5f, 0.5f};
  other.depth = {1.0f, 1.0f};
  ASSERT_TRUE(write_deep_exr(crops.file("b.exr"), other, metadata).ok());
  refused = stitch_exr({crops.file("a.exr"), crops.file("b.exr")}, crops.file("stitched.exr"));
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().reason.find("at pixel 100, 26"), std::string::npos) << refused.error().message();
  EXPECT_TRUE(stitch_exr({crops.file("b.exr"), crops.file("b.exr")}, crops.file("stitched.exr")).ok());
  // A file that was cut off.
  std::filesystem::remove(crops.file("stitched.exr"));
  std::filesystem::resize_file(parts[2], std::filesystem::file_size(parts[2]) * 9 / 10);
  refused = stitch_exr(parts, crops.file("stitched.exr"));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().file, parts[2]);
  EXPECT_FALSE(std::filesystem::exists(crops.file("stitched.exr")));
}

TEST(Stitch, PartsAreTheFrameByteForByte) {
  const Crops crops;
  for (const std::string& options :
       {std::string("--max-error 60dB"), std::string("--max-error 45dB --layers normal,motion,samples,error"),
        std::string("--max-error 70dB --max-cell-error 50dB --half"), std::string("--exact"),
        std::string("--samples 5 --row-delay 0.001"), std::string("--method reference --samples 4")}) {
    std::vector<std::string> parts = crops.render_parts(options);
    ASSERT_EQ(crops.render("whole.exr", options + " --overwrite").exit_code, 0);
    std::swap(parts[0], parts[2]);
    const Status stitched = stitch_exr(parts, crops.file("stitched.exr"));
    ASSERT_TRUE(stitched.ok()) << options << ": " << stitched.error().message();
    EXPECT_TRUE(content_of(crops.file("stitched.exr")) == content_of(crops.file("whole.exr"))) << options;
  }
}

TEST(Stitch, WhatIsMissingIsNamedAsTheOptionHasIt) {
  const Crops crops;
  std::vector<std::string> parts = crops.render_parts("--samples 1");
  parts.erase(parts.begin() + 1);
  const Status refused = stitch_exr(parts, crops.file("stitched.exr"));
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().reason.find("--crop 61,21,89,40"), std::string::npos) << refused.error().reason;
  EXPECT_FALSE(std::filesystem::exists(crops.file("stitched.exr")));
  EXPECT_EQ(crops.render("part1.exr", "--samples 1 --overwrite --crop 61,21,89,40").exit_code, 0);
  parts.push_back(crops.file("part1.exr"));
  // Overlaps that agree are welcome.
  EXPECT_EQ(crops.render("more.exr", "--samples 1 --crop 30,10,100,70").exit_code, 0);
  parts.push_back(crops.file("more.exr"));
  EXPECT_TRUE(stitch_exr(parts, crops.file("stitched.exr")).ok());
  EXPECT_FALSE(stitch_exr(parts, crops.file("stitched.exr"), IfExists::fail).ok());
}

TEST(Stitch, PartsOfOtherFramesAreRefused) {
  const Crops crops;
  const std::vector<std::string> parts = crops.render_parts("--samples 1");
  const auto reason_with = [&](const std::string& options, const char* field) {
    EXPECT_EQ(crops.render("other.exr", options + " --overwrite --crop 0,0,150,21").exit_code, 0);
    std::vector<std::string> mixed = parts;
    mixed[0] = crops.file("other.exr");
    const Status refused = stitch_exr(mixed, crops.file("stitched.exr"));
    EXPECT_FALSE(refused.ok()) << options;
    EXPECT_EQ(refused ? "" : refused.error().field, field) << options;
  };
  reason_with("--samples 1 --frames 2", "wholeHash");
  reason_with("--samples 1 --background 1,0,0", "wholeHash");
  reason_with("--samples 3", "method");
  reason_with("--samples 1 --half", "method");
  // One that says that it belongs to them, and is another picture.
  Image noise = test::noise(0, 0, 150, 22, 150, 90);
  noise.depth.assign(noise.pixel_count(), 1.0f);
  ImageMetadata metadata;
  metadata.whole_hash = "0123456789abcdef";
  metadata.method = "m";
  ASSERT_TRUE(write_exr(crops.file("a.exr"), noise, metadata).ok());
  noise.y = 21;
  noise.height = 69;
  noise.rgba.assign(4 * noise.pixel_count(), 0.5f);
  noise.depth.assign(noise.pixel_count(), 1.0f);
  ASSERT_TRUE(write_exr(crops.file("b.exr"), noise, metadata).ok());
  Status refused = stitch_exr({crops.file("a.exr"), crops.file("b.exr")}, crops.file("stitched.exr"));
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().reason.find("0, 21"), std::string::npos) << refused.error().message();
  // Another's files, no files at all, and files that are not whole.
  ASSERT_TRUE(write_exr(crops.file("plain.exr"), noise).ok());
  EXPECT_EQ(stitch_exr({crops.file("plain.exr")}, crops.file("stitched.exr")).error().field, "wholeHash");
  EXPECT_FALSE(stitch_exr({}, crops.file("stitched.exr")).ok());
  EXPECT_EQ(stitch_exr({crops.file("none.exr")}, crops.file("stitched.exr")).error().kind,
            ErrorKind::not_found);
  std::filesystem::resize_file(parts[0], std::filesystem::file_size(parts[0]) / 2);
  refused = stitch_exr(parts, crops.file("stitched.exr"));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().file, parts[0]);
  EXPECT_FALSE(std::filesystem::exists(crops.file("stitched.exr")));
}

TEST(StitchCommand, StripsByNumberAreTheFrame) {
  const Crops crops;
  std::string parts;
  for (int i = 1; i <= 7; ++i) {
    const std::string name = "strip" + std::to_string(i) + ".exr";
    ASSERT_EQ(crops.render(name, "--part " + std::to_string(i) + "/7").exit_code, 0);
    parts += " '" + crops.file(name) + "'";
  }
  ASSERT_EQ(
      run_command(SWEPT_COMMAND " stitch" + parts + " -o '" + crops.file("stitched.exr") + "'").exit_code, 0);
  ASSERT_EQ(crops.render("whole.exr", "").exit_code, 0);
  EXPECT_TRUE(content_of(crops.file("stitched.exr")) == content_of(crops.file("whole.exr")));
  for (const char* wrong : {"0/7", "8/7", "1", "1/7x", "a/b"})
    EXPECT_EQ(crops.render("no.exr", std::string("--part ") + wrong).exit_code, 2) << wrong;
  EXPECT_EQ(crops.render("no.exr", "--part 1/91").exit_code, 2) << "a strip of no row";
  EXPECT_EQ(crops.render("no.exr", "--part 1/2 --crop 0,0,10,10").exit_code, 2);
  EXPECT_EQ(crops.render("no.exr", "--part 1/2 --overscan 1,1,1,1").exit_code, 2);
}

TEST(StitchCommand, WritesOnceAndNeverOverAPart) {
  const Crops crops;
  std::string parts;
  for (const std::string& part : crops.render_parts("--samples 1")) parts += " '" + part + "'";
  const std::string command = SWEPT_COMMAND " stitch" + parts + " -o '" + crops.file("whole.exr") + "'";
  test::Outcome outcome = run_command(command);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(run_command(command).exit_code, 1) << "it exists";
  EXPECT_EQ(run_command(command + " --overwrite").exit_code, 0);
  outcome =
      run_command(SWEPT_COMMAND " stitch" + parts + " -o '" + crops.file("part0.exr") + "' --overwrite");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("one of the parts"), std::string::npos) << outcome.err;
  EXPECT_EQ(run_command(SWEPT_COMMAND " stitch" + parts + " -o whole.png").exit_code, 2);
  // The frame knows what it is: a run that goes on leaves it as it is.
  EXPECT_EQ(crops.render("whole.exr", "--samples 1 --skip-existing").exit_code, 0);
}

}  // namespace
}  // namespace swept
