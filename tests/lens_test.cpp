// Two focal lengths and a principal point off the middle: pictures are the same as without them where film or
// world are shifted or stretched instead, and points are where textbooks have them.
#include <cmath>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "splat/compare/metrics.h"
#include "splat/motion/instant.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Method {
  const char* name;
  std::function<Result<Rendered>(const Scene&)> render;
};

std::vector<Method> methods() {
  return {{"sampled",
           [](const Scene& scene) {
             SampledOptions options;
             options.samples = 8;
             return render_sampled(scene, options);
           }},
          {"abuffer", [](const Scene& scene) { return render_abuffer(scene); }},
          {"reference", [](const Scene& scene) {
             ReferenceOptions options;
             options.samples = 8;
             return render_reference(scene, options);
           }}};
}

void set_lens(Scene& scene, const Lens& lens) {
  for (LookAtKey& key : scene.camera.look_ats) key.lens = lens;
}

double psnr(const Image& a, const Image& b) {
  const auto metrics = compare_images(a, b);
  EXPECT_TRUE(metrics.ok());
  return metrics.ok() ? metrics->psnr_db : 0.0;
}

/// Focal lengths and principal point in px at a frame, as a textbook's matrix of intrinsics has them.
struct Intrinsics {
  double fx, fy, cx, cy;
};

TEST(Lens, PointsAreWhereTheIntrinsicsHaveThem) {
  Scene scene = test::stage();
  scene.film = {640, 480, 0, 0, 0, 0};
  LookAtKey from = scene.camera.look_ats.front();
  from.eye = {1, 2, 7};
  from.target = {0.2, -0.1, 0.3};
  from.up = {0.1, 1, 0.2};
  LookAtKey to = from;
  from.tan_half_fov_y = 240.0 / 700.0;
  from.lens = {600.0 / 700.0, {(300.0 - 320.0) / 480.0, (260.0 - 240.0) / 480.0}};
  to.frame = 1.0;
  to.tan_half_fov_y = 240.0 / 350.0;
  to.lens = {900.0 / 350.0, {(420.0 - 320.0) / 480.0, (-50.0 - 240.0) / 480.0}};
  scene.camera.look_ats = {from, to};
  ASSERT_TRUE(scene.validate().ok());
  const Object object = test::checkered_sphere(1.0, 10);
  const Exposure exposure{0.0, 1.0};
  const Projection film = projection_of(scene.film, scene.camera.at(exposure.middle()));

  const Vector3d forward = (from.target - from.eye).normalized(), right = forward.cross(from.up).normalized();
  const Vector3d down = forward.cross(right);
  for (const double t : {0.0, 0.25, 0.5, 1.0}) {
    // What is interpolated: half a height's tangent, the ratio of focal lengths, and the principal point.
    const double fy = 240.0 / ((1 - t) * 240.0 / 700.0 + t * 240.0 / 350.0);
    const Intrinsics lens{fy * ((1 - t) * 600.0 / 700.0 + t * 900.0 / 350.0), fy, (1 - t) * 300.0 + t * 420.0,
                          (1 - t) * 260.0 - t * 50.0};
    const Instant instant = instant_at(scene, object, exposure, t);
    for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(1, -2, 0.5), Vector3d(-3, 1, 2)}) {
      const Vector3d ray = p - from.eye, seen = instant.to_camera(p);
      const double x = lens.cx + lens.fx * ray.dot(right) / ray.dot(forward);
      const double y = lens.cy + lens.fy * ray.dot(down) / ray.dot(forward);
      // Coordinates of a thousand px, a few dozen roundings.
      EXPECT_NEAR(film.center_x + film.focal_px * seen.x() / seen.z(), x, 1e-10);
      EXPECT_NEAR(film.center_y + film.focal_px * seen.y() / seen.z(), y, 1e-10);
      EXPECT_NEAR(seen.z(), ray.dot(forward), 1e-13);
    }
  }
}

/// A principal point off the middle shows what a larger film shows in a window.
TEST(Lens, APrincipalPointIsAWindowOfALargerFilm) {
  Scene shifted = test::busy_scene();
  const double focal_px = 24.0 / shifted.camera.look_ats.front().tan_half_fov_y;
  Scene window = shifted;
  // The window's middle is 14 px to the left of the larger film's, and 9 px below.
  set_lens(shifted, {1.0, {14.0 / 48.0, -9.0 / 48.0}});
  window.film = {64 + 28, 48 + 18, 0, 18, 64, 48};
  window.camera.look_ats.front().tan_half_fov_y = 0.5 * window.film.height / focal_px;
  for (const Method& method : methods()) {
    const auto a = method.render(shifted), b = method.render(window);
    ASSERT_TRUE(a.ok() && b.ok()) << method.name;
    Image expected = b->image;
    expected.x = expected.y = 0;
    expected.film_width = 64;
    expected.film_height = 48;
    EXPECT_GE(psnr(a->image, expected), 100.0) << method.name;
    const auto plain = method.render(test::busy_scene());
    EXPECT_LE(psnr(a->image, plain->image), 30.0) << "the principal point does something";
  }
}

/// The eye looks along −z and x is the picture's: a stretched lens shows what a stretched world shows.
TEST(Lens, AStretchIsThatOfTheWorld) {
  for (const double stretch : {0.5, 1.7}) {
    Scene stretched = test::busy_scene();
    set_lens(stretched, {stretch, Vector2d::Zero()});
    Scene world = test::busy_scene();
    world.model.segments = stretched.model.segments;
    for (Object& object : world.objects) {
      // Turned, then stretched: only an object's points can be.
      const Exposure exposure = world.exposure();
      std::vector<SurfelKey> keys;
      constexpr int steps = 96;
      for (int i = 0; i <= steps; ++i) {
        const double frame = exposure.at(static_cast<double>(i) / steps);
        Eigen::Affine3d at = object.transform.at(frame);
        at = Eigen::Scaling(stretch, 1.0, 1.0) * at;
        SurfelPose pose = object.cloud.keys.front().pose;
        for (std::size_t p = 0; p < pose.position.size(); ++p) {
          pose.position[p] = at * pose.position[p];
          pose.axis_u[p] = (at.linear() * pose.axis_u[p].cast<double>()).cast<float>();
          pose.axis_v[p] = (at.linear() * pose.axis_v[p].cast<double>()).cast<float>();
        }
        keys.push_back({frame, std::move(pose)});
      }
      object.cloud.keys = std::move(keys);
      object.transform.keys.clear();
    }
    for (const Method& method : methods()) {
      const auto a = method.render(stretched), b = method.render(world);
      ASSERT_TRUE(a.ok() && b.ok()) << method.name;
      // Axes that were rounded to floats, and 96 chords of the paths.
      EXPECT_GE(psnr(a->image, b->image), 70.0) << method.name << ' ' << stretch;
      const auto plain = method.render(test::busy_scene());
      EXPECT_LE(psnr(a->image, plain->image), 30.0) << "the stretch does something";
    }
  }
}

/// Discs far apart, each of one colour, are cast by a ray caster of a few lines.
TEST(Lens, APictureIsThatOfItsRays) {
  Scene scene = test::stage();
  scene.film = {97, 61, 0, 0, 0, 0};
  scene.model.coverage = Coverage::hard;
  scene.model.filter_radius_px = 0.0;
  scene.model.depth_tolerance = 0.0;
  LookAtKey& key = scene.camera.look_ats.front();
  key.tan_half_fov_y = 30.5 / 70.0;
  key.lens = {45.0 / 70.0, {(60.0 - 48.5) / 61.0, (20.0 - 30.5) / 61.0}};
  Object& object = scene.objects.emplace_back();
  struct Disc {
    Vector3d center, normal;
    double radius;
    Eigen::Vector3f color;
  };
  const Disc discs[] = {{{0, 0, 0}, {0.3, 0.2, 1}, 0.7, {1, 0, 0}},
                        {{0.5, 0.4, -1.5}, {-1, 0.1, 0.6}, 1.1, {0, 1, 0}},
                        {{-1.5, -0.3, 1.5}, {0.5, 1, 0.8}, 0.6, {0, 0, 1}},
                        {{-1.0, -1.4, -3}, {0, -0.4, 1}, 1.3, {1, 1, 0}}};
  for (const Disc& disc : discs)
    test::add_disc(object, disc.center, disc.normal.normalized(), disc.radius, disc.color);

  std::vector<float> expected;
  std::size_t seen[4] = {};
  const Vector3d eye(0, 0, 5);
  for (int y = 0; y < scene.film.height; ++y)
    for (int x = 0; x < scene.film.width; ++x) {
      // The eye looks along −z, and y is up.
      const Vector3d ray((x + 0.5 - 60.0) / 45.0, -(y + 0.5 - 20.0) / 70.0, -1.0);
      double nearest = 1e9;
      Eigen::Vector4f rgba = Eigen::Vector4f::Zero();
      for (const Disc& disc : discs) {
        const double depth = disc.normal.dot(disc.center - eye) / disc.normal.dot(ray);
        if (!(depth > 0.0 && depth < nearest) || (eye + depth * ray - disc.center).norm() > disc.radius)
          continue;
        nearest = depth;
        rgba << disc.color, 1.0f;
      }
      expected.insert(expected.end(), rgba.data(), rgba.data() + 4);
      for (std::size_t i = 0; i < 4; ++i)
        if (nearest < 1e9 && rgba.head<3>() == discs[i].color) ++seen[i];
    }
  for (const std::size_t count : seen) EXPECT_GT(count, 50u);
  for (const Method& method : methods()) {
    const auto rendered = method.render(scene);
    ASSERT_TRUE(rendered.ok()) << method.name;
    std::size_t differing = 0;
    for (std::size_t i = 0; i < expected.size(); ++i)
      if (std::abs(rendered->image.rgba[i] - expected[i]) > 1e-6f) ++differing;
    // A rim that passes through the very centre of a pixel may round either way.
    EXPECT_LE(differing, 4u) << method.name;
  }
}

/// All methods agree where focal lengths and principal point change while the shutter is open.
TEST(Lens, MayChangeWhileTheShutterIsOpen) {
  Scene scene = test::busy_scene();
  scene.model.segments = 16;
  LookAtKey& open = scene.camera.look_ats.front();
  LookAtKey close = open;
  close.frame = 1.0;
  open.lens = {1.3, {0.1, 0.05}};
  close.lens = {0.8, {-0.15, 0.2}};
  close.tan_half_fov_y = 0.4;
  close.roll_radians = 0.4;
  scene.camera.look_ats = {open, close};
  ReferenceOptions options;
  options.samples = 64;
  options.motion = ReferenceMotion::smooth;
  const auto truth = render_reference(scene, options);
  const auto exact = render_abuffer(scene);
  SampledOptions instants;
  instants.samples = 64;
  const auto sampled = render_sampled(scene, instants);
  ASSERT_TRUE(truth.ok() && exact.ok() && sampled.ok());
  EXPECT_GE(psnr(sampled->image, truth->image), 90.0);
  EXPECT_GE(psnr(exact->image, truth->image), 50.0);
  scene.camera.look_ats.resize(1);
  const auto still = render_reference(scene, options);
  EXPECT_LE(psnr(still->image, truth->image), 30.0) << "the lens does something";
}

TEST(Lens, MovesTheCameraByItself) {
  CameraTrack camera;
  camera.look_ats.resize(2);
  camera.look_ats[1].frame = 1.0;
  EXPECT_TRUE(camera.constant_over(0.0, 1.0));
  LookAtKey stretched, shifted, rolled;
  stretched.lens.stretch_x = 2.0;
  shifted.lens.shift.y() = 0.5;
  rolled.roll_radians = 0.1;
  for (LookAtKey changed : {stretched, shifted, rolled}) {
    changed.frame = 1.0;
    camera.look_ats[1] = changed;
    EXPECT_FALSE(camera.constant_over(0.0, 1.0));
    EXPECT_TRUE(camera.validate().ok());
  }
}

TEST(Lens, RollTurnsTheCameraClockwise) {
  CameraTrack camera;
  camera.look_ats.resize(1);
  const double quarter = std::acos(-1.0) / 2.0;
  camera.look_ats[0].roll_radians = quarter;
  // The eye is at z = 5 and looks along −z. What is above it lies to its left then.
  const Eigen::Matrix3d axes = camera.at(0.0).camera_from_world.linear();
  EXPECT_LE((axes * Vector3d::UnitY() - Vector3d(-1, 0, 0)).norm(), 1e-15);
  EXPECT_LE((axes * Vector3d::UnitX() - Vector3d(0, -1, 0)).norm(), 1e-15);
  EXPECT_NEAR(axes.determinant(), 1.0, 1e-15);
  // Between keys the angle is interpolated: a whole turn is one.
  camera.look_ats.resize(2);
  camera.look_ats[0].roll_radians = 0.0;
  camera.look_ats[1].roll_radians = 4.0 * quarter;
  camera.look_ats[1].frame = 4.0;
  EXPECT_LE((camera.at(1.0).camera_from_world.linear() - axes).norm(), 1e-15);
}

/// A whole turn of the camera within the exposure ends as it began.
TEST(Lens, AWholeRollIsFollowed) {
  Scene scene = test::busy_scene();
  for (Object& object : scene.objects) object.transform.keys.clear();
  LookAtKey close = scene.camera.look_ats.front();
  close.frame = 1.0;
  close.roll_radians = 4.0 * std::acos(0.0);
  scene.camera.look_ats.push_back(close);
  ReferenceOptions options;
  options.samples = 32;
  options.motion = ReferenceMotion::smooth;
  const auto truth = render_reference(scene, options);
  SampledOptions instants;
  instants.samples = 32;
  const auto sampled = render_sampled(scene, instants);
  ASSERT_TRUE(truth.ok() && sampled.ok());
  EXPECT_GE(psnr(sampled->image, truth->image), 90.0);
}

/// At the ends of what validate() allows no picture has anything but numbers, and all methods see the same.
TEST(Lens, MayBeExtreme) {
  for (const double stretch : {1e-3, 1.0, 1e3})
    for (const double shift : {-1e3, 0.0, 1e3})
      for (const double tangent : {1e-2, 1e3}) {
        Scene scene = test::busy_scene();
        scene.shutter = {0.5, 0.5};
        set_lens(scene, {stretch, {shift, -0.5 * shift}});
        LookAtKey& key = scene.camera.look_ats.front();
        key.tan_half_fov_y = tangent;
        ASSERT_TRUE(scene.validate().ok());
        std::vector<Image> images;
        for (const Method& method : methods()) {
          auto rendered = method.render(scene);
          ASSERT_TRUE(rendered.ok()) << method.name;
          for (const float value : rendered->image.rgba) ASSERT_TRUE(std::isfinite(value)) << method.name;
          images.push_back(std::move(rendered->image));
        }
        EXPECT_GE(psnr(images[0], images[2]), 60.0) << stretch << ' ' << shift << ' ' << tangent;
        EXPECT_GE(psnr(images[1], images[2]), 60.0) << stretch << ' ' << shift << ' ' << tangent;
      }
}

TEST(Lens, ValidateNamesWhatIsWrong) {
  const auto field = [](const Lens& lens, double roll) {
    CameraTrack camera;
    camera.look_ats.resize(1);
    camera.look_ats[0].lens = lens;
    camera.look_ats[0].roll_radians = roll;
    const Status status = camera.validate();
    return status.ok() ? std::string() : status.error().field;
  };
  constexpr double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(field({0.0, {0, 0}}, 0.0), "/keys/0/intrinsics/fx");
  EXPECT_EQ(field({-1.0, {0, 0}}, 0.0), "/keys/0/intrinsics/fx");
  EXPECT_EQ(field({1001.0, {0, 0}}, 0.0), "/keys/0/intrinsics/fx");
  EXPECT_EQ(field({1.0, {1001, 0}}, 0.0), "/keys/0/intrinsics/cx");
  EXPECT_EQ(field({1.0, {0, -infinity}}, 0.0), "/keys/0/intrinsics/cy");
  EXPECT_EQ(field({1.0, {std::nan(""), 0}}, 0.0), "/keys/0/intrinsics/cx");
  EXPECT_EQ(field({1.0, {0, 0}}, infinity), "/keys/0/roll");
  EXPECT_EQ(field({0.9, {0.1, -0.1}}, -9.0), "");
}

}  // namespace
}  // namespace swept
