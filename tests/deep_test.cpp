// Samples by depth: they flatten to the picture, are tidy, and tell what is covered in front of a depth.
#include "splat/deep_image.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepImageStateAttribute.h>
#include <ImfDeepScanLineInputFile.h>
#include <ImfHeader.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "splat/io/image_file.h"
#include "tests/command.h"
#include "tests/deep_flattened.h"
#include "tests/small_scenes.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using test::flattened_error;
using test::render_deep;
using test::run_command;
using test::TemporaryFolder;

constexpr double rounding = test::deep_rounding;

TEST(Deep, ObeysMaxBytes) {
  const Scene scene = test::busy_scene();
  const Rendered deep = render_deep(scene);
  // Parts and pixels while they are gathered take more than what is made of them in the end.
  const std::size_t pixels = deep.image.pixel_count(), samples = deep.deep->sample_count();
  AbufferOptions options;
  options.deep = true;
  RenderControl control;
  for (const std::size_t little : {std::size_t{1}, 8 * pixels, 24 * pixels + 16 * samples}) {
    control.max_bytes = little;
    const Result<Rendered> refused = render_abuffer(scene, options, control);
    ASSERT_FALSE(refused.ok()) << little;
    EXPECT_EQ(refused.error().field, "max_bytes");
    EXPECT_EQ(refused.error().kind, ErrorKind::out_of_memory);
  }
  control.max_bytes = 1 << 28;
  const Result<Rendered> enough = render_abuffer(scene, options, control);
  ASSERT_TRUE(enough.ok()) << enough.error().message();
  EXPECT_EQ(enough->deep->rgba, deep.deep->rgba);
}

TEST(Deep, FlattensToThePicture) {
  Scene busy = test::busy_scene();
  EXPECT_LT(flattened_error(*render_deep(busy).deep, render_deep(busy).image), rounding);
  busy.background = {0.25f, 0.5f, 0.125f, 0.75f};
  Rendered rendered = render_deep(busy);
  EXPECT_LT(flattened_error(*rendered.deep, rendered.image), rounding) << "a background";
  for (Object& object : busy.objects) object.cloud.opacity.assign(object.cloud.size(), 0.4f);
  rendered = render_deep(busy);
  EXPECT_LT(flattened_error(*rendered.deep, rendered.image), rounding) << "a veil";
  busy.model.coverage = Coverage::hard;
  rendered = render_deep(busy);
  EXPECT_LT(flattened_error(*rendered.deep, rendered.image), rounding) << "hard coverage";
}

TEST(Deep, LayersThatNeverMergeAndSwapFlattenToo) {
  Scene scene = test::stage();
  scene.model.depth_tolerance = 0.0;
  test::Random random(7);
  for (int i = 0; i < 12; ++i) {
    Object& object = scene.objects.emplace_back();
    test::add_disc(object, {0, 0, 0}, {0.1, 0.2, 1}, 0.9, {0.1f * static_cast<float>(i % 10), 0.5f, 0.2f});
    object.cloud.opacity = {0.3f};
    test::move(object, {0, 0, random(-3, 3)}, {0.2, 0, random(-3, 3)});
  }
  const Rendered rendered = render_deep(scene);
  EXPECT_LT(flattened_error(*rendered.deep, rendered.image), rounding);
  EXPECT_GT(rendered.deep->sample_count(), 20 * 400u) << "they cross much depth";
}

TEST(Deep, StillPicturesInstantsAndALensFlattenToo) {
  Scene still = test::busy_scene();
  for (Object& object : still.objects) object.transform.keys.resize(1);
  Rendered rendered = render_deep(still);
  EXPECT_LT(flattened_error(*rendered.deep, rendered.image), rounding) << "nothing moves";
  Scene instant = test::busy_scene();
  instant.shutter.close = instant.shutter.open;
  rendered = render_deep(instant);
  EXPECT_LT(flattened_error(*rendered.deep, rendered.image), rounding) << "an instant";
  Scene lens = test::busy_scene();
  lens.camera.aperture.radius = 0.05;
  lens.camera.aperture.samples = 7;
  for (LookAtKey& key : lens.camera.look_ats) key.lens.focus = 5.0;
  lens.background = {0.0f, 0.1f, 0.0f, 1.0f};
  rendered = render_deep(lens);
  EXPECT_LT(flattened_error(*rendered.deep, rendered.image), rounding) << "a lens";
}

TEST(Deep, ThePictureIsTheSameWithIt) {
  const Scene scene = test::busy_scene();
  const Result<Rendered> without = render_abuffer(scene);
  ASSERT_TRUE(without.ok());
  EXPECT_FALSE(without->deep.has_value());
  EXPECT_EQ(render_deep(scene).image.rgba, without->image.rgba);
}

TEST(Deep, HasTheSameBitsForThreadsTilesAndCrops) {
  const Scene scene = test::busy_scene();
  const DeepImage whole = *render_deep(scene).deep;
  const DeepImage other = *render_deep(scene, {.tile_px = 7, .tile_fragments = 300}, {.threads = 2}).deep;
  EXPECT_EQ(whole.first, other.first);
  EXPECT_EQ(whole.rgba, other.rgba);
  EXPECT_EQ(whole.depth, other.depth);
  Scene cropped = scene;
  cropped.film.crop_x = 20;
  cropped.film.crop_y = 10;
  cropped.film.crop_width = 17;
  cropped.film.crop_height = 23;
  const DeepImage crop = *render_deep(cropped).deep;
  ASSERT_EQ(crop.width, 17);
  for (int y = 0; y < 23; ++y)
    for (int x = 0; x < 17; ++x) {
      const auto of_crop = static_cast<std::size_t>(y * 17 + x);
      const auto of_whole = static_cast<std::size_t>((y + 10) * whole.width + x + 20);
      const std::size_t count = crop.first[of_crop + 1] - crop.first[of_crop];
      ASSERT_EQ(count, whole.first[of_whole + 1] - whole.first[of_whole]) << x << ' ' << y;
      for (std::size_t i = 0; i < 4 * count; ++i)
        ASSERT_EQ(crop.rgba[4 * crop.first[of_crop] + i], whole.rgba[4 * whole.first[of_whole] + i]);
    }
}

/// What is put between at rest is covered as much as it is on average: by what the front alone covers.
TEST(Deep, AlphaInFrontOfADepthIsTheMeanCoverageThere) {
  Scene front = test::stage();
  test::add_disc(front.objects.emplace_back(), {0, 0, 1}, {0, 0, 1}, 0.5);
  test::move(front.objects[0], {-1, 0, 0}, {1, 0, 0});
  Scene both = front;
  test::add_disc(both.objects.emplace_back(), {0, 0, -1}, {0, 0, 1}, 3.0, {1, 0, 0});
  test::move(both.objects[1], {0, -0.1, 0}, {0, 0.1, 0});
  const Image alone = render_deep(front).image;
  const DeepImage deep = *render_deep(both).deep;
  std::size_t partly = 0;
  for (std::size_t pixel = 0; pixel < deep.pixel_count(); ++pixel) {
    double left = 1.0;
    for (std::size_t i = deep.first[pixel]; i < deep.first[pixel + 1]; ++i)
      if (deep.depth[2 * i + 1] < 5.0f) left *= 1.0 - double{deep.rgba[4 * i + 3]};
    ASSERT_NEAR(1.0 - left, alone.rgba[4 * pixel + 3], rounding);
    if (left > 0.1 && left < 0.9) ++partly;
  }
  EXPECT_GT(partly, 100u) << "nothing to see";
}

/// A disc that comes from 8 to 2 before the eye is at each of these depths for a part of the time.
TEST(Deep, WhatMovesInDepthIsSpreadOverItsWay) {
  Scene scene = test::stage();
  test::add_disc(scene.objects.emplace_back(), {0, 0, 0}, {0, 0, 1}, 3.0);
  test::move(scene.objects[0], {0, 0, -3}, {0, 0, 3});
  scene.model.segments = 1;
  const Rendered rendered = render_deep(scene);
  const DeepImage& deep = *rendered.deep;
  const auto middle = static_cast<std::size_t>(24 * 64 + 32);
  double seen = 0.0;
  for (std::size_t i = deep.first[middle]; i < deep.first[middle + 1]; ++i) {
    EXPECT_LE(deep.depth[2 * i + 1], deep.depth[2 * i] * 1.01f) << "thin samples";
    seen += (1.0 - seen) * double{deep.rgba[4 * i + 3]};
    EXPECT_NEAR(seen, (double{deep.depth[2 * i + 1]} - 2.0) / 6.0, 2e-3) << "as long there as anywhere";
  }
  EXPECT_NEAR(seen, 1.0, 1e-6);
  EXPECT_NEAR(deep.depth[2 * deep.first[middle]], 2.0, 1e-3);
}

TEST(Deep, ParsesSmallAndNegativeLightIntoNeighbours) {
  DepthSum sum;
  const double red[4] = {0.5, 0.0, 0.0, 0.5}, taken[4] = {-0.01, 0.0, 0.0, -0.01},
               green[4] = {0.0, 0.25, 0.0, 0.25};
  sum.add(1.0, 1.0, red);
  sum.add(2.0, 2.0, taken);
  sum.add(3.0, 3.0, green);
  sum.add(4.0, 4.0, taken);
  DeepImage image{0, 0, 1, 1, 1, 1, {}, {}, {}};
  append_pixel(sum.parts(), 1.0, Eigen::Vector4d::Zero(), image);
  ASSERT_TRUE(image.validate().ok()) << image.validate().error().message();
  ASSERT_EQ(image.sample_count(), 2u);
  EXPECT_NEAR(image.rgba[3], 0.5, 1e-7);
  EXPECT_NEAR(image.rgba[7], (0.25 - 0.02) / 0.5, 1e-6);
  EXPECT_NEAR(image.rgba[4], -0.02 / 0.5, 1e-6) << "no light is lost";
}

TEST(Deep, AnUntidyImageIsAnError) {
  DeepImage image{0, 0, 1, 1, 1, 1, {0, 2}, std::vector<float>(8, 0.5f), {1.0f, 3.0f, 2.0f, 4.0f}};
  ASSERT_FALSE(image.validate().ok());
  EXPECT_EQ(image.validate().error().field, "depth");
  image.depth = {1.0f, 2.0f, 2.0f, 4.0f};
  EXPECT_TRUE(image.validate().ok());
  image.depth = {1.0f, 1.0f, 1.0f, 1.0f};
  EXPECT_FALSE(image.validate().ok()) << "two points at one depth";
  image.depth = {1.0f, 1.0f, 2.0f, std::numeric_limits<float>::infinity()};
  EXPECT_FALSE(image.validate().ok());
  image = {0, 0, 1, 1, 1, 1, {0, 3}, {}, {}};
  EXPECT_EQ(image.validate().error().field, "rgba");
}

/// What is in the file, by OpenEXR's own reader.
DeepImage read_back(const std::string& path, Imf::Header& header) {
  Imf::DeepScanLineInputFile file(path.c_str());
  header = file.header();
  const Imath::Box2i window = header.dataWindow(), display = header.displayWindow();
  DeepImage image{window.min.x,
                  window.min.y,
                  window.max.x - window.min.x + 1,
                  window.max.y - window.min.y + 1,
                  display.max.x + 1,
                  display.max.y + 1,
                  {},
                  {},
                  {}};
  const auto width = static_cast<std::ptrdiff_t>(image.width);
  std::vector<unsigned int> counts(image.pixel_count());
  const std::ptrdiff_t before = image.x + width * image.y;
  Imf::DeepFrameBuffer frame;
  frame.insertSampleCountSlice({Imf::UINT, reinterpret_cast<char*>(counts.data() - before),
                                sizeof(unsigned int),
                                sizeof(unsigned int) * static_cast<std::size_t>(width)});
  std::vector<float*> pointers[6];
  constexpr const char* names[] = {"R", "G", "B", "A", "Z", "ZBack"};
  for (std::size_t c = 0; c < 6; ++c) {
    pointers[c].resize(counts.size());
    frame.insert(names[c], Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers[c].data() - before),
                                          sizeof(float*), sizeof(float*) * static_cast<std::size_t>(width),
                                          (c < 4 ? 4 : 2) * sizeof(float)));
  }
  file.setFrameBuffer(frame);
  file.readPixelSampleCounts(window.min.y, window.max.y);
  image.first.push_back(0);
  for (const unsigned int count : counts) image.first.push_back(image.first.back() + count);
  image.rgba.resize(4 * image.sample_count());
  image.depth.resize(2 * image.sample_count());
  for (std::size_t pixel = 0; pixel < counts.size(); ++pixel)
    for (std::size_t c = 0; c < 6; ++c)
      pointers[c][pixel] = c < 4 ? image.rgba.data() + 4 * image.first[pixel] + c
                                 : image.depth.data() + 2 * image.first[pixel] + c - 4;
  file.readPixels(window.min.y, window.max.y);
  return image;
}

TEST(DeepFile, HoldsTheSamplesAndSaysWhatTheyAre) {
  const TemporaryFolder folder;
  Scene scene = test::busy_scene();
  scene.film.crop_x = 5;
  scene.film.crop_y = 7;
  scene.film.crop_width = 40;
  scene.film.crop_height = 37;
  const DeepImage deep = *render_deep(scene).deep;
  ImageMetadata metadata;
  metadata.scene_hash = "0123456789abcdef";
  ASSERT_TRUE(write_deep_exr(folder / "deep.exr", deep, metadata).ok());
  EXPECT_EQ(folder.names().size(), 1u);
  Imf::Header header;
  const DeepImage read = read_back(folder / "deep.exr", header);
  EXPECT_EQ(read.first, deep.first);
  EXPECT_EQ(read.rgba, deep.rgba);
  EXPECT_EQ(read.depth, deep.depth);
  EXPECT_TRUE(read.validate().ok());
  EXPECT_EQ(read.x, 5);
  EXPECT_EQ(read.film_width, 64);
  EXPECT_EQ(header.type(), Imf::DEEPSCANLINE);
  ASSERT_TRUE(Imf::hasDeepImageState(header));
  EXPECT_EQ(Imf::deepImageState(header), Imf::DIS_TIDY);
  EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("sceneHash").value(), metadata.scene_hash);
  EXPECT_NE(header.typedAttribute<Imf::StringAttribute>("deepSamples").value().find("sorted"),
            std::string::npos);
  // Whole, and of that scene; and to be read flat.
  const Result<ExrOrigin> origin = read_exr_origin(folder / "deep.exr");
  ASSERT_TRUE(origin.ok()) << origin.error().message();
  EXPECT_EQ(origin->scene_hash, metadata.scene_hash);

  ASSERT_TRUE(write_deep_exr(folder / "half.exr", deep, metadata, ExrPixels::float16).ok());
  const DeepImage narrow = read_back(folder / "half.exr", header);
  EXPECT_EQ(header.channels().findChannel("A")->type, Imf::HALF);
  EXPECT_EQ(narrow.depth, deep.depth);
  for (std::size_t i = 0; i < deep.rgba.size(); ++i) ASSERT_NEAR(narrow.rgba[i], deep.rgba[i], 5e-4);

  EXPECT_FALSE(write_deep_exr(folder / "deep.exr", deep, metadata, ExrPixels::float32, IfExists::fail).ok());
  DeepImage broken = deep;
  broken.first.pop_back();
  const Status refused = write_deep_exr(folder / "no.exr", broken);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "first");
  EXPECT_FALSE(write_deep_exr(folder / "none/deep.exr", deep).ok());
  EXPECT_EQ(folder.names().size(), 2u);
}

const std::string scene_text =
    R"({"swept": 1, "film": {"width": 96, "height": 54}, "background": [0.1, 0.2, 0.3, 1],
 "camera": {"fov": {"axis": "vertical", "degrees": 40},
            "keys": [{"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]}]},
 "objects": [{"source": {"generator": "sphere", "points": 2000},
              "transform": {"keys": [{"frame": 0, "translate": [-1, 0, -1]}, {"frame": 2, "translate": [1, 0, 1]}]}}]})";

TEST(DeepCommand, WritesBesideThePictureAndToolsFlattenItToThat) {
  const TemporaryFolder folder;
  test::put(folder / "scene.json", scene_text);
  const std::string render = SWEPT_COMMAND " render '" + (folder / "scene.json") + "' --exact -o '" +
                             (folder / "flat.exr") + "' --deep '" + (folder / "deep.exr") + "'";
  const test::Outcome outcome = run_command(render);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  Imf::Header header;
  const DeepImage deep = read_back(folder / "deep.exr", header);
  const Result<Image> flat = read_exr(folder / "flat.exr");
  ASSERT_TRUE(flat.ok());
  EXPECT_LT(flattened_error(deep, *flat), rounding);
  EXPECT_TRUE(deep.validate().ok());

  EXPECT_EQ(run_command(render).exit_code, 1) << "both exist";
  EXPECT_EQ(run_command(render + " --skip-existing").exit_code, 0);
  const std::string before = test::content_of(folder / "deep.exr");
  std::filesystem::remove(folder / "deep.exr");
  EXPECT_EQ(run_command(render + " --skip-existing").exit_code, 0) << "one of two is missing";
  EXPECT_EQ(test::content_of(folder / "deep.exr"), before);

  if (run_command("command -v oiiotool").exit_code != 0) GTEST_SKIP() << "there is no oiiotool";
  const test::Outcome difference =
      run_command("oiiotool '" + (folder / "deep.exr") + "' --flatten --ch R,G,B,A '" +
                  (folder / "flat.exr") + "' --ch R,G,B,A --fail 0.001 --warn 0.001 --diff");
  EXPECT_EQ(difference.exit_code, 0) << difference.out << difference.err;
}

TEST(DeepCommand, OtherToolsReadItWithoutComplaint) {
  if (run_command("command -v exrheader >/dev/null && command -v exrstdattr").exit_code != 0)
    GTEST_SKIP() << "there is no exrheader, or no exrstdattr";
  const TemporaryFolder folder;
  ASSERT_TRUE(write_deep_exr(folder / "deep.exr", *render_deep(test::busy_scene()).deep).ok());
  ASSERT_TRUE(write_exr(folder / "flat.exr", render_deep(test::busy_scene()).image).ok());
  for (const char* name : {"deep.exr", "flat.exr"}) {
    const test::Outcome told = run_command("exrheader '" + (folder / name) + "'");
    EXPECT_EQ(told.exit_code, 0) << told.err;
    EXPECT_EQ(told.err, "");
    const test::Outcome changed = run_command("exrstdattr -owner someone '" + (folder / name) + "' '" +
                                              (folder / (std::string("owned.") + name)) + "'");
    EXPECT_EQ(changed.exit_code, 0) << changed.err;
    EXPECT_EQ(changed.err, "");
  }
}

TEST(DeepCommand, MethodsAndScenesThatCannotAreRefusedByName) {
  const TemporaryFolder folder;
  test::put(folder / "scene.json", scene_text);
  const auto render = [&](const std::string& rest) {
    return run_command(SWEPT_COMMAND " render '" + (folder / "scene.json") + "' -o '" +
                       (folder / "flat.exr") + "' --deep '" + (folder / "deep.exr") + "' " + rest);
  };
  for (const char* method : {"", "--method sampled", "--method gpu", "--method reference"}) {
    const test::Outcome outcome = render(method);
    EXPECT_EQ(outcome.exit_code, 2) << method;
    EXPECT_NE(outcome.err.find("--deep"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("--exact"), std::string::npos) << outcome.err;
  }
  const test::Outcome per_pixel = render("--exact --normalisation pixel");
  EXPECT_EQ(per_pixel.exit_code, 2);
  EXPECT_NE(per_pixel.err.find("--normalisation"), std::string::npos) << per_pixel.err;
  EXPECT_EQ(folder.names().size(), 1u);

  Scene rows = test::busy_scene();
  rows.shutter.close = rows.shutter.open;
  rows.shutter.row_delay = 0.001;
  rows.model.segments = 0;
  AbufferOptions options;
  options.deep = true;
  const Result<Rendered> refused = render_abuffer(rows, options);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "deep");
  options.normalisation = Normalisation::pixel;
  EXPECT_FALSE(render_abuffer(test::busy_scene(), options).ok());
}

}  // namespace
}  // namespace swept
