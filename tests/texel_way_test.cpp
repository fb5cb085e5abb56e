// Light that sees a texture along a place's way over it, beside looks at many instants.
#include <array>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/resolve/texel_way.h"
#include "tests/mesh_scenes.h"

namespace swept {
namespace {

/// Of 9 by 7 texels, all of them different.
std::shared_ptr<const Texture> colored_texels() {
  auto texture = std::make_shared<Texture>();
  texture->width = 9, texture->height = 7;
  std::mt19937 random(4);
  const auto channel = [&] { return static_cast<float>(random()) / 4294967296.0f; };
  for (int i = 0; i < 63; ++i) {
    const float red = channel(), green = channel();
    texture->texels.emplace_back(red, green, channel(), 1.0f);
  }
  return texture;
}

/// Random white triangles, some of them through the eye. With each degree of paths, corners go up to so many
/// times over the texture.
Scene textured_soup(int degree, double most_times, bool orthographic) {
  Scene scene = test::mesh_stage(16, 12, 0.5);
  if (orthographic) scene.camera.orthographic = true;
  Object& object =
      scene.objects.emplace_back(test::triangle_soup(300, 7u + static_cast<unsigned>(degree), false));
  object.two_sided = true;
  object.cloud.color.assign(object.cloud.size(), {1.0f, 1.0f, 1.0f});
  if (degree >= 2) object.cloud.acceleration.assign(object.cloud.size(), {0.8f, -0.4f, 1.2f});
  object.texture = colored_texels();
  std::mt19937 random(9);
  const auto coordinate = [&] {
    return static_cast<float>(most_times * (2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0));
  };
  for (std::size_t t = 0; t < object.triangles.size(); ++t) {
    TextureCorners& corners = object.texture_corners.emplace_back();
    for (Eigen::Vector2f& corner : corners) corner.x() = coordinate(), corner.y() = coordinate();
  }
  return scene;
}

struct Seen {
  int found = 0, all = 0;
  double off = 0.0;  ///< of the light that saw it
};

/// Even light from the interval's begin on, and what falls as a parabola up to its end.
Seen seen_beside_looks(const Scene& scene) {
  const Object& object = scene.objects[0];
  const Result<MovingMesh> mesh = MovingMesh::follow(scene, object, scene.exposure(), 0.01, {});
  EXPECT_TRUE(mesh.ok());
  Seen seen;
  TexelWay way;
  for (std::size_t t = 0; t < object.triangles.size(); ++t) {
    const TriangleStretch triangle(*mesh, 0, 0, t, scene.camera.near, scene.camera.orthographic);
    std::vector<PlaceInterval> intervals;
    for (const double x : {-0.41, -0.13, 0.02, 0.33})
      for (const double y : {-0.31, 0.07, 0.29}) {
        const Eigen::Vector3d ray(x, y, 1.0);
        intervals.clear();
        triangle.meet(ray, 0.0, 1.0, 0, 0, intervals);
        for (const PlaceInterval& of : intervals) {
          ++seen.all;
          if (!way.find(triangle, ray, of.begin, of.end)) continue;
          ++seen.found;
          const double span = of.end - of.begin, middle = of.begin + 0.3 * span;
          const auto light = [&](double time) {
            const double rest = (of.end - time) / (of.end - middle);
            return time < middle ? 0.75 : 0.5 * rest * rest;
          };
          LightLeft::Part even, falling;
          even.begin = of.begin, even.end = falling.begin = middle, falling.end = of.end;
          even.is_even = true, falling.is_even = false;
          even.even = 0.75;
          for (std::size_t k = 0; k < smooth_points; ++k)
            falling.changes.v[k] = light(middle + smooth_part::at[k] * falling.span());
          way.see(even);
          way.see(falling);
          double colors[3] = {0.0, 0.0, 0.0}, truth[3] = {0.0, 0.0, 0.0};
          way.add_colors(*object.texture, colors);
          // A whole number of them in each part.
          constexpr int looks = 10'000;
          for (int k = 0; k < looks; ++k) {
            const double time = of.begin + (k + 0.5) / looks * span;
            const TriangleStretch::Look look = triangle.look(ray, time);
            for (int c = 0; c < 3; ++c) truth[c] += light(time) * look.rgba[c] * span / looks;
          }
          for (int c = 0; c < 3; ++c)
            seen.off = std::max(seen.off, std::abs(colors[c] - truth[c]) / (0.3 * span));
        }
      }
  }
  return seen;
}

TEST(TexelWay, SeesWhatLooksAtManyInstantsSee) {
  for (const int degree : {1, 2})
    for (const double most_times : {0.2, 3.0})
      for (const bool orthographic : {false, true}) {
        const Seen seen = seen_beside_looks(textured_soup(degree, most_times, orthographic));
        EXPECT_GT(seen.all, 60);
        EXPECT_GT(seen.found, 0.95 * seen.all) << degree << ' ' << most_times;
        EXPECT_LT(seen.off, 1e-6) << degree << ' ' << most_times << ' ' << orthographic;
      }
}

}  // namespace
}  // namespace swept
