// Moving triangles by the exact method (model section 15): beside the engine that looks at many instants, and
// what can be told without it.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <random>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/sources/triangle_stretch.h"
#include "tests/counter.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/mesh_scenes.h"
#include "tests/scene_text.h"

namespace swept {
namespace {

using test::add_point;
using test::exact;
using test::psnr_db;
using test::rectangle;
using test::sampled;

Scene stage(int width = 40, int height = 30) { return test::mesh_stage(width, height, 30.0 / 64.0); }

/// Both in one mesh; velocities too.
Object together(const Object& a, const Object& b) {
  Object both = a;
  const auto first = static_cast<std::uint32_t>(a.cloud.size());
  for (std::size_t i = 0; i < b.cloud.size(); ++i) {
    add_point(both, b.cloud.keys[0].pose.position[i], b.cloud.color[i]);
    if (!b.cloud.velocity.empty()) both.cloud.velocity.push_back(b.cloud.velocity[i]);
    if (!b.cloud.acceleration.empty()) both.cloud.acceleration.push_back(b.cloud.acceleration[i]);
  }
  for (const Triangle& t : b.triangles) both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return both;
}

void turn(Object& object, const Eigen::Vector3d& axis, double radians) {
  TransformKey first, last;
  last.frame = 1.0;
  first.rotate_axis = last.rotate_axis = axis.normalized();
  last.rotate_radians = radians;
  object.transform.keys = {first, last};
}

/// Blades about the z axis, two-coloured.
Object fan(int blades) {
  Object object;
  for (int i = 0; i < blades; ++i) {
    const double a = 2.0 * M_PI * i / blades, b = a + M_PI / blades;
    const Eigen::Vector3f color =
        i % 2 == 0 ? Eigen::Vector3f(1.0f, 0.3f, 0.1f) : Eigen::Vector3f(0.1f, 0.4f, 1.0f);
    const std::uint32_t first = add_point(object, {0.0, 0.0, 0.0}, color);
    add_point(object, {std::cos(a), std::sin(a), 0.1}, color);
    add_point(object, {std::cos(b), std::sin(b), -0.1}, color);
    object.triangles.push_back({first, first + 1, first + 2});
  }
  return object;
}

TEST(ExactMeshes, AreTheMeanOfManyInstants) {
  for (const bool transparent : {false, true})
    for (const bool turning : {false, true})
      for (const bool two_sided : {false, true}) {
        Scene scene = stage();
        scene.objects = {test::triangle_soup(40, 7, transparent)};
        scene.objects[0].two_sided = two_sided;
        if (turning) {
          turn(scene.objects[0], {1, 2, 3}, 0.4);
          for (TransformKey& key : scene.objects[0].transform.keys) key.scale = {-1.0, 1.0, 1.0};
        }
        const Rendered rendered = exact(scene);
        const Image &image = rendered.image, truth = sampled(scene, 1024);
        EXPECT_GT(psnr_db(image, truth), 70.0) << transparent << turning << two_sided;
        EXPECT_EQ(test::counter(rendered, "path_degree"), turning ? 2.0 : 1.0);
        for (std::size_t i = 0; i < truth.depth.size(); ++i) {
          if (!(truth.rgba[4 * i + 3] > 0.5f)) continue;
          EXPECT_NEAR(image.depth[i], truth.depth[i], 0.01 * double{truth.depth[i]});
        }
      }
}

/// Paths of each degree there is, shutters of each shape, rows that are exposed one after the other.
TEST(ExactMeshes, FollowAnyMotionAndAnyShutter) {
  const std::vector<std::pair<const char*, std::function<void(Scene&)>>> cases = {
      {"acceleration",
       [](Scene& s) {
         s.objects[0].cloud.acceleration.assign(s.objects[0].cloud.size(), {0.8f, -0.4f, 0.6f});
       }},
      {"spline",
       [](Scene& s) {
         SurfelCloud& cloud = s.objects[0].cloud;
         for (const double frame : {0.4, 0.7, 1.3}) {
           SurfelKey key = cloud.keys[0];
           key.frame = frame;
           for (std::size_t i = 0; i < cloud.size(); ++i)
             key.pose.position[i] +=
                 (cloud.velocity[i] * static_cast<float>(frame * (1.0 + std::sin(9.0 * frame))))
                     .cast<double>();
           cloud.keys.push_back(key);
         }
         cloud.velocity.clear();
         cloud.path = KeyPath::spline;
       }},
      {"a curve of degree 5",
       [](Scene& s) {
         SurfelCloud& cloud = s.objects[0].cloud;
         for (int k = 1; k <= 5; ++k) {
           SurfelKey key = cloud.keys[0];
           key.frame = 0.2 * k;
           for (std::size_t i = 0; i < cloud.size(); ++i)
             key.pose.position[i] +=
                 (cloud.velocity[i] * static_cast<float>(k % 2 == 0 ? 1.0 : -0.5)).cast<double>();
           cloud.keys.push_back(key);
         }
         cloud.velocity.clear();
         cloud.path = KeyPath::bezier;
       }},
      {"a camera that moves and turns",
       [](Scene& s) {
         LookAtKey last = s.camera.look_ats[0];
         last.frame = 1.0;
         last.eye += Eigen::Vector3d(0.3, 0.1, 0.2);
         last.roll_radians = 0.5;
         last.tan_half_fov_y *= 1.1;
         s.camera.look_ats.push_back(last);
       }},
      {"a Gaussian shutter", [](Scene& s) { s.shutter.curve = ShutterShape::gaussian; }},
      {"a trapezoid", [](Scene& s) { s.shutter.curve = ShutterShape::trapezoid; }},
      {"several meshes",
       [](Scene& s) {
         s.objects.push_back(test::triangle_soup(15, 31, true));
         s.objects.push_back(test::triangle_soup(10, 32, false, 0.0));
       }},
  };
  for (const auto& [name, change] : cases) {
    Scene scene = stage();
    scene.objects = {test::triangle_soup(30, 9, true)};
    change(scene);
    EXPECT_GT(psnr_db(exact(scene).image, sampled(scene, 1024)), 70.0) << name;
  }
}

TEST(ExactMeshes, AreTheMeanWhereNobodyChoseThem) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Scene scene = stage(24, 18);
    scene.objects = {test::triangle_soup(15 + static_cast<int>(seed) % 20, seed, seed % 3 == 0)};
    if (seed % 4 == 0) scene.objects.push_back(test::triangle_soup(8, seed + 100, seed % 8 == 0));
    scene.objects[0].two_sided = seed % 2 == 0;
    if (seed % 3 == 1) turn(scene.objects[0], {0.2, 0.1, 1.0}, 1.5);
    // Corners on a coarse grid: edges along rays, triangles without an area, equal depths.
    if (seed % 5 == 0)
      for (Eigen::Vector3d& p : scene.objects[0].cloud.keys[0].pose.position)
        p = (p * 4.0).array().round() / 4.0;
    EXPECT_GT(psnr_db(exact(scene).image, sampled(scene, 512)), 62.0) << seed;
  }
}

/// Rönnow et al. 2021, Fig. 11: two rectangles that change places in depth half-way, in one mesh and in two.
TEST(ExactMeshes, ThatCrossInDepthShareTheExposure) {
  Object near = rectangle({0, 0, 2.0}, 3.0, 3.0, {1, 0, 0}),
         far = rectangle({0, 0, 3.0}, 4.0, 4.0, {0, 0, 1});
  test::move_points(near, {0, 0, 1});
  test::move_points(far, {0, 0, -1});
  for (const bool one_mesh : {true, false}) {
    Scene scene = stage();
    scene.objects = {near, far};
    if (one_mesh) scene.objects = {together(near, far)};
    const Image image = exact(scene).image;
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      ASSERT_NEAR(image.rgba[4 * i], 0.5, 1e-6) << one_mesh;
      ASSERT_NEAR(image.rgba[4 * i + 2], 0.5, 1e-6);
      ASSERT_NEAR(image.rgba[4 * i + 3], 1.0, 1e-6);
      ASSERT_NEAR(image.depth[i], 2.25, 1e-5);
    }
  }
}

/// Gribel et al. 2013, Fig. 7: a triangle comes to the front and goes back while another passes between where
/// it is at the ends and where it is in the middle. A depth that is a line from end to end would hide it.
TEST(ExactMeshes, JoJoHidesWhatItPassesInFrontOf) {
  for (const bool one_mesh : {true, false}) {
    Object red = rectangle({0, 0, 4.0}, 9.0, 9.0, {1, 0, 0}),
           blue = rectangle({0, 0, 3.0}, 9.0, 9.0, {0, 0, 1});
    // z = 4 − 8τ + 8τ²: in front of 3 while τ² − τ + 1/8 < 0, for √½ of the time.
    test::move_points(red, {0, 0, -8});
    red.cloud.acceleration.assign(4, {0, 0, 16});
    test::move_points(blue, {0.5, 0, 0});
    blue.cloud.acceleration.assign(4, {0, 0, 0});
    Scene scene = stage();
    scene.objects = {red, blue};
    if (one_mesh) scene.objects = {together(red, blue)};
    const Image image = exact(scene).image;
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      ASSERT_NEAR(image.rgba[4 * i], std::sqrt(0.5), 1e-6) << one_mesh;
      ASSERT_NEAR(image.rgba[4 * i + 2], 1.0 - std::sqrt(0.5), 1e-6);
    }
  }
}

/// Gribel et al. 2013, Fig. 3: turned by 90° a triangle does not shrink on the way. A place at a distance r
/// from the axis sees a blade of half a turn less or more for as long as its angle takes.
TEST(ExactMeshes, KeepTheirShapeThroughAQuarterTurn) {
  Scene scene = stage(60, 60);
  scene.objects = {rectangle({0, 0, 0}, 0.6, 0.05, {1, 1, 1})};
  turn(scene.objects[0], {0, 0, 1}, 0.5 * M_PI);
  for (TransformKey& key : scene.objects[0].transform.keys) key.translate = {0, 0, 2.0};
  const Image image = exact(scene).image;
  EXPECT_GT(psnr_db(image, sampled(scene, 2048)), 70.0);
  // All of the light of the bar is its area, at each instant; along chords it would lose a third of it.
  // Places count an area to about a thousandth.
  double light = 0.0;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) light += double{image.rgba[4 * i + 3]};
  const double focal = 30.0 / (30.0 / 64.0), area = 4.0 * 0.6 * 0.05 * std::pow(focal / 2.0, 2);
  EXPECT_NEAR(light, area, 1e-3 * area);
}

TEST(ExactMeshes, AreARotatingFan) {
  Scene scene = stage(60, 60);
  scene.objects = {fan(14)};
  turn(scene.objects[0], {0.1, 0.2, 1.0}, 2.0);
  for (TransformKey& key : scene.objects[0].transform.keys) key.translate = {0, 0, 2.5};
  EXPECT_GT(psnr_db(exact(scene).image, sampled(scene, 1024)), 70.0);
}

/// A sheet of many triangles of all shapes covers every place once at all times: no gap, and where it lets
/// half of the light through no seam.
TEST(ExactMeshes, MeetWithoutGapsAndOverlaps) {
  for (const float opacity : {1.0f, 0.5f}) {
    Scene scene = stage(60, 45);
    std::mt19937 random(5);
    const auto jitter = [&] { return 0.4 * (static_cast<double>(random()) / 4294967296.0 - 0.5); };
    Object object;
    constexpr int side = 30;
    for (int i = 0; i <= side; ++i)
      for (int j = 0; j <= side; ++j)
        add_point(object,
                  {0.12 * (i - side / 2 + jitter()), 0.1 * (j - side / 2 + jitter()), 1.0 + 0.1 * jitter()},
                  {0.25f, 0.5f, 1.0f});
    for (std::uint32_t i = 0; i < side; ++i)
      for (std::uint32_t j = 0; j < side; ++j) {
        const std::uint32_t a = i * (side + 1) + j, b = a + 1, c = a + side + 1, d = c + 1;
        object.triangles.push_back({a, c, b});
        object.triangles.push_back({b, c, d});
      }
    object.cloud.opacity.assign(object.cloud.size(), opacity);
    test::move_points(object, {0.3f, 0.1f, 0.05f});
    scene.objects = {object};
    const Image image = exact(scene).image;
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      ASSERT_NEAR(image.rgba[4 * i + 3], opacity, 1e-7) << i;
      ASSERT_NEAR(image.rgba[4 * i + 2], opacity, 1e-7) << i;
    }
  }
}

TEST(ExactMeshes, HaveTheSameBitsHoweverTheyAreDrawn) {
  Scene scene = stage(60, 50);
  scene.objects = {test::triangle_soup(40, 21, true), test::triangle_soup(20, 22, false),
                   test::triangle_soup(10, 23, true)};
  turn(scene.objects[1], {1, 0, 1}, 0.7);
  const Image first = exact(scene).image;
  EXPECT_EQ(exact(scene, {}, 1).image.rgba, first.rgba);
  AbufferOptions options;
  options.tile_px = 7;
  EXPECT_EQ(exact(scene, options).image.rgba, first.rgba);
  options = {};
  options.tile_fragments = 500;
  const Rendered split = exact(scene, options);
  EXPECT_GT(test::counter(split, "tiles_split"), 0.0);
  EXPECT_EQ(split.image.rgba, first.rgba);
  EXPECT_EQ(split.image.depth, first.depth);
  std::swap(scene.objects[0], scene.objects[2]);
  EXPECT_EQ(exact(scene).image.rgba, first.rgba);
  scene.film.crop_x = 13, scene.film.crop_y = 10, scene.film.crop_width = 30, scene.film.crop_height = 27;
  const Image crop = exact(scene).image;
  EXPECT_TRUE(test::is_crop_of(crop, first, scene.film));
}

/// A row of a rolling shutter is that row of the scene exposed later.
TEST(ExactMeshes, RollWithTheShutter) {
  Scene scene = stage();
  scene.objects = {test::triangle_soup(30, 9, true)};
  scene.shutter.row_delay = 0.02;
  const Image rolling = exact(scene).image;
  scene.shutter.row_delay = 0.0;
  for (const int y : {0, 7, 29}) {
    scene.shutter.open = 0.02 * y;
    scene.shutter.close = 1.0 + 0.02 * y;
    const Image row = exact(scene).image;
    for (std::size_t i = 4 * static_cast<std::size_t>(y * 40); i < 4 * static_cast<std::size_t>(y * 40 + 40);
         ++i)
      ASSERT_NEAR(rolling.rgba[i], row.rgba[i], 1e-5) << y;
  }
}

TEST(ExactMeshes, StopSoon) {
  Scene scene = stage(640, 480);
  scene.camera.look_ats[0].tan_half_fov_y = 0.5;
  scene.objects = {test::triangle_soup(3000, 3, true, 2.0)};
  turn(scene.objects[0], {0, 0, 1}, 3.0);
  std::stop_source source;
  RenderControl control;
  control.stop = source.get_token();
  std::chrono::steady_clock::time_point asked;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    asked = std::chrono::steady_clock::now();
    source.request_stop();
  });
  const auto result = render_abuffer(scene, {}, control);
  const auto ended = std::chrono::steady_clock::now();
  stopper.join();
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().kind, ErrorKind::cancelled);
  // 100 ms on a machine of its own.
  EXPECT_LT(std::chrono::duration<double>(ended - asked).count(), 1.0);
}

/// Rönnow et al. 2021, section 4.1: over time an edge whose ends move straight is a bilinear patch, and a
/// moving triangle a prism of three of them. Where the ray meets a patch the triangle comes or goes.
std::vector<std::pair<double, double>> prism(const Eigen::Vector3d (&from)[3], const Eigen::Vector3d (&to)[3],
                                             const Eigen::Vector3d& ray) {
  const Eigen::Vector3d side = ray.unitOrthogonal(), up = ray.cross(side);
  const auto seen = [&](const Eigen::Vector3d& p) { return Eigen::Vector2d(side.dot(p), up.dot(p)); };
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  std::vector<double> hits;
  for (std::size_t i = 0; i < 3; ++i) {
    // p(t) + u (q(t) − p(t)) is on the ray: seen along it, at the origin.
    const std::size_t j = (i + 1) % 3;
    const Eigen::Vector2d p = seen(from[i]), dp = seen(to[i] - from[i]), e = seen(from[j] - from[i]),
                          de = seen(to[j] - to[i]) - e;
    const double a = cross(dp, de), b = cross(p, de) + cross(dp, e), c = cross(p, e),
                 root = std::sqrt(b * b - 4 * a * c);
    if (!(root >= 0.0)) continue;
    const double q = -0.5 * (b + std::copysign(root, b));
    for (const double t : {q / a, c / q}) {
      if (!(t > 0.0 && t < 1.0)) continue;
      const Eigen::Vector2d edge = e + t * de;
      const double u = -(p + t * dp).dot(edge) / edge.squaredNorm();
      if (u >= 0.0 && u <= 1.0) hits.push_back(t);
    }
  }
  std::sort(hits.begin(), hits.end());
  // The cap that the prism begins with.
  const Eigen::Vector2d a = seen(from[0]), b = seen(from[1]), c = seen(from[2]);
  const bool inside = (cross(a, b) > 0) == (cross(b, c) > 0) && (cross(b, c) > 0) == (cross(c, a) > 0);
  if (inside) hits.insert(hits.begin(), 0.0);
  if (hits.size() % 2 == 1) hits.push_back(1.0);
  std::vector<std::pair<double, double>> intervals;
  for (std::size_t i = 0; i + 1 < hits.size(); i += 2) intervals.emplace_back(hits[i], hits[i + 1]);
  return intervals;
}

TEST(ExactMeshes, HaveTheIntervalsOfPrisms) {
  std::mt19937_64 random(3);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 18446744073709551616.0);
  };
  Scene scene = stage();
  std::size_t met = 0, twice = 0;
  for (int i = 0; i < 20000; ++i) {
    Object object;
    Eigen::Vector3d from[3], to[3];
    for (std::size_t k = 0; k < 3; ++k) {
      from[k] = {uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(2.0, 4.0)};
      add_point(object, from[k], {1, 1, 1});
      object.cloud.velocity.emplace_back(static_cast<float>(uniform(-1.0, 1.0)),
                                         static_cast<float>(uniform(-1.0, 1.0)),
                                         static_cast<float>(uniform(-1.0, 1.0)));
      to[k] = from[k] + object.cloud.velocity.back().cast<double>();
    }
    object.triangles = {{0, 1, 2}};
    scene.objects = {object};
    const Result<MovingMesh> mesh = MovingMesh::follow(scene, scene.objects[0], scene.exposure(), 0.01, {});
    ASSERT_TRUE(mesh.ok());
    const Eigen::Vector3d ray(uniform(-0.2, 0.2), uniform(-0.2, 0.2), 1.0);
    std::vector<PlaceInterval> found;
    TriangleStretch(*mesh, 0, 0, 0, scene.camera.near).meet(ray, 0.0, 1.0, 0, 0, found);
    const auto expected = prism(from, to, ray);
    // Edge-on for an instant the triangle shows its other side: one interval of a prism is two that touch.
    std::vector<std::pair<double, double>> joined;
    for (const PlaceInterval& interval : found)
      if (!joined.empty() && interval.begin - joined.back().second < 1e-9)
        joined.back().second = interval.end;
      else
        joined.emplace_back(interval.begin, interval.end);
    ASSERT_EQ(joined.size(), expected.size()) << i;
    for (std::size_t k = 0; k < joined.size(); ++k) {
      ASSERT_NEAR(joined[k].first, expected[k].first, 1e-9);
      ASSERT_NEAR(joined[k].second, expected[k].second, 1e-9);
    }
    met += expected.empty() ? 0 : 1;
    twice += expected.size() > 1 ? 1 : 0;
  }
  EXPECT_GT(met, 3000u);
  EXPECT_GT(twice, 20u);
}

class ExactMeshFiles : public test::SceneFiles {};

/// Half a gait of a horse, in a frame, with 16,843 triangles.
TEST_F(ExactMeshFiles, AreARealHorse) {
  const char* data = std::getenv("SWEPT_DATA_DIR");
  if (data == nullptr) GTEST_SKIP() << "SWEPT_DATA_DIR is unset";
  Result<SceneFile> file = read_scene_file(write(
      R"({"swept": 1, "film": {"width": 64, "height": 48}, "shutter": {"open": 0, "close": 1}, "camera": {"fov":)"
      R"({"axis": "vertical", "degrees": 40}, "keys": [{"eye": [3.2, 0.7, -0.3], "target": [0, 0.7, -0.3],)"
      R"("up": [0, 1, 0]}]}, "objects": [{"source": {"sequence": ")" +
      std::filesystem::absolute(data).string() +
      R"(/horse/%04d.obj", "first": 1, "last": 12, "cycle": true},)"
      R"("draw": "triangles"}]})"));
  ASSERT_TRUE(file.ok()) << file.error().message();
  const auto loaded = file->scene_at(3.0, test::dots);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  EXPECT_GT(psnr_db(exact(**loaded).image, sampled(**loaded, 1024)), 70.0);
}

}  // namespace
}  // namespace swept
