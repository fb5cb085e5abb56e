// Triangles that let light through, peeled off layer by layer, beside the sweep from event to event.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "abuffer/resolve/light_left.h"
#include "abuffer/resolve/smooth_part.h"
#include "tests/deep_flattened.h"
#include "tests/drawn.h"
#include "tests/mesh_scenes.h"

namespace swept {
namespace {

using test::exact;

TEST(SmoothParts, HoldPolynomialsAndTheirIntegrals) {
  const auto filled = [](double from, double to, const auto& f) {
    SmoothPart part;
    for (std::size_t k = 0; k < smooth_points; ++k) part.v[k] = f(from + smooth_part::at[k] * (to - from));
    return part;
  };
  for (int degree = 0; degree <= 9; ++degree) {
    const SmoothPart part = filled(0.0, 1.0, [&](double x) { return std::pow(x, degree); });
    EXPECT_NEAR(part.mean(), 1.0 / (degree + 1), 1e-15) << degree;
  }
  EXPECT_GT(std::abs(filled(0.0, 1.0, [](double x) { return std::pow(x, 10); }).mean() - 1.0 / 11.0), 1e-8);
  for (int degree = 0; degree <= 4; ++degree) {
    const auto f = [&](double x) { return std::pow(x - 0.3, degree); };
    const SmoothPart part = filled(0.0, 1.0, f).part(0.2, 0.7), truth = filled(0.2, 0.7, f);
    for (std::size_t k = 0; k < smooth_points; ++k) EXPECT_NEAR(part.v[k], truth.v[k], 1e-15) << degree;
    EXPECT_NEAR(part.share(3), truth.share(3), 1e-15);
    EXPECT_NEAR(part.share(4), truth.share(4), 1e-15);
  }
}

TEST(LightLeft, IsWhatLayersHaveNotTaken) {
  LightLeft left;
  left.start();
  // Half of it from 0.2 to 0.6, then a share that grows from 0 to 1 from 0.4 to 0.8.
  EXPECT_TRUE(left.meet(0.2, 0.6, [&](const LightLeft::Part& part) {
    EXPECT_TRUE(part.is_even);
    left.leave(part.end, 0.5 * part.even);
  }));
  EXPECT_TRUE(left.meet(0.4, 0.8, [&](const LightLeft::Part& part) {
    SmoothPart after;
    for (std::size_t k = 0; k < smooth_points; ++k)
      after.v[k] = part.at(k) * (0.8 - (part.begin + smooth_part::at[k] * part.span())) / 0.4;
    left.leave(part.end, after);
  }));
  double end = 0.0, sum = 0.0;
  EXPECT_FALSE(left.meet(0.0, 1.0, [&](const LightLeft::Part& part) {
    EXPECT_EQ(part.begin, end);
    end = part.end;
    for (std::size_t k = 0; k < smooth_points; ++k) {
      const double t = part.begin + smooth_part::at[k] * part.span();
      EXPECT_NEAR(part.at(k), (t > 0.2 && t < 0.6 ? 0.5 : 1.0) * (t > 0.4 && t < 0.8 ? (0.8 - t) / 0.4 : 1.0),
                  1e-14)
          << t;
      sum += smooth_part::weight[k] * part.span() * part.at(k);
    }
    left.leave(part.end, 0.0);
  }));
  EXPECT_EQ(end, 1.0);
  EXPECT_NEAR(sum, 0.2 + 0.1 + 0.5 * 0.15 + 0.05 + 0.2, 1e-14);
  left.meet(0.0, 1.0, [](const LightLeft::Part&) { ADD_FAILURE() << "there is none left"; });
}

constexpr double wall_depth = 20.0;

struct Look {
  std::string name;
  bool smooth = false;          ///< colours from corner to corner
  bool changing = false;        ///< in time
  bool uneven = false;          ///< opacities from corner to corner
  float texture_alpha = -1.0f;  ///< the least of its texels; below 0: no texture
};

/// Triangles of all sizes, each going its own way, some of them through the eye; none of them is opaque.
Scene looked(const Look& look, unsigned seed) {
  Scene scene = test::mesh_stage(16, 12, 0.5);
  Object& object = scene.objects.emplace_back(test::triangle_soup(30, seed, true));
  SurfelCloud& cloud = object.cloud;
  std::mt19937 random(seed + 100);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random()) / 4294967296.0f;
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::size_t first = i - i % 3;
    if (!look.smooth) cloud.color[i] = cloud.color[first];
    cloud.opacity[i] = look.uneven || i == first ? uniform(0.1f, 0.9f) : cloud.opacity[first];
  }
  if (look.changing) {
    LookKey open{0.0, cloud.color, cloud.opacity}, close{1.0, cloud.color, cloud.opacity};
    for (Eigen::Vector3f& color : close.color) color = Eigen::Vector3f::Ones() - color;
    if (look.uneven)
      for (float& opacity : close.opacity) opacity = uniform(0.1f, 0.9f);
    cloud.looks = {open, close};
  }
  if (look.texture_alpha >= 0.0f) {
    auto texture = std::make_shared<Texture>();
    texture->width = 5, texture->height = 4;
    for (int i = 0; i < 20; ++i) {
      const float alpha = uniform(look.texture_alpha, 1.0f);
      texture->texels.emplace_back(alpha * uniform(0, 1), alpha * uniform(0, 1), alpha * uniform(0, 1),
                                   alpha);
    }
    object.materials.resize(2);
    object.materials[0].texture = texture;
    object.material_of.assign(object.triangles.size(), 0);
    for (std::size_t t = 0; t < object.triangles.size(); ++t)
      object.texture_corners.push_back({Eigen::Vector2f(uniform(-1, 2), uniform(-1, 2)),
                                        {uniform(-1, 2), uniform(-1, 2)},
                                        {uniform(-1, 2), uniform(-1, 2)}});
  }
  object.two_sided = seed % 2 == 0;
  if (seed % 3 == 0) cloud.acceleration.assign(cloud.size(), {0.8f, -0.4f, 1.2f});
  if (seed % 4 == 1) scene.shutter.curve = ShutterShape::trapezoid;
  return scene;
}

/// The same before an opaque wall, which has places swept. In front of a black one colours are the same, in
/// front of a white one there is more by what is left of the light.
Image before_wall(Scene scene, float grey) {
  Object& object = scene.objects[0];
  Object wall = test::rectangle({0, 0, wall_depth}, 1e3, 1e3, {grey, grey, grey});
  const auto first = static_cast<std::uint32_t>(object.cloud.size());
  SurfelPose& pose = object.cloud.keys[0].pose;
  for (std::size_t i = 0; i < 4; ++i) {
    pose.position.push_back(wall.cloud.keys[0].pose.position[i]);
    pose.axis_u.push_back(pose.axis_u[0]);
    pose.axis_v.push_back(pose.axis_v[0]);
    object.cloud.velocity.emplace_back(0.0f, 0.0f, 0.0f);
    if (!object.cloud.acceleration.empty()) object.cloud.acceleration.emplace_back(0.0f, 0.0f, 0.0f);
    object.cloud.color.emplace_back(grey, grey, grey);
    object.cloud.opacity.push_back(1.0f);
    for (LookKey& look : object.cloud.looks) {
      look.color.emplace_back(grey, grey, grey);
      look.opacity.push_back(1.0f);
    }
  }
  // One-sided, it shows whichever side is the front.
  for (const Triangle& t : {Triangle{0, 1, 2}, {0, 2, 3}, {0, 2, 1}, {0, 3, 2}}) {
    object.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    if (!object.texture_corners.empty()) object.texture_corners.push_back(object.texture_corners[0]);
    if (!object.material_of.empty()) object.material_of.push_back(1);
  }
  return exact(scene).image;
}

class PeeledLayers : public ::testing::TestWithParam<Look> {};

TEST_P(PeeledLayers, AreWhatTheSweepSees) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Scene scene = looked(GetParam(), seed);
    const Image peeled = exact(scene).image, black = before_wall(scene, 0.0f),
                white = before_wall(scene, 1.0f);
    double most = 0.0;
    for (std::size_t i = 0; i < peeled.pixel_count(); ++i) {
      const float* const seen = &peeled.rgba[4 * i];
      for (std::size_t c = 0; c < 3; ++c) {
        most = std::max(most, std::abs(double{seen[c]} - double{black.rgba[4 * i + c]}));
        most =
            std::max(most, std::abs(double{seen[c]} + 1.0 - double{seen[3]} - double{white.rgba[4 * i + c]}));
      }
    }
    // Crossings that meet in rounding, and a float's. Where a shutter opens slowly time goes as the root of
    // light, and the sweep's halves are off by more than they differ: by 6·10⁻⁶ from layers that were peeled
    // to a thousandth of what they leave out, which these are to 2·10⁻⁸.
    EXPECT_LT(most, scene.shutter.curve != ShutterShape::box ? 1e-5 : 2e-6) << seed;
    // Where opacities are even the depth is that of triangles of one colour. Else the sweep has it, which
    // halves pieces by their colours alone.
    Look plain = GetParam();
    plain.smooth = plain.changing = false, plain.texture_alpha = -1.0f;
    const bool even = !plain.uneven && !(GetParam().texture_alpha < 1.0f && GetParam().texture_alpha >= 0.0f);
    const Image of_plain = exact(looked(plain, seed)).image;
    double depths = 0.0;
    for (std::size_t i = 0; i < peeled.depth.size(); ++i) {
      const double alpha = double{peeled.rgba[4 * i + 3]};
      if (!(alpha > 0.1)) continue;
      const double swept_depth = (double{black.depth[i]} - wall_depth * (1.0 - alpha)) / alpha;
      depths = std::max(
          depths, std::abs(double{peeled.depth[i]} / (even ? double{of_plain.depth[i]} : swept_depth) - 1.0));
    }
    EXPECT_LT(depths, even ? 1e-6 : 1e-4) << seed;
    EXPECT_EQ(exact(scene, {}, 1).image.rgba, peeled.rgba);
    EXPECT_EQ(test::render_deep(scene).image.rgba, peeled.rgba);
    AbufferOptions small;
    small.tile_px = 5;
    EXPECT_EQ(exact(scene, small).image.rgba, peeled.rgba);
    Scene reversed = scene;
    std::reverse(reversed.objects[0].triangles.begin(), reversed.objects[0].triangles.end());
    std::reverse(reversed.objects[0].texture_corners.begin(), reversed.objects[0].texture_corners.end());
    EXPECT_GT(test::psnr_db(exact(reversed).image, peeled), 140.0);
    RecordProperty("most_" + std::to_string(seed), std::to_string(most));
  }
}

INSTANTIATE_TEST_SUITE_P(Of, PeeledLayers,
                         ::testing::Values(Look{"one_color"}, Look{"smooth_colors", true},
                                           Look{"changing_colors", true, true},
                                           Look{"smooth_opacities", true, false, true},
                                           Look{"changing_opacities", true, true, true},
                                           Look{"opaque_texture", false, false, false, 1.0f},
                                           Look{"clear_texture", true, false, true, 0.0f}),
                         [](const auto& of) { return of.param.name; });

/// Black before black: colours are 0 and alpha is 1 throughout, so that nothing but depth tells how clear the
/// nearer one is. Under a shutter that opens slowly it goes as the root of light.
TEST(SweptLayers, HaveTheDepthOfWhatIsDarkAndClear) {
  for (const int columns : {0, 6}) {
    Scene scene = test::mesh_stage(4, 3, 0.2);
    scene.shutter.curve = ShutterShape::trapezoid;
    Object& object = scene.objects.emplace_back(test::rectangle({0, 0, 0}, 4.0, 4.0, {0, 0, 0}));
    // From nearly at the eye to 14 deep.
    for (Eigen::Vector3d& p : object.cloud.keys[0].pose.position) {
      p.x() = std::max(-0.6, p.x());
      p.z() = 2.0 + 3.0 * p.x();
    }
    test::move_points(object, {0.5f, 0.0f, 0.0f});
    object.cloud.opacity.own() = {1.0f, 0.1f, 0.5f, 0.7f};
    object.materials.resize(2);
    object.material_of = {0, 0};
    if (columns > 0) {
      auto texture = std::make_shared<Texture>();
      texture->width = columns, texture->height = 2;
      std::mt19937 random(3);
      for (int i = 0; i < 2 * columns; ++i)
        texture->texels.emplace_back(0.0f, 0.0f, 0.0f, static_cast<float>(random()) / 4294967296.0f);
      object.materials[0].texture = texture;
      object.texture_corners = {{Eigen::Vector2f(0, 0), {1, 0}, {1, 1}},
                                {Eigen::Vector2f(0, 0), {1, 1}, {0, 1}}};
    }
    const Image swept = before_wall(scene, 0.0f), peeled = exact(scene).image,
                truth = test::reference(scene, 1024);
    for (std::size_t i = 0; i < swept.pixel_count(); ++i) {
      const double alpha = double{truth.rgba[4 * i + 3]}, depth = double{truth.depth[i]};
      // What floats hold, and 1024 stills.
      EXPECT_NEAR(double{peeled.depth[i]} / depth, 1.0, 2e-6) << columns << ' ' << i;
      EXPECT_NEAR(double{swept.depth[i]} / (alpha * depth + (1.0 - alpha) * wall_depth), 1.0, 2e-6)
          << columns << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace swept
