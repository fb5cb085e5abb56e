// When the places of a pixel meet a triangle on straight paths, all at once: held to what each finds by
// itself, bit by bit, for every instruction set.
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/simd/edge_math.h"
#include "abuffer/sources/triangle_stretch.h"
#include "splat/scene.h"

namespace swept {
namespace {

std::array<char, sizeof(DepthChords)> bytes_of(const DepthChords& chords) {
  return std::bit_cast<std::array<char, sizeof(DepthChords)>>(chords);
}

struct Counts {
  int triangles = 0, met = 0, twice = 0, unknown = 0;
};

class PlacesAtOnce : public testing::Test {
 protected:
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }

  /// A triangle of about that size, in pixels, before a pixel of which `x` and `y` are the rays; corners may
  /// lie on the rays' very columns, and move along them.
  Object triangle(double size_px, double speed_px, bool on_grid, bool two_sided) {
    Object object;
    object.two_sided = two_sided;
    object.cloud.keys.resize(1);
    const auto px = [&](double most) {
      const double v = uniform(-most, most);
      return on_grid ? std::round(v * 16.0) / 16.0 + 1.0 / 32.0 : v;
    };
    for (std::uint32_t i = 0; i < 3; ++i) {
      const double z = on_grid ? 2.0 : uniform(2.0, 4.0);
      object.cloud.keys.front().pose.position.push_back(
          {px(size_px) * pixel * z, px(size_px) * pixel * z, z});
      object.cloud.keys.front().pose.axis_u.emplace_back(0.1f, 0.0f, 0.0f);
      object.cloud.keys.front().pose.axis_v.emplace_back(0.0f, 0.1f, 0.0f);
      object.cloud.color.emplace_back(1.0f, 1.0f, 1.0f);
      object.cloud.velocity.emplace_back(static_cast<float>(uniform(-speed_px, speed_px) * pixel * z),
                                         static_cast<float>(uniform(-speed_px, speed_px) * pixel * z),
                                         on_grid ? 0.0f : static_cast<float>(uniform(-1.0, 1.0)));
    }
    object.triangles = {{0, 1, 2}};
    return object;
  }

  void compare(const Object& object, Counts& counts) {
    Scene scene;
    scene.shutter = {0.0, 1.0};
    scene.objects = {object};
    const Result<MovingMesh> mesh = MovingMesh::follow(scene, scene.objects[0], scene.exposure(), 0.01, {});
    ASSERT_TRUE(mesh.ok());
    double x[pixel_places], y[pixel_places];
    for (int k = 0; k < pixel_places; ++k)
      x[k] = pixel * double{places_in_pixel.x[k]}, y[k] = pixel * double{places_in_pixel.y[k]};
    const RaysOfPixel rays{x, y};
    for (std::size_t s = 0; s < mesh->stretches(); ++s) {
      const TriangleStretch stretch(*mesh, 0, s, 0, scene.camera.near);
      if (!stretch.straight()) continue;
      ++counts.triangles;
      const double from = uniform(0.0, 0.3), to = uniform(0.7, 1.0);
      const EdgeMaths maths = edge_maths();
      for (std::size_t m = 0; m < maths.count; ++m) {
        MetPlaces met;
        maths.first[m].meet(stretch.straight_edges(), x, y, met);
        ASSERT_EQ((met.above | met.below) & met.unknown, 0u);
        for (std::uint32_t k = 0; k < pixel_places; ++k) {
          std::vector<PlaceInterval> alone, at_once;
          stretch.meet(rays[k], from, to, k, 0, alone);
          if (m == 0) {
            counts.met += alone.empty() ? 0 : 1;
            counts.twice += alone.size() > 1 ? 1 : 0;
            counts.unknown += static_cast<int>(met.unknown >> k & 1);
          }
          if ((met.unknown >> k & 1) != 0) continue;
          if (((met.above | met.below) >> k & 1) != 0) stretch.keep(rays[k], from, to, met, k, k, 0, at_once);
          ASSERT_EQ(alone.size(), at_once.size()) << maths.first[m].name << ", place " << k;
          for (std::size_t i = 0; i < alone.size(); ++i) {
            ASSERT_EQ(alone[i].begin, at_once[i].begin) << maths.first[m].name;
            ASSERT_EQ(alone[i].end, at_once[i].end) << maths.first[m].name;
            ASSERT_EQ(alone[i].nearest, at_once[i].nearest) << maths.first[m].name;
            ASSERT_EQ(alone[i].farthest, at_once[i].farthest) << maths.first[m].name;
          }
        }
      }
    }
  }

  static constexpr double pixel = 1.0 / 512.0;

 private:
  std::mt19937_64 random_{7};
};

TEST_F(PlacesAtOnce, FindWhatEachPlaceFindsByItself) {
  Counts counts;
  for (int i = 0; i < 6000; ++i)
    compare(triangle(i % 3 == 0 ? 0.3 : 2.0, i % 5 == 0 ? 20.0 : 2.0, false, i % 2 == 0), counts);
  EXPECT_GT(counts.met, 10000);
  EXPECT_GT(counts.twice, 20);
  // Where one edge lets a place go and takes it back the others seldom let it stay.
  EXPECT_LT(counts.unknown, counts.triangles * pixel_places / 10);
}

/// Zeros among the coefficients, edges that lie on a ray all the time, and triangles without an area.
TEST_F(PlacesAtOnce, DoSoOnEdgesToo) {
  Counts counts;
  for (int i = 0; i < 6000; ++i) compare(triangle(0.6, i % 2 == 0 ? 0.0 : 1.0, true, true), counts);
  EXPECT_GT(counts.met, 5000);
  EXPECT_GT(counts.unknown, 0);
}

/// Depths lie within the chord's bow, ends and middle on them, and every instruction set says the same.
TEST_F(PlacesAtOnce, HoldDepthsByTheirChords) {
  int intervals = 0, straight = 0, bent = 0;
  for (int i = 0; i < 3000; ++i) {
    Scene scene;
    scene.shutter = {0.0, 1.0};
    scene.objects = {triangle(2.0, 4.0, false, true)};
    const Result<MovingMesh> mesh = MovingMesh::follow(scene, scene.objects[0], scene.exposure(), 0.01, {});
    ASSERT_TRUE(mesh.ok());
    const TriangleStretch stretch(*mesh, 0, 0, 0, scene.camera.near);
    ASSERT_TRUE(stretch.on_lines());
    const Eigen::Vector3d ray(uniform(-pixel, pixel), uniform(-pixel, pixel), 1.0);
    std::vector<PlaceInterval> found;
    stretch.meet(ray, uniform(0.0, 0.5), 1.0, 0, 0, found);
    for (const PlaceInterval& interval : found) {
      DepthChords chords{};
      for (int lane = 0; lane < DepthChords::most; ++lane) {
        // One after another of the interval's parts, the last of which is all of it.
        const double shorter = lane + 1 < DepthChords::most ? 0.1 * lane : 0.0;
        chords.since[lane] = stretch.begin, chords.until[lane] = stretch.end;
        chords.begin[lane] = interval.begin + shorter * (interval.end - interval.begin);
        chords.end[lane] = interval.end;
        chords.nearest[lane] = double{interval.nearest}, chords.farthest[lane] = double{interval.farthest};
        stretch.depth(ray, lane, chords);
      }
      const EdgeMaths maths = edge_maths();
      DepthChords plain = chords;
      maths.first[0].chords(plain);
      for (std::size_t m = 1; m < maths.count; ++m) {
        DepthChords other = chords;
        maths.first[m].chords(other);
        EXPECT_EQ(bytes_of(other), bytes_of(plain)) << maths.first[m].name;
      }
      ++intervals;
      for (int lane = 0; lane < DepthChords::most; ++lane) {
        if (!std::isfinite(plain.bow[lane])) continue;
        (plain.bow[lane] > 1e-4 ? bent : straight)++;
        EXPECT_DOUBLE_EQ(plain.per_time[lane], 1.0 / (plain.end[lane] - plain.begin[lane]));
        for (int k = 0; k <= 8; ++k) {
          const double u = k / 8.0,
                       z = stretch.look(ray, plain.begin[lane] + u * (plain.end[lane] - plain.begin[lane]))
                               .depth,
                       chord = plain.z_begin[lane] + u * (plain.z_end[lane] - plain.z_begin[lane]);
          // Rounding is larger where a triangle is seen from its edge, and its bow is, too.
          const double rounding = 1e-7 * (z + plain.bow[lane]);
          EXPECT_LE(std::abs(z - chord), u * (1.0 - u) * plain.bow[lane] + rounding);
          if (k != 4) continue;
          EXPECT_NEAR(z, plain.z_middle[lane], rounding);
        }
      }
    }
  }
  EXPECT_GT(intervals, 300);
  EXPECT_GT(straight, 100);
  EXPECT_GT(bent, 100);
}

/// Of coefficients whose squares are out of range nothing is said.
TEST_F(PlacesAtOnce, LeaveTheVerySmallAndTheVeryLargeAlone) {
  for (const double size : {1e-160, 1e160, std::nan("")}) {
    const double normals[9] = {size, 0.0, size, size, 0.0, -size, size, 0.0, size};
    double x[pixel_places], y[pixel_places];
    for (int k = 0; k < pixel_places; ++k) x[k] = y[k] = 0.001 * k;
    const EdgeMaths maths = edge_maths();
    for (std::size_t m = 0; m < maths.count; ++m) {
      MetPlaces met;
      maths.first[m].meet({{normals, normals, normals}, true, true}, x, y, met);
      EXPECT_EQ(met.unknown, 0xffffu) << maths.first[m].name;
      EXPECT_EQ(met.above | met.below, 0u) << maths.first[m].name;
    }
  }
}

}  // namespace
}  // namespace swept
