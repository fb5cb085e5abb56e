// An EXR's camera by the standard's axes: points are reprojected from the header alone, in OpenEXR's own
// terms.
#include <cmath>
#include <numbers>
#include <string>

#include <ImathMatrix.h>
#include <ImfFloatAttribute.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/io/image_file.h"
#include "tests/command.h"

namespace swept {
namespace {

using test::put;
using test::TemporaryFolder;

/// Where the camera below sees a point, px from the upper left corner.
Imath::V2d projected(const Imath::V3d& point, int width, int height) {
  const Imath::V3d eye(2, 1.5, 6), target(0.1, -0.1, 0.2), up(0.2, 1, 0);
  const Imath::V3d forward = (target - eye).normalized(), right = forward.cross(up).normalized();
  const Imath::V3d above = right.cross(forward), ray = point - eye;
  const double focal_px = 0.5 * std::hypot(width, height) / std::tan(25.0 * std::numbers::pi / 180.0);
  return {0.5 * width + focal_px * ray.dot(right) / ray.dot(forward),
          0.5 * height - focal_px * ray.dot(above) / ray.dot(forward)};
}

/// Five small discs, one after the other, seen askew; where each is in the picture is found in the picture.
TEST(ExrCamera, ReprojectsKnownPoints) {
  const TemporaryFolder folder;
  const Imath::V3d points[] = {
      {0, 0, 0}, {1.1, 0.4, 0.2}, {-0.9, 0.7, -0.5}, {0.3, -0.8, 1.0}, {-0.6, -0.5, 0.4}};
  for (const auto& [width, height, crop] : {std::tuple{320, 200, ""}, {150, 260, " --crop 10,20,130,230"}}) {
    for (std::size_t i = 0; i < std::size(points); ++i) {
      const Imath::V3d& p = points[i];
      const auto pixels_x = static_cast<float>(width), pixels_y = static_cast<float>(height);
      put(folder / "p.xyz",
          std::to_string(p.x) + ' ' + std::to_string(p.y) + ' ' + std::to_string(p.z) + '\n');
      // A disc that faces the eye is round on the film but for perspective, far below the bound at this size.
      put(folder / "scene.json", R"({"swept": 1, "camera": {"fov": {"axis": "diagonal", "degrees": 50},
        "keys": [{"eye": [2, 1.5, 6], "target": [0.1, -0.1, 0.2], "up": [0.2, 1, 0]}]},
        "shutter": {"open": 0, "close": 0},
        "objects": [{"source": {"file": "p.xyz"}, "radius": 0.004}]})");
      const std::string image_path = folder / "a.exr";
      const test::Outcome outcome = test::run_command(
          std::string(SWEPT_COMMAND) + " render '" + folder / "scene.json" + "' -o '" + image_path +
          "' --overwrite --size " + std::to_string(width) + 'x' + std::to_string(height) + crop);
      ASSERT_EQ(outcome.exit_code, 0) << outcome.err;

      const Imf::InputFile file(image_path.c_str(), 0);
      const Imf::Header& header = file.header();
      const Imath::M44f to_camera = Imf::worldToCamera(header), to_ndc = Imf::worldToNDC(header);
      const Imath::V3f world(p);
      const Imath::V3f ndc = world * to_ndc, eye = world * to_camera;
      const double x = double{ndc.x * pixels_x}, y = double{ndc.y * pixels_y};
      const Imath::V2d expected = projected(p, width, height);
      EXPECT_NEAR(x, expected.x, 0.01);
      EXPECT_NEAR(y, expected.y, 0.01);
      // The film from worldToCamera and the screen window is the same.
      const double window = header.screenWindowWidth();
      EXPECT_NEAR((eye.x / eye.z / window + 0.5) * width, x, 0.001);
      EXPECT_NEAR((0.5 * height / width - eye.y / eye.z / window) * width, y, 0.001);
      EXPECT_EQ(header.screenWindowCenter(), Imath::V2f(0, 0));
      EXPECT_NEAR(header.typedAttribute<Imf::FloatAttribute>("fieldOfView").value(),
                  2.0 * std::atan(0.5 * window) * 180.0 / std::numbers::pi, 1e-4);

      // Independent of it all: the centre of the light in the picture.
      const Result<Image> image = read_exr(image_path);
      ASSERT_TRUE(image.ok());
      double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
      for (std::size_t k = 0; k < image->pixel_count(); ++k) {
        const double alpha = image->rgba[4 * k + 3];
        sum += alpha;
        sum_x += alpha * (image->x + static_cast<double>(k % static_cast<std::size_t>(image->width)) + 0.5);
        sum_y += alpha * (image->y + static_cast<double>(k / static_cast<std::size_t>(image->width)) + 0.5);
      }
      ASSERT_GT(sum, 0.0);
      // A blob of three pixels, sampled at their centres, is placed to a few hundredths.
      EXPECT_NEAR(sum_x / sum, x, 0.15) << i;
      EXPECT_NEAR(sum_y / sum, y, 0.15) << i;
    }
  }
}

/// A camera of measured intrinsics, on a film of its picture's size and on a smaller, wider one.
TEST(ExrCamera, ReprojectsThroughALensOffTheMiddle) {
  const TemporaryFolder folder;
  put(folder / "p.xyz", "0.3 -0.8 1\n");
  put(folder / "scene.json", R"({"swept": 1, "camera": {
    "intrinsics": {"width": 640, "height": 480, "fx": 500, "fy": 800, "cx": 300, "cy": 270.5},
    "keys": [{"eye": [0, 0, 6], "target": [0, 0, 0]}]}, "shutter": {"open": 0, "close": 0},
    "objects": [{"source": {"file": "p.xyz"}, "radius": 0.004}]})");
  // x right, y down: the eye looks along −z from z = 6, 5 from the point.
  for (const auto& [width, height, x, y] :
       {std::tuple{640, 480, 300.0 + 500.0 * 0.3 / 5.0, 270.5 + 800.0 * 0.8 / 5.0},
        {320, 120, 160.0 + (-20.0 + 500.0 * 0.3 / 5.0) / 4.0, 60.0 + (30.5 + 800.0 * 0.8 / 5.0) / 4.0}}) {
    const std::string image_path = folder / "a.exr";
    const test::Outcome outcome = test::run_command(
        std::string(SWEPT_COMMAND) + " render '" + folder / "scene.json" + "' -o '" + image_path +
        "' --overwrite --size " + std::to_string(width) + 'x' + std::to_string(height));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Imf::InputFile file(image_path.c_str(), 0);
    const Imf::Header& header = file.header();
    const Imath::V3f world(0.3f, -0.8f, 1.0f);
    const Imath::V3f ndc = world * Imf::worldToNDC(header), eye = world * Imf::worldToCamera(header);
    EXPECT_NEAR(static_cast<double>(ndc.x) * width, x, 0.001);
    EXPECT_NEAR(static_cast<double>(ndc.y) * height, y, 0.001);
    // The same from the window on the plane at depth 1, whose height follows from the shape of pixels.
    EXPECT_FLOAT_EQ(header.pixelAspectRatio(), 800.0f / 500.0f);
    const float window = header.screenWindowWidth();
    const auto film_x = static_cast<float>(width), film_y = static_cast<float>(height);
    const float window_y = window / header.pixelAspectRatio() * film_y / film_x;
    const Imath::V2f& center = header.screenWindowCenter();
    EXPECT_NEAR(static_cast<double>((eye.x / eye.z - center.x) / window + 0.5f) * width, x, 0.001);
    EXPECT_NEAR(static_cast<double>(0.5f - (eye.y / eye.z - center.y) / window_y) * height, y, 0.001);
    const Result<Image> image = read_exr(image_path);
    ASSERT_TRUE(image.ok());
    double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column) {
        const double alpha = image->rgba[4 * static_cast<std::size_t>(row * width + column) + 3];
        sum += alpha;
        sum_x += alpha * (column + 0.5);
        sum_y += alpha * (row + 0.5);
      }
    ASSERT_GT(sum, 0.0);
    EXPECT_NEAR(sum_x / sum, x, 0.15);
    EXPECT_NEAR(sum_y / sum, y, 0.15);
  }
}

TEST(ExrCamera, HasTheStandardsAxes) {
  const TemporaryFolder folder;
  Image image{0, 0, 40, 20, 40, 20, std::vector<float>(4 * 800), {}};
  ImageMetadata metadata;
  // Swept's own: right, down, forward; the eye at (1, 2, 8) looks along −z.
  metadata.world_to_camera << 1, 0, 0, -1, 0, -1, 0, 2, 0, 0, -1, 8, 0, 0, 0, 1;
  metadata.tan_half_fov_y = 0.5;
  metadata.near = 0.5;
  ASSERT_TRUE(write_exr(folder / "a.exr", image, metadata).ok());
  const Imf::InputFile file((folder / "a.exr").c_str(), 0);
  const Imath::M44f to_camera = Imf::worldToCamera(file.header()), to_ndc = Imf::worldToNDC(file.header());
  EXPECT_EQ(Imath::V3f(2, 4, 3) * to_camera, Imath::V3f(1, 2, 5)) << "x right, y up, z along the view";
  EXPECT_LT(to_camera.determinant(), 0.0f) << "left-handed";
  // At depth 2 the film is 4 × 2 large.
  EXPECT_EQ(Imath::V3f(1 - 2, 2 + 1, 6) * to_ndc, Imath::V3f(0, 0, 0.75)) << "upper left";
  EXPECT_EQ(Imath::V3f(1 + 2, 2 - 1, 6) * to_ndc, Imath::V3f(1, 1, 0.75)) << "lower right";
  EXPECT_EQ(file.header().screenWindowWidth(), 2.0f);
  EXPECT_EQ(file.header().pixelAspectRatio(), 1.0f);

  metadata.tan_half_fov_y = -1.0;
  EXPECT_EQ(write_exr(folder / "a.exr", image, metadata).error().field, "tan_half_fov_y");
  metadata.tan_half_fov_y = 0.5;
  metadata.lens.stretch_x = 0.0;
  EXPECT_EQ(write_exr(folder / "a.exr", image, metadata).error().field, "lens");
}

/// Parallel rays: a point is where it is whatever its depth, and worldToNDC divides by nothing.
TEST(ExrCamera, ReprojectsThroughAnOrthographicCamera) {
  const TemporaryFolder folder;
  for (const double z : {1.0, -40.0}) {
    put(folder / "p.xyz", "0.3 -0.8 " + std::to_string(z) + '\n');
    put(folder / "scene.json", R"({"swept": 1, "camera": {"height": 4,
      "keys": [{"eye": [0.1, 0, 6], "target": [0.1, 0, 0]}]}, "shutter": {"open": 0, "close": 0},
      "objects": [{"source": {"file": "p.xyz"}, "radius": 0.02}]})");
    const std::string image_path = folder / "a.exr";
    const test::Outcome outcome =
        test::run_command(std::string(SWEPT_COMMAND) + " render '" + folder / "scene.json" + "' -o '" +
                          image_path + "' --overwrite --size 320x200");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Imf::InputFile file(image_path.c_str(), 0);
    const Imf::Header& header = file.header();
    const Imath::V3f world(0.3f, -0.8f, static_cast<float>(z));
    const Imath::V3f ndc = world * Imf::worldToNDC(header), eye = world * Imf::worldToCamera(header);
    // 50 px a unit.
    const double x = 160.0 + 50.0 * 0.2, y = 100.0 + 50.0 * 0.8;
    EXPECT_NEAR(double{ndc.x} * 320.0, x, 1e-3);
    EXPECT_NEAR(double{ndc.y} * 200.0, y, 1e-3);
    EXPECT_NEAR(double{eye.z}, 6.0 - z, 1e-4);
    EXPECT_NEAR(header.screenWindowWidth(), 320.0 / 50.0, 1e-5);
    EXPECT_EQ(header.findTypedAttribute<Imf::FloatAttribute>("fieldOfView"), nullptr);
    const Result<Image> image = read_exr(image_path);
    ASSERT_TRUE(image.ok());
    double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
    for (std::size_t k = 0; k < image->pixel_count(); ++k) {
      const double alpha = image->rgba[4 * k + 3];
      sum += alpha;
      sum_x += alpha * (static_cast<double>(k % 320) + 0.5);
      sum_y += alpha * (static_cast<double>(k / 320) + 0.5);
    }
    ASSERT_GT(sum, 0.0);
    EXPECT_NEAR(sum_x / sum, x, 0.15);
    EXPECT_NEAR(sum_y / sum, y, 0.15);
  }
}

}  // namespace
}  // namespace swept
