// Values at the ends of what numbers hold: each is right, or an error that names it.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/compare/metrics.h"
#include "splat/io/atomic_file.h"
#include "splat/io/file_bytes.h"
#include "splat/io/scene_file.h"
#include "tests/scene_text.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using test::base_scene;
using test::replaced;

TEST(ParseNumber, LongNumbersAreWhatTheySay) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::string zeros(800, '0');
  for (const auto& [text, value] : {std::pair<std::string, double>{"1" + zeros + "e-400", infinity},
                                    {"-1" + zeros + "e-400", -infinity},
                                    {"1" + zeros + "e-800", 1.0},
                                    {"1" + zeros + "e-1200", 0.0},
                                    {"0." + zeros + "1", 0.0},
                                    {"0." + zeros + "1e801", 1.0},
                                    {"0." + zeros + "1e1300", infinity},
                                    {"1e999999999999999999999", infinity},
                                    {"1e-999999999999999999999", 0.0},
                                    {"+1.5e400", infinity},
                                    {"1E-400", 0.0},
                                    {"0e5", 0.0}}) {
    const std::optional<double> parsed = parse_number(text);
    ASSERT_TRUE(parsed.has_value()) << text.substr(0, 9);
    EXPECT_EQ(*parsed, value) << text.substr(0, 9) << "..." << text.substr(text.size() - 6);
  }
}

CameraTrack looking(const Vector3d& eye, const Vector3d& target, const Vector3d& up) {
  CameraTrack camera;
  camera.look_ats.push_back({0.0, eye, target, up, 0.5});
  return camera;
}

TEST(FarCameras, KeepTheirBasis) {
  for (const double unit : {1.0, 1e155, 1e300, 1e-170, 1e-300}) {
    for (const double up : {1.0, 1e200, 1e-200}) {
      CameraTrack camera = looking({0, 0, 5 * unit}, {0, 0, 0}, {0, up, 0});
      camera.look_ats.push_back({1.0, {unit, 0, 5 * unit}, {unit, 0, 0}, {0, up, 0}, 0.5});
      ASSERT_TRUE(camera.validate().ok()) << unit << ' ' << up << camera.validate().error().message();
      for (const double frame : {0.0, 0.5, 1.0}) {
        const Eigen::Matrix3d axes = camera.at(frame).camera_from_world.linear();
        EXPECT_TRUE(axes.isApprox(Eigen::DiagonalMatrix<double, 3>(1, -1, -1).toDenseMatrix())) << axes;
      }
      EXPECT_FALSE(looking({0, 0, 5 * unit}, {0, 0, 0}, {0, 0, up}).validate().ok()) << "parallel";
      camera.look_ats[1].eye = {0, 0, -5 * unit};
      camera.look_ats[1].target = {0, 0, 0};
      EXPECT_FALSE(camera.validate().ok()) << "through the target";
    }
  }
  EXPECT_EQ(looking({-1.7e308, 0, 0}, {1.7e308, 0, 0}, {0, 1, 0}).validate().error().field, "/keys/0/target");
}

TEST(Colors, OfNoLightAreRefused) {
  SurfelCloud cloud = *test::dots("dots", 1, {});
  for (const float value : {1e30f, -1e30f}) {
    cloud.color = {{value, 0, 0}};
    EXPECT_TRUE(cloud.validate().ok());
  }
  for (const float value : {3e38f, -3e38f, 1.1e30f}) {
    cloud.color = {{0, value, 0}};
    ASSERT_FALSE(cloud.validate().ok());
    EXPECT_EQ(cloud.validate().error().field, "color[0]");
  }
  const std::string text = replaced(base_scene, "\"name\": \"knot\"", "\"color\": [0, 3e38, 0]");
  const Result<SceneFile> file = scene_from_text(text, "scene.json");
  ASSERT_FALSE(file.ok());
  EXPECT_EQ(file.error().field, "/objects/0/color");
}

TEST(Metrics, OfHugePixelsAreNumbers) {
  for (const float value : {1e10f, 1e38f, 3e38f}) {
    Image a{0, 0, 24, 24, 24, 24, {}, {}};
    for (std::size_t i = 0; i < a.pixel_count(); ++i)
      for (const float c : {value * (static_cast<float>(i % 7) / 7.0f), -value, value, 1.0f})
        a.rgba.push_back(c);
    Image b = a;
    for (std::size_t i = 0; i < b.rgba.size(); i += 5) b.rgba[i] *= -1.0f;
    for (std::size_t i = 3; i < b.rgba.size(); i += 4) b.rgba[i] = 1.0f;
    const Result<ImageMetrics> other = compare_images(a, b), same = compare_images(a, a);
    ASSERT_TRUE(other.ok() && same.ok());
    EXPECT_TRUE(other->ssim >= -1.0 && other->ssim <= 1.0) << other->ssim;
    EXPECT_TRUE(other->flip >= 0.0 && other->flip <= 1.0) << other->flip;
    EXPECT_TRUE(std::isfinite(other->rmse) && std::isfinite(other->psnr_db));
    // Identical windows have quotients of equal numbers, 1 but for rounding of a sum of 196 of them.
    EXPECT_NEAR(same->ssim, 1.0, 196 * 2.3e-16);
    EXPECT_EQ(same->flip, 0.0);
  }
}

/// Variances of constant planes are what rounding leaves of squares, of either sign.
TEST(Metrics, OfHugeConstantPlanesAreNumbers) {
  for (int i = 1; i < 12; ++i) {
    const std::vector<double> a(576, 3e38 * i / 12.0), b(576, 3e38 * (13 - i) / 13.0);
    const double ssim = mean_ssim(a, b, 24, 24);
    EXPECT_TRUE(ssim >= -1.0 && ssim <= 1.0) << ssim;
  }
}

/// Of `inner` in `levels` brackets.
std::string nested(std::size_t levels, const std::string& inner = "") {
  return std::string(levels, '[') + inner + std::string(levels, ']');
}

TEST(JsonBombs, AreErrorsThatNameThePlace) {
  const auto error_of = [](const std::string& text) {
    const Result<SceneFile> file = scene_from_text(text, "scene.json");
    EXPECT_FALSE(file.ok());
    return file.ok() ? Error{} : file.error();
  };
  const Error deep = error_of("{\"swept\": 1, \"film\": " + nested(100'000) + "}");
  EXPECT_NE(deep.reason.find("nested in more than 64 levels"), std::string::npos) << deep.message();
  EXPECT_TRUE(deep.field.starts_with("/film/0/0")) << deep.field;
  // Bad syntax is found behind it all the same.
  EXPECT_NE(error_of(std::string(5'000'000, '[')).reason.find("unexpected end"), std::string::npos);
  std::string wide = "{\"swept\": [0";
  for (int i = 0; i < 4'000'001; ++i) wide += ",0";
  EXPECT_NE(error_of(wide + "]}").reason.find("more than 4000000 values"), std::string::npos);
  // What a scene may be is not one.
  EXPECT_EQ(error_of("{\"swept\": 1, \"film\": " + nested(60) + "}").field, "/film");
}

TEST(AtomicFiles, WhatAppearsMeanwhileIsKept) {
  const test::TemporaryFolder folder;
  Result<AtomicFile> first = AtomicFile::create(folder / "file"),
                     second = AtomicFile::create(folder / "file");
  ASSERT_TRUE(first.ok() && second.ok());
  std::fputs("first", first->stream());
  std::fputs("second", second->stream());
  EXPECT_TRUE(second->commit(IfExists::fail).ok());
  const Status late = first->commit(IfExists::fail);
  ASSERT_FALSE(late.ok());
  EXPECT_NE(late.error().reason.find("appeared"), std::string::npos);
  EXPECT_EQ(test::content_of(folder / "file"), "second");
  EXPECT_EQ(folder.names(), std::set<std::string>{"file"});
}

TEST(AtomicFiles, TakeAwayWhatTheDeadLeft) {
  const test::TemporaryFolder folder;
  for (const char* left : {"file.tmp0", "file.tmp1"}) test::put(folder / left, "half");
  const Result<AtomicFile> busy = AtomicFile::create(folder / "file");
  ASSERT_TRUE(busy.ok());
  std::fputs("busy", busy->stream());
  std::fflush(busy->stream());
  ASSERT_TRUE(write_file(folder / "file", "whole").ok());
  // The one that is being written stays.
  EXPECT_EQ(folder.names(), (std::set<std::string>{"file", "file.tmp0"}));
  EXPECT_EQ(test::content_of(folder / "file.tmp0"), "busy");
}

}  // namespace
}  // namespace swept
