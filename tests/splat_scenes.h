// Scenes of Gaussian splats that several tests draw.
#pragma once

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "splat/image.h"
#include "splat/io/splat_file.h"
#include "splat/scene.h"

/// The folder of real data, or a skipped test.
#define SWEPT_DATA_OR_SKIP(name)                                              \
  const char* const name##_env = std::getenv("SWEPT_DATA_DIR");               \
  if (!name##_env || !*name##_env) GTEST_SKIP() << "SWEPT_DATA_DIR is unset"; \
  const std::string name = std::string(name##_env) + "/"

namespace swept::test {

/// Of R, G and B, for peak 1; +∞ where they are the same.
inline double psnr_db(const Image& a, const Image& b) {
  EXPECT_EQ(a.rgba.size(), b.rgba.size());
  if (a.rgba.size() != b.rgba.size()) return 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    const double difference = double{a.rgba[i]} - double{b.rgba[i]};
    squares += difference * difference;
  }
  return -10.0 * std::log10(squares / (3.0 * static_cast<double>(a.pixel_count())));
}

/// A camera at `eye` that looks along z, with y down as splats are trained.
inline LookAtKey looking_along_z(double frame, const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                                 double fov_degrees) {
  LookAtKey key;
  key.frame = frame;
  key.eye = eye;
  key.target = target;
  key.up = {0, -1, 0};
  key.tan_half_fov_y = std::tan(fov_degrees * M_PI / 360.0);
  return key;
}

/// The trained head as try_still.exr has it.
inline Scene try_scene(const std::string& data) {
  Scene scene;
  scene.film = {256, 256, 0, 0, 0, 0};
  scene.shutter = {0.0, 0.0};
  scene.camera.look_ats = {looking_along_z(0.0, {-60, 0, 100}, {-60, 0, 600}, 60.0)};
  Result<LoadedSplats> loaded = read_splats(data + "gaussians/try_it7000.ply");
  EXPECT_TRUE(loaded.ok()) << loaded.error().message();
  if (loaded.ok()) scene.objects.emplace_back().splats = std::move(loaded->splats);
  return scene;
}

/// And as try_move.exr has it.
inline Scene try_moving_scene(const std::string& data) {
  Scene scene = try_scene(data);
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats.push_back(looking_along_z(1.0, {-45, 0, 110}, {-40, 0, 610}, 60.0));
  return scene;
}

/// One round splat of standard deviation `sigma` at `position`, grey, seen by a camera at the origin that
/// looks along z with a focal length of 64 px.
inline Scene one_splat(const Eigen::Vector3d& position, float sigma, float opacity, float grey) {
  Scene scene;
  scene.film = {64, 48, 0, 0, 0, 0};
  scene.shutter = {0.0, 0.0};
  scene.camera.look_ats = {looking_along_z(0.0, {0, 0, 0}, {0, 0, 1}, 60.0)};
  scene.camera.look_ats[0].tan_half_fov_y = 24.0 / 64.0;
  SplatCloud& cloud = scene.objects.emplace_back().splats;
  cloud.position = {position};
  cloud.scale = {{sigma, sigma, sigma}};
  cloud.rotation = {Eigen::Quaternionf::Identity()};
  cloud.opacity = {opacity};
  constexpr float constant = 0.28209479177387814f;
  cloud.harmonics.assign(3, (grey - 0.5f) / constant);
  return scene;
}

/// Splats of all sizes, shapes and opacities around (0, 0, 7), of degree 3, in motion over one frame.
inline Scene random_splats(std::size_t count, unsigned seed, float size = 0.1f) {
  Scene scene;
  scene.film = {150, 100, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats = {looking_along_z(0.0, {0, 0, 0}, {0, 0, 1}, 50.0)};
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> any(-1.0f, 1.0f);
  const auto next = [&] { return any(generator); };
  SplatCloud& cloud = scene.objects.emplace_back().splats;
  cloud.degree = 3;
  for (std::size_t i = 0; i < count; ++i) {
    const float z = 7.0f + 3.0f * next(), x = 0.8f * z * next(), y = 0.55f * z * next();
    cloud.position.push_back(Eigen::Vector3f(x, y, z).cast<double>());
    const float longest = size * std::exp(1.5f * next());
    cloud.scale.push_back(longest * Eigen::Vector3f(1.0f, std::exp(next() - 1.0f), std::exp(next() - 1.0f)));
    cloud.rotation.push_back(Eigen::Quaternionf(next(), next(), next(), next()).normalized());
    cloud.opacity.push_back(0.5f + 0.5f * next());
    for (int k = 0; k < 48; ++k) cloud.harmonics.push_back((k < 3 ? 1.5f : 0.3f) * next());
    cloud.velocity.push_back(0.5f * Eigen::Vector3f(next(), next(), next()));
  }
  return scene;
}

}  // namespace swept::test
