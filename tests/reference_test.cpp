#include "abuffer/reference/reference.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/reference/reference_frame.h"
#include "tests/counter.h"
#include "tests/image_difference.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using test::counter;

// Values are at most 1 and end as floats, which rounds by 2⁻²⁵; so do the colours and axes they are computed
// from. Four such errors cover every sum below.
constexpr double float_rounding = 0x1p-23;

/// 48 × 32 px, focal length 32 px, near plane at 1.
struct Stage {
  Scene scene;
  KernelSet set;

  Stage() {
    scene.film = {48, 32, 0, 0, 0, 0};
    scene.camera.look_ats.emplace_back();
    scene.camera.near = 1.0;
    set.projection = projection_of(scene.film, 0.5);
    set.near = 1.0;
  }

  MovingKernel& add(const Vector3d& center, const Vector3d& axis_u, const Vector3d& axis_v) {
    MovingKernel kernel;
    kernel.center = center;
    kernel.velocity.setZero();
    kernel.axis_u = axis_u.cast<float>();
    kernel.axis_v = axis_v.cast<float>();
    kernel.facing.setZero();
    kernel.color.setOnes();
    set.kernels.push_back(kernel);
    return set.kernels.back();
  }
  /// Parallel to the film.
  MovingKernel& add_facing(const Vector3d& center, double radius) {
    return add(center, Vector3d(radius, 0.0, 0.0), Vector3d(0.0, radius, 0.0));
  }

  [[nodiscard]] Rendered render(int samples = 2, int threads = 0) const {
    auto rendered = render_reference(set, scene, {samples, ReferenceMotion::segments}, {.threads = threads});
    EXPECT_TRUE(rendered.ok()) << rendered.error().message();
    return std::move(rendered).value();
  }
};

Vector4d pixel(const Image& image, int x, int y) {
  const std::size_t i = static_cast<std::size_t>(y - image.y) * image.width + (x - image.x);
  return Eigen::Map<const Eigen::Vector4f>(&image.rgba[4 * i]).cast<double>();
}

float depth_at(const Image& image, int x, int y) {
  return image.depth[static_cast<std::size_t>(y - image.y) * image.width + (x - image.x)];
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

/// Calls visit(x, y) for every pixel of the film.
template <class Visit>
void for_each_pixel(const Film& film, const Visit& visit) {
  for (int y = 0; y < film.height; ++y) {
    for (int x = 0; x < film.width; ++x) visit(x, y);
  }
}

/// Moving, tilted, half-transparent kernels, some of them through the near plane and the eye.
Stage crowd(unsigned seed, int count) {
  Stage stage;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&](double scale) {
    return Vector3d(scale * unit(random), scale * unit(random), scale * unit(random));
  };
  for (int i = 0; i < count; ++i) {
    MovingKernel& kernel = stage.add(Vector3d(0.0, 0.0, 2.0) + vector(2.5), vector(0.5), vector(0.5));
    kernel.velocity = vector(1.0);
    kernel.weight = static_cast<float>(0.75 + 0.25 * unit(random));
    kernel.depth_tolerance = 0.25f;
    kernel.color = Eigen::Vector4f(0.2f, 0.4f, 0.6f, 0.7f) * static_cast<float>(0.75 + 0.25 * unit(random));
    if (i % 3 == 0) kernel.facing = kernel.axis_u.cross(kernel.axis_v);
  }
  return stage;
}

TEST(Reference, StillDiscIsItsKernel) {
  Stage stage;
  stage.scene.background = {0.1f, 0.2f, 0.3f, 0.5f};
  const double depth = 4.0, radius = 1.0;
  MovingKernel& disc = stage.add_facing({0.3, -0.2, depth}, radius);
  disc.color = {0.8f, 0.4f, 0.2f, 1.0f};
  const Rendered rendered = stage.render();
  EXPECT_EQ(counter(rendered, "samples"), 1.0);
  EXPECT_EQ(counter(rendered, "reference_error_rmse"), 0.0);
  int covered = 0;
  for_each_pixel(stage.scene.film, [&](int x, int y) {
    const double u = (x + 0.5 - 24.0) / 32.0 * depth - 0.3, v = (y + 0.5 - 16.0) / 32.0 * depth + 0.2;
    const double rho = u * u + v * v <= 1.0 ? std::exp(-3.0 * (u * u + v * v)) : 0.0;
    const double alpha = std::min(1.0, rho / 0.5);
    const Vector4d expected =
        alpha * disc.color.cast<double>() + (1.0 - alpha) * stage.scene.background.cast<double>();
    EXPECT_LE((pixel(rendered.image, x, y) - expected).cwiseAbs().maxCoeff(), float_rounding);
    EXPECT_EQ(depth_at(rendered.image, x, y), rho > 0.0 ? 4.0f : HUGE_VALF);
    covered += rho > 0.0;
  });
  // π · (8 px)² pixels, give or take the circle's perimeter.
  EXPECT_NEAR(covered, 201, 50);
  EXPECT_EQ(counter(rendered, "fragments"), covered);
}

TEST(Reference, HardStreakIsTheShareOfTimeCovered) {
  Stage stage;
  stage.scene.model.coverage = Coverage::hard;
  const double radius = 0.5;
  MovingKernel& disc = stage.add_facing({0.1, 0.05, 3.0}, radius);
  disc.velocity = {1.7, 0.4, 0.0};
  disc.color = {0.8f, 0.4f, 0.2f, 1.0f};
  const int samples = 64;
  const Image image = stage.render(samples).image;
  int partly = 0;
  for_each_pixel(stage.scene.film, [&](int x, int y) {
    // The pixel's point in the disc's plane leaves and enters where |p − velocity·t| = radius, t = τ − ½.
    const Eigen::Vector2d p((x + 0.5 - 24.0) / 32.0 * 3.0 - 0.1, (y + 0.5 - 16.0) / 32.0 * 3.0 - 0.05);
    const Eigen::Vector2d m = disc.velocity.head<2>();
    const double across = (p.x() * m.y() - p.y() * m.x()) / m.norm();
    double covered = 0.0;
    if (std::abs(across) < radius) {
      const double middle = p.dot(m) / m.squaredNorm();
      const double half = std::sqrt(radius * radius - across * across) / m.norm();
      covered = std::max(0.0, std::min(0.5, middle + half) - std::max(-0.5, middle - half));
    }
    // An interval holds its length over the stratum's width of midpoints, give or take less than one.
    const Vector4d expected = covered * disc.color.cast<double>();
    EXPECT_LE((pixel(image, x, y) - expected).cwiseAbs().maxCoeff(), 1.0 / samples + float_rounding);
    partly += covered > 0.0 && covered < 1.0;
  });
  EXPECT_GT(partly, 200);  // the disc sweeps 288 px², and none of them for the whole time
}

TEST(Reference, SoftStreakIsTheIntegralOfItsGaussian) {
  Stage stage;
  stage.scene.model.edge_weight = 1.0;  // and so a lone kernel's coverage is ρ itself
  const double delta = stage.scene.model.delta = 20.0;
  MovingKernel& disc = stage.add_facing({0.0, 0.0, 4.0}, 1.0);
  disc.velocity = {2.0, 0.0, 0.0};
  const int samples = 512;
  const Image image = stage.render(samples).image;
  // The midpoint rule: at each end of the tube half a stratum of e^−δ, and h²/24 · max|f''|, f'' being at
  // most 2δ·speed² for exp(−δ·speed²·t²).
  const double bound = std::exp(-delta) / samples + 2.0 * delta * 4.0 / (24.0 * samples * samples);
  for_each_pixel(stage.scene.film, [&](int x, int y) {
    const double u = (x + 0.5 - 24.0) / 8.0, v = (y + 0.5 - 16.0) / 8.0;
    double expected = 0.0;
    if (v * v < 1.0) {
      const double chord = std::sqrt(1.0 - v * v);
      const double first = std::clamp(-1.0 - u, -chord, chord), last = std::clamp(1.0 - u, -chord, chord);
      expected = std::exp(-delta * v * v) * std::sqrt(std::acos(-1.0) / delta) / (2.0 * disc.velocity.x()) *
                 (std::erf(std::sqrt(delta) * last) - std::erf(std::sqrt(delta) * first));
    }
    EXPECT_NEAR(pixel(image, x, y).w(), expected, bound + float_rounding);
  });
}

TEST(Reference, SurfaceIsTheWeightedMeanOfItsFragments) {
  Stage stage;
  stage.scene.model.coverage = Coverage::hard;
  MovingKernel& left = stage.add_facing({-0.2, 0.0, 4.0}, 1.0);
  left.color = {1.0f, 0.0f, 0.25f, 1.0f};
  left.weight = 0.5f;
  MovingKernel& right = stage.add_facing({0.3, 0.0, 4.0}, 1.0);
  right.color = {0.0f, 1.0f, 0.25f, 1.0f};
  const Image image = stage.render().image;
  for (const int x : {20, 23, 24, 28}) {
    const double at = (x + 0.5 - 24.0) / 8.0, y = 0.5 / 8.0;
    const double of_left = 0.5 * std::exp(-3.0 * ((at + 0.2) * (at + 0.2) + y * y));
    const double of_right = std::exp(-3.0 * ((at - 0.3) * (at - 0.3) + y * y));
    const double share = of_left / (of_left + of_right);
    EXPECT_LE((pixel(image, x, 16) - Vector4d(share, 1.0 - share, 0.25, 1.0)).cwiseAbs().maxCoeff(),
              float_rounding);
  }
}

TEST(Reference, ToleranceOfTheNearestFragmentMakesTheSurface) {
  Stage stage;
  stage.scene.model.coverage = Coverage::hard;
  // Very large discs: ρ is 1 to within δ·(depth / 10⁵)² everywhere.
  const auto add = [&](double depth, Eigen::Vector4f color) {
    MovingKernel& kernel = stage.add_facing({0.0, 0.0, depth}, 1e5);
    kernel.color = color;
    kernel.depth_tolerance = 1.0f;
  };
  add(2.25, {0.0f, 0.0f, 0.5f, 0.5f});  // within the tolerance of the second, but not of the nearest
  add(1.5, {0.0f, 1.0f, 0.0f, 1.0f});
  add(1.0, {0.0f, 0.0f, 0.0f, 0.0f});
  const Image image = stage.render().image;
  // Front: half of {1.0, 1.5}, opacity ½; what shows through it is half of 2.25, and half of nothing.
  EXPECT_LE((pixel(image, 24, 16) - Vector4d(0.0, 0.5, 0.25, 0.75)).cwiseAbs().maxCoeff(), float_rounding);
  EXPECT_NEAR(depth_at(image, 24, 16), (0.5 * 1.25 + 0.25 * 2.25) / 0.75, 4 * float_rounding);
}

TEST(Reference, OpaqueSurfaceHidesWhatIsBehindIt) {
  Stage stage;
  stage.scene.model.coverage = Coverage::hard;
  stage.scene.background.setOnes();
  stage.add_facing({0.0, 0.0, 3.0}, 1e5).color = {0.0f, 1.0f, 0.0f, 1.0f};
  stage.add_facing({0.0, 0.0, 2.0}, 1e5).color = {1.0f, 0.0f, 0.0f, 1.0f};
  const Rendered rendered = stage.render();
  EXPECT_EQ(pixel(rendered.image, 24, 16), Vector4d(1.0, 0.0, 0.0, 1.0));
  EXPECT_EQ(depth_at(rendered.image, 24, 16), 2.0f);
  EXPECT_EQ(counter(rendered, "surfaces"), 48.0 * 32.0);
}

TEST(Reference, FloorThroughTheEyeIsSeenFromTheNearPlaneOn) {
  Stage stage;
  stage.scene.model.coverage = Coverage::hard;
  stage.set.near = 4.0;
  stage.add({0.0, 1.0, 0.0}, {0.0, 0.0, 10.0}, {10.0, 0.0, 0.0});
  const Image image = stage.render().image;
  int seen = 0;
  for_each_pixel(stage.scene.film, [&](int x, int y) {
    const double dx = (x + 0.5 - 24.0) / 32.0, dy = (y + 0.5 - 16.0) / 32.0;
    const double depth = 1.0 / dy;  // the plane y = 1
    const bool expected = depth >= 4.0 && depth * depth * (dx * dx + 1.0) <= 100.0;
    EXPECT_EQ(pixel(image, x, y).w(), expected ? 1.0 : 0.0) << x << ", " << y;
    seen += expected;
  });
  EXPECT_GT(seen, 100);
}

TEST(Reference, OneSidedDiscIsSeenWhereItFacesTheRay) {
  Stage stage;
  stage.scene.model.coverage = Coverage::hard;
  stage.add_facing({0.0, 0.0, 4.0}, 1e5).facing = {-1.0f, 0.0f, -0.25f};
  const Image image = stage.render().image;
  for_each_pixel(stage.scene.film, [&](int x, int y) {
    const double facing_along_ray = -(x + 0.5 - 24.0) / 32.0 - 0.25;
    EXPECT_EQ(pixel(image, x, y).w(), facing_along_ray < 0.0 ? 1.0 : 0.0) << x << ", " << y;
  });
}

TEST(Reference, SegmentsTakeTurns) {
  Stage stage;
  stage.scene.model.coverage = Coverage::hard;
  for (const bool second : {false, true}) {
    MovingKernel& kernel = stage.add_facing({0.0, 0.0, 2.0}, 1e5);
    kernel.t_begin = second ? 0.25f : 0.0f;
    kernel.t_end = second ? 1.0f : 0.25f;
    kernel.color = second ? Eigen::Vector4f(0, 1, 0, 1) : Eigen::Vector4f(1, 0, 0, 1);
  }
  // 32 strata: a quarter of them before τ = ¼. Two samples: at τ = ¼, where only the second exists, and ¾.
  EXPECT_EQ(pixel(stage.render(32).image, 24, 16), Vector4d(0.25, 0.75, 0.0, 1.0));
  EXPECT_EQ(pixel(stage.render(2).image, 24, 16), Vector4d(0.0, 1.0, 0.0, 1.0));
}

TEST(Reference, BoxHoldsEveryPixelThatMeetsTheDisc) {
  const Stage stage = crowd(7, 400);
  const reference::PixelBox film{0, 0, 48, 32};
  int met = 0;
  for (const MovingKernel& kernel : stage.set.kernels) {
    for (const double tau : {0.0, 0.4, 1.0}) {
      const reference::Disc disc = reference::place(kernel, tau, stage.set.projection, stage.set.near, film);
      for_each_pixel(stage.scene.film, [&](int x, int y) {
        if (!meet(disc, reference::ray_through(stage.set.projection, x, y), stage.set.near, 3.0)) return;
        EXPECT_TRUE(x >= disc.box.x_begin && x < disc.box.x_end && y >= disc.box.y_begin &&
                    y < disc.box.y_end);
        ++met;
      });
    }
  }
  EXPECT_GT(met, 10000);
}

TEST(Reference, OrderOfKernelsChangesNoBit) {
  Stage stage = crowd(1, 300);
  // Copies that differ in colour or tolerance alone are equally near everywhere.
  for (int i = 0; i < 60; ++i) {
    MovingKernel copy = stage.set.kernels[static_cast<std::size_t>(i)];
    i % 2 ? copy.color = {0.1f, 0.9f, 0.0f, 0.9f} : copy.color *= 0.5f;
    if (i % 3 == 0) copy.depth_tolerance = 0.5f;
    stage.set.kernels.push_back(copy);
  }
  const Image image = stage.render(8).image;
  std::mt19937 random(2);
  std::shuffle(stage.set.kernels.begin(), stage.set.kernels.end(), random);
  const Image shuffled = stage.render(8).image;
  EXPECT_TRUE(same_bits(image.rgba, shuffled.rgba));
  EXPECT_TRUE(same_bits(image.depth, shuffled.depth));
}

TEST(Reference, ThreadsChangeNoBit) {
  const Stage stage = crowd(3, 300);
  const Image alone = stage.render(8, 1).image;
  for (const int threads : {2, 7, 0}) {
    const Image together = stage.render(8, threads).image;
    EXPECT_TRUE(same_bits(alone.rgba, together.rgba)) << threads;
    EXPECT_TRUE(same_bits(alone.depth, together.depth)) << threads;
  }
}

TEST(Reference, CropIsAWindowOfTheWholeFilm) {
  Stage stage = crowd(4, 300);
  const Image whole = stage.render(8).image;
  Film& film = stage.scene.film;
  film.crop_x = 5, film.crop_y = 3, film.crop_width = 37, film.crop_height = 21;
  const Image crop = stage.render(8).image;
  ASSERT_EQ(crop.width, 37);
  ASSERT_EQ(crop.height, 21);
  EXPECT_EQ(crop.film_width, 48);
  EXPECT_TRUE(test::is_crop_of(crop, whole, film));
}

/// Hard streaks in many directions, side by side, so that coverage jumps at many unrelated instants.
Stage streaks() {
  Stage stage;
  stage.scene.film = {256, 192, 0, 0, 0, 0};
  stage.set.projection = projection_of(stage.scene.film, 0.5);
  stage.scene.model.coverage = Coverage::hard;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 12; ++i) {
    const Vector3d center(-2.0 + 4.0 * (i % 4) / 3.0, -1.2 + 1.2 * (i / 4), 4.0);
    stage.add_facing(center, 0.25).velocity = {0.4 * unit(random), 0.4 * unit(random), 0.0};
  }
  return stage;
}

TEST(Reference, EstimatesItsOwnError) {
  const Stage stage = streaks();
  // It errs 1/32 as much as the better of the two images below, and so adds a thousandth to the squared
  // error.
  const Image truth = stage.render(2048).image;
  for (const int samples : {16, 64}) {
    const Rendered rendered = stage.render(samples);
    double squares = 0.0;
    for (std::size_t i = 0; i < truth.rgba.size(); ++i) {
      const double difference = double(rendered.image.rgba[i]) - double(truth.rgba[i]);
      if (i % 4 != 3) squares += difference * difference;
    }
    const double actual = std::sqrt(squares / (3.0 * static_cast<double>(truth.pixel_count())));
    const double estimate = counter(rendered, "reference_error_rmse");
    RecordProperty("error_" + std::to_string(samples), std::to_string(actual));
    RecordProperty("estimate_" + std::to_string(samples), std::to_string(estimate));
    EXPECT_NEAR(counter(rendered, "reference_error_psnr_db"), -20.0 * std::log10(estimate), 1e-9);
    // The mean of n squared sawtooths has a relative deviation of √(0.8/n), its root half of that: under half
    // a percent for the 10⁴ pixels that jump here. This is ten times as much, for neighbours are related.
    EXPECT_NEAR(estimate / actual, 1.0, 0.05) << samples << " samples err " << actual;
  }
}

TEST(Reference, RefusesOptionsOutOfRange) {
  const Stage stage;
  for (const int samples : {-2, 0, 1, 3, 255, (1 << 20) + 2}) {
    const auto rendered = render_reference(stage.set, stage.scene, {samples, ReferenceMotion::segments});
    ASSERT_FALSE(rendered.ok()) << samples;
    EXPECT_EQ(rendered.error().field, "samples");
  }
  for (const int threads : {-1, 1025}) {
    const auto rendered = render_reference(stage.scene, {2, ReferenceMotion::smooth}, {.threads = threads});
    ASSERT_FALSE(rendered.ok());
    EXPECT_EQ(rendered.error().field, "threads");
  }
  Stage bad;
  bad.scene.model.delta = 0.0;
  EXPECT_FALSE(render_reference(bad.set, bad.scene, {}).ok());
}

}  // namespace
}  // namespace swept
