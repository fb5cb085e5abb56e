// Every kind of what is drawn with every effect: each method agrees with the reference, or refuses by name.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "abuffer/stochastic/stochastic.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"
#include "tests/splat_scenes.h"

namespace swept {
namespace {

struct Kind {
  std::string name;
  std::function<Object()> object;
};
struct Effect {
  std::string name;
  std::function<void(Scene&)> apply;
};
struct Method {
  std::string name;
  std::function<Result<Rendered>(const Scene&)> render;
  double least_db;
};

Object triangles(float opacity) {
  test::Random random(5);
  return test::triangles_about(24, opacity, random, [&] { return random.vector(-1.0, 1.0); });
}

/// With colours of degree 1, that change with the direction.
Object splats() {
  test::Random random(7);
  Object object;
  SplatCloud& cloud = object.splats;
  cloud.degree = 1;
  for (int i = 0; i < 30; ++i) {
    cloud.position.push_back(random.vector(-1.0, 1.0));
    cloud.scale.push_back(random.vector(0.05, 0.25).cast<float>());
    const Eigen::Vector3d axis = random.vector(-1.0, 1.0);
    cloud.rotation.push_back(
        Eigen::Quaterniond(Eigen::AngleAxisd(random(0.0, 3.0), axis.normalized())).cast<float>());
    cloud.opacity.push_back(static_cast<float>(random(0.3, 1.0)));
    for (int k = 0; k < 12; ++k) cloud.harmonics.push_back(static_cast<float>(random(-0.5, 0.8)));
  }
  return object;
}

Object clear_discs() {
  Object object = test::checkered_sphere(0.8, 120);
  object.cloud.opacity.assign(object.cloud.size(), 0.5f);
  return object;
}

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = {{"discs", [] { return test::checkered_sphere(0.8, 120); }},
                                        {"clear discs", clear_discs},
                                        {"triangles", [] { return triangles(1.0f); }},
                                        {"clear triangles", [] { return triangles(0.5f); }},
                                        {"splats", splats}};
  return all;
}

const std::vector<Effect>& effects() {
  static const std::vector<Effect> all = {
      {"none", [](Scene&) {}},
      {"lens",
       [](Scene& scene) {
         scene.camera.aperture = {0.15, 0, 0.0, 12};
         for (LookAtKey& key : scene.camera.look_ats) key.lens.focus = 4.0;
       }},
      {"rolling shutter", [](Scene& scene) { scene.shutter.row_delay = 0.01; }},
      {"trapezoid", [](Scene& scene) { scene.shutter.curve = ShutterShape::trapezoid; }},
      {"gaussian", [](Scene& scene) { scene.shutter.curve = ShutterShape::gaussian; }},
      {"parallel rays",
       [](Scene& scene) {
         scene.camera.orthographic = true;
         for (LookAtKey& key : scene.camera.look_ats) key.tan_half_fov_y = 1.6;
       }},
      {"zoom", [](Scene& scene) { scene.camera.look_ats[1].tan_half_fov_y *= 1.2; }},
      {"hard coverage", [](Scene& scene) { scene.model.coverage = Coverage::hard; }},
      {"one side",
       [](Scene& scene) {
         for (Object& object : scene.objects) object.two_sided = object.splats.size() > 0;
       }},
      {"background",
       [](Scene& scene) {
         scene.background = {0.1f, 0.3f, 0.2f, 0.5f};
       }},
      {"through the eye", [](Scene& scene) {
         scene.camera.near = 0.05;
         for (LookAtKey& key : scene.camera.look_ats) key.eye.z() = 1.2 - 0.6 * key.frame;
         for (LookAtKey& key : scene.camera.look_ats) key.target.z() = -3.0;
       }}};
  return all;
}

Scene scene_of(const Kind& kind, const Effect& effect) {
  Scene scene = test::stage();
  scene.film = {32, 24, 0, 0, 0, 0};
  scene.motion.tolerance_px = 0.02;
  scene.camera.look_ats.push_back(scene.camera.look_ats.front());
  scene.camera.look_ats[1].frame = 1.0;
  scene.objects = {kind.object()};
  test::move(scene.objects[0], {-0.2, 0.1, 0.1}, {0.2, 0.0, -0.1}, 0.3);
  effect.apply(scene);
  return scene;
}

bool has_lens(const Scene& scene) { return scene.camera.aperture.radius > 0.0; }

Result<Rendered> sampled(const Scene& scene) {
  SampledOptions options;
  options.max_error_db = 65.0;
  // Of given points no error is estimated.
  if (has_lens(scene)) options.samples = 64 * scene.camera.aperture.samples;
  return render_sampled(scene, options);
}
Result<Rendered> exact(const Scene& scene) { return render_abuffer(scene); }
Result<Rendered> stochastic(const Scene& scene) {
  StochasticOptions options;
  options.samples = 256;
  return render_stochastic(scene, options);
}

/// The noise of 256 samples at the edges of triangles is some 45 dB.
const std::vector<Method>& methods() {
  static const std::vector<Method> all = {
      {"sampled", sampled, 60.0}, {"exact", exact, 60.0}, {"stochastic", stochastic, 42.0}};
  return all;
}

/// Discs that reach the near plane keep the filter and the axes of their segment's middle.
double least_db(const Method& method, const Effect& effect) {
  return method.name == "exact" && effect.name == "through the eye" ? 57.5 : method.least_db;
}

/// What the message says of a pair that a method does not draw; empty: it draws it.
std::string refusal(const Method& method, const Kind& kind, const Effect& effect) {
  const bool rows = effect.name == "rolling shutter", discs = kind.name.ends_with("discs");
  if (method.name != "sampled" && kind.name == "splats") return "Gaussian splats";
  if (rows && (method.name == "stochastic" || (method.name == "sampled" && !discs)))
    return "rows are exposed one after the other";
  return {};
}

/// Red, green and blue of some rows. Of a rolling shutter, each row by itself is a frame of another time.
std::vector<float> rows_of(const Image& image, const std::vector<int>& rows) {
  std::vector<float> values;
  for (const int y : rows)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c)
        values.push_back(image.rgba[static_cast<std::size_t>(4 * (image.width * y + x) + c)]);
  return values;
}
std::vector<float> judge_rows(const Scene& scene, const std::vector<int>& rows) {
  const auto judge = [&](const Scene& of) {
    Result<Rendered> rendered = render_reference(of, {has_lens(of) ? 64 : 256, ReferenceMotion::smooth});
    EXPECT_TRUE(rendered.ok()) << rendered.error().message();
    return rendered ? std::move(rendered->image) : Image{};
  };
  if (scene.shutter.row_delay == 0.0) return rows_of(judge(scene), rows);
  std::vector<float> values;
  for (const int y : rows) {
    Scene row = scene;
    row.shutter.row_delay = 0.0;
    row.shutter.open += scene.shutter.row_delay * y;
    row.shutter.close += scene.shutter.row_delay * y;
    row.film.crop_y = y, row.film.crop_width = scene.film.width, row.film.crop_height = 1;
    const std::vector<float> own = rows_of(judge(row), {0});
    values.insert(values.end(), own.begin(), own.end());
  }
  return values;
}

double decibels(const std::vector<float>& a, const std::vector<float>& b) {
  EXPECT_EQ(a.size(), b.size());
  double squares = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    squares += std::pow(double{a[i]} - double{b[i]}, 2);
  return -10.0 * std::log10(squares / static_cast<double>(a.size()));
}

TEST(MethodMatrix, AgreesWithTheReferenceOrRefusesByName) {
  for (const Effect& effect : effects())
    for (const Kind& kind : kinds()) {
      const Scene scene = scene_of(kind, effect);
      const std::vector<int> rows = scene.shutter.row_delay == 0.0
                                        ? std::vector<int>{2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22}
                                        : std::vector<int>{3, 9, 14, 20};
      std::vector<float> truth;
      for (const Method& method : methods()) {
        const std::string at = effect.name + ", " + kind.name + ", " + method.name;
        const Result<Rendered> rendered = method.render(scene);
        if (const std::string what = refusal(method, kind, effect); !what.empty()) {
          ASSERT_FALSE(rendered.ok()) << at;
          EXPECT_EQ(rendered.error().kind, ErrorKind::unsupported) << at;
          EXPECT_NE(rendered.error().message().find(what), std::string::npos) << rendered.error().message();
          continue;
        }
        ASSERT_TRUE(rendered.ok()) << at << ": " << rendered.error().message();
        if (truth.empty()) truth = judge_rows(scene, rows);
        EXPECT_GE(decibels(rows_of(rendered->image, rows), truth), least_db(method, effect)) << at;
      }
    }
}

TEST(MethodMatrix, CropsAreThoseBits) {
  for (const Effect& effect : effects())
    for (const Kind& kind : kinds())
      for (const Method& method : methods()) {
        if (!refusal(method, kind, effect).empty()) continue;
        Scene scene = scene_of(kind, effect);
        const Result<Rendered> whole = method.render(scene);
        scene.film.crop_x = 9, scene.film.crop_y = 5, scene.film.crop_width = 14, scene.film.crop_height = 11;
        const Result<Rendered> crop = method.render(scene);
        ASSERT_TRUE(whole.ok() && crop.ok()) << effect.name << ", " << kind.name << ", " << method.name;
        EXPECT_TRUE(test::is_crop_of(crop->image, whole->image, scene.film))
            << effect.name << ", " << kind.name << ", " << method.name;
      }
}

}  // namespace
}  // namespace swept
