// Meshes drawn as triangles (model section 15): the engine beside the plain reference, and what can be told
// without either.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/layers.h"
#include "abuffer/sampled.h"
#include "abuffer/simd/mesh_math.h"
#include "tests/counter.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/mesh_scenes.h"
#include "tests/scene_text.h"

namespace swept {
namespace {

using test::add_point;
using test::psnr_db;
using test::rectangle;
using test::rendered;

/// With a focal length of 64 px.
Scene stage(int width = 80, int height = 60) { return test::mesh_stage(width, height, 0.5 * height / 64.0); }

/// Triangles at random, of all sizes, some of them through the near plane and behind the eye.
Object soup(int triangles, unsigned seed, bool transparent) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  Object object;
  for (int t = 0; t < triangles; ++t) {
    const Eigen::Vector3d middle(uniform(-2.0, 2.0), uniform(-1.5, 1.5), uniform(-0.2, 6.0));
    const double size = std::pow(10.0, uniform(-2.0, 0.3));
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d offset(uniform(-size, size), uniform(-size, size), uniform(-size, size));
      const auto channel = [&] { return static_cast<float>(uniform(0.0, 1.0)); };
      add_point(object, middle + offset, {channel(), channel(), channel()});
      object.cloud.velocity.emplace_back(channel() - 0.5f, channel() - 0.5f, channel() - 0.5f);
      if (transparent) object.cloud.opacity.push_back(channel());
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    object.triangles.push_back({first, first + 1, first + 2});
  }
  return object;
}

Object some_discs(unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  Object object;
  for (int i = 0; i < 150; ++i) {
    add_point(object, {uniform(-2.0, 2.0), uniform(-1.5, 1.5), uniform(1.0, 6.0)},
              {static_cast<float>(uniform(0.0, 1.0)), 0.5f, 0.2f});
    object.cloud.velocity.emplace_back(0.3f, 0.0f, -0.2f);
  }
  return object;
}

TEST(Triangles, AreTheReference) {
  for (const bool transparent : {false, true})
    for (const bool two_sided : {true, false})
      for (const bool mirrored : {false, true}) {
        Scene scene = stage();
        scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
        scene.objects = {soup(150, 7, transparent)};
        Object& object = scene.objects[0];
        object.two_sided = two_sided;
        TransformKey first, last;
        last.frame = 1.0;
        last.rotate_axis = Eigen::Vector3d(1, 2, 3).normalized();
        last.rotate_radians = 0.4;
        if (mirrored) first.scale = last.scale = {-1.0, 1.0, 1.0};
        object.transform.keys = {first, last};
        const Image truth = test::reference(scene, 4), image = rendered(scene, 4).image;
        EXPECT_GT(psnr_db(image, truth), 110.0) << transparent << two_sided << mirrored;
        for (std::size_t i = 0; i < truth.depth.size(); ++i) {
          if (std::isinf(truth.depth[i]))
            EXPECT_TRUE(std::isinf(image.depth[i]));
          else
            EXPECT_NEAR(image.depth[i], truth.depth[i], 1e-4 * double{truth.depth[i]});
        }
      }
}

TEST(Triangles, AreTheReferenceWhereNobodyChoseThem) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    Scene scene = stage(40, 30);
    scene.objects = {soup(30 + static_cast<int>(seed) % 40, seed, seed % 3 == 0)};
    if (seed % 4 == 0) scene.objects.push_back(some_discs(seed));
    scene.objects[0].two_sided = seed % 2 == 0;
    // Corners on a coarse grid: edges along rays, triangles without an area, equal depths.
    if (seed % 5 == 0)
      for (Eigen::Vector3d& p : scene.objects[0].cloud.keys[0].pose.position)
        p = (p * 4.0).array().round() / 4.0;
    EXPECT_GT(psnr_db(rendered(scene, 2).image, test::reference(scene, 2)), 110.0) << seed;
  }
}

TEST(Triangles, AreTheReferenceAmongDiscs) {
  Scene scene = stage();
  scene.objects = {soup(60, 3, false), some_discs(4), soup(40, 5, true)};
  EXPECT_GT(psnr_db(rendered(scene, 4).image, test::reference(scene, 4)), 110.0);
}

TEST(Triangles, AreWithinTheErrorAskedFor) {
  Scene scene = stage(100, 75);
  scene.objects = {soup(120, 11, false), some_discs(12)};
  const Image truth = rendered(scene, 512).image;
  for (const double wanted : {45.0, 60.0}) {
    SampledOptions options;
    options.max_error_db = wanted;
    const auto result = render_sampled(scene, options);
    ASSERT_TRUE(result.ok()) << result.error().message();
    EXPECT_GT(psnr_db(result->image, truth), wanted - 1.0);
  }
}

TEST(Triangles, HaveTheSameBitsHoweverTheyAreDrawn) {
  Scene scene = stage(150, 130);
  scene.objects = {soup(150, 21, true), some_discs(22), soup(60, 23, false)};
  const Rendered first = rendered(scene, 6);
  for (std::size_t i = 0; i < mesh_maths().count; ++i)
    EXPECT_EQ(rendered(scene, 6, static_cast<int>(i)).image.rgba, first.image.rgba)
        << mesh_maths().first[i].name;
  EXPECT_EQ(rendered(scene, 6, -1, 1).image.rgba, first.image.rgba);
  std::swap(scene.objects[0], scene.objects[2]);
  EXPECT_EQ(rendered(scene, 6).image.rgba, first.image.rgba);
  scene.film.crop_x = 30, scene.film.crop_y = 10, scene.film.crop_width = 90, scene.film.crop_height = 77;
  const Image crop = rendered(scene, 6).image;
  EXPECT_TRUE(test::is_crop_of(crop, first.image, scene.film));
}

/// A sheet of many triangles of all shapes covers every place once: no gap, and where it lets half of the
/// light through no seam.
TEST(Triangles, MeetWithoutGapsAndOverlaps) {
  for (const float opacity : {1.0f, 0.5f}) {
    Scene scene = stage(120, 90);
    std::mt19937 random(5);
    const auto jitter = [&] { return 0.4 * (static_cast<double>(random()) / 4294967296.0 - 0.5); };
    Object object;
    constexpr int side = 40;
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
    object.cloud.velocity.assign(object.cloud.size(), {0.3f, 0.1f, 0.05f});
    scene.objects = {object};
    const Image image = rendered(scene, 8).image;
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      ASSERT_NEAR(image.rgba[4 * i + 3], opacity, 1e-6) << i;
      ASSERT_NEAR(image.rgba[4 * i + 2], opacity, 1e-6) << i;
    }
  }
}

/// Rönnow et al. 2021, Fig. 11: two rectangles that change places in depth half-way.
TEST(Triangles, ThatCrossInDepthShareTheExposure) {
  Scene scene = stage();
  scene.objects = {rectangle({0, 0, 2.0}, 3.0, 3.0, {1, 0, 0}), rectangle({0, 0, 3.0}, 4.0, 4.0, {0, 0, 1})};
  scene.objects[0].cloud.velocity.assign(4, {0, 0, 1});
  scene.objects[1].cloud.velocity.assign(4, {0, 0, -1});
  const Image image = rendered(scene, 2).image;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    ASSERT_NEAR(image.rgba[4 * i], 0.5, 1e-6);
    ASSERT_NEAR(image.rgba[4 * i + 2], 0.5, 1e-6);
    ASSERT_NEAR(image.rgba[4 * i + 3], 1.0, 1e-6);
  }
}

TEST(Triangles, HaveSmoothEdges) {
  Scene scene = stage();
  scene.shutter = {0.0, 0.0};
  // Its left edge goes through the middle of a column.
  scene.objects = {rectangle({0.5 / 32.0 + 1.0, 0, 2.0}, 1.0, 3.0, {1, 1, 1})};
  const Image image = rendered(scene, 1).image;
  for (int y = 0; y < image.height; ++y) {
    const auto alpha = [&](int x) {
      return image.rgba[4 * static_cast<std::size_t>(y * image.width + x) + 3];
    };
    EXPECT_EQ(alpha(39), 0.0f);
    EXPECT_EQ(alpha(40), 0.5f);
    EXPECT_EQ(alpha(41), 1.0f);
  }
}

TEST(Triangles, StandStillForOneInstant) {
  Scene scene = stage();
  scene.objects = {soup(40, 2, false)};
  scene.objects[0].cloud.velocity.clear();
  const auto result = render_sampled(scene, {});
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(test::counter(*result, "most_instants"), 1.0);
  EXPECT_EQ(test::counter(*result, "triangles"), 40.0);
}

TEST(Triangles, AreRefusedByNameWhereTheyAreNotDrawn) {
  Scene scene = stage();
  scene.objects = {soup(4, 2, false), some_discs(1)};
  // Beside discs the A-buffer draws them, by depth as well, and they have layers.
  EXPECT_TRUE(render_abuffer(scene, {}).ok());
  EXPECT_TRUE(render_abuffer(scene, {.deep = true}).ok());
  EXPECT_TRUE(render_layers(scene, {true, true, true}, {}).ok());
  scene.objects.pop_back();
  scene.objects[0].triangles[1][2] = 99;
  const auto wrong = render_sampled(scene, {});
  ASSERT_FALSE(wrong.ok());
  EXPECT_EQ(wrong.error().field, "/objects/0/triangles/1");
}

class TriangleFiles : public test::SceneFiles {
 protected:
  /// The error, or nothing.
  [[nodiscard]] std::string load(const std::string& object, Scene& scene,
                                 std::optional<DrawAs> draw = {}) const {
    SceneOverrides overrides;
    overrides.draw = draw;
    Result<SceneFile> file = read_scene_file(
        write(
            R"({"swept": 1, "camera": {"fov": {"axis": "vertical", "degrees": 40}, "keys": [{"eye": [0, 0, 5],)"
            R"( "target": [0, 0, 0], "up": [0, 1, 0]}]}, "objects": [)" +
            object + "]}"),
        overrides);
    if (!file.ok()) return file.error().message();
    const auto loaded = file->scene_at(1.0, test::dots);
    if (!loaded.ok()) return loaded.error().message();
    scene = **loaded;
    return {};
  }
};

TEST_F(TriangleFiles, AreDrawnIfAsked) {
  std::ofstream(folder_ / "a.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  std::ofstream(folder_ / "m.0001.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";
  std::ofstream(folder_ / "m.0002.obj") << "v 0 0 1\nv 1 0 1\nv 1 1 1\nf 1 2 3\n";
  Scene scene;
  const auto triangles = [&] { return scene.objects.at(0).triangles.size(); };
  EXPECT_EQ(load(R"({"source": {"file": "a.obj"}})", scene), "");
  EXPECT_EQ(triangles(), 0u);
  EXPECT_EQ(load(R"({"source": {"file": "a.obj"}, "draw": "triangles"})", scene), "");
  EXPECT_EQ(triangles(), 2u);
  EXPECT_EQ(load(R"({"source": {"file": "a.obj"}})", scene, DrawAs::triangles), "");
  EXPECT_EQ(triangles(), 2u);
  EXPECT_EQ(load(R"({"source": {"file": "a.obj"}, "draw": "triangles"})", scene, DrawAs::surfels), "");
  EXPECT_EQ(triangles(), 0u);
  EXPECT_EQ(load(R"({"source": {"sequence": "m.####.obj"}, "draw": "triangles"})", scene), "");
  EXPECT_EQ(triangles(), 1u);
  EXPECT_EQ(scene.objects[0].cloud.keys.size(), 2u);
}

TEST_F(TriangleFiles, SayWhatIsWrong) {
  std::ofstream(folder_ / "points.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  std::ofstream(folder_ / "a.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";
  Scene scene;
  const auto said = [&](const std::string& object, const std::string& what) {
    const std::string message = load(object, scene);
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  said(R"({"source": {"file": "points.obj"}, "draw": "triangles"})",
       "/objects/0/draw: the source holds no triangles");
  said(R"({"source": {"file": "a.obj"}, "draw": "triangles", "radius": 0.1})",
       "/objects/0/radius: means nothing");
  said(R"({"source": {"file": "a.obj"}, "draw": "triangles", "radius_scale": 2})", "/objects/0/radius_scale");
  said(R"({"source": {"generator": "dots", "points": 3}, "draw": "triangles"})",
       "/objects/0/draw: goes with files");
  said(R"({"source": {"file": "a.obj"}, "draw": "mesh"})", "/objects/0/draw");
}

}  // namespace
}  // namespace swept
