// Splats that were trained in motion: they move, turn and fade by themselves, at the very instants.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/io/cloud_scene.h"
#include "splat/io/read_splats.h"
#include "tests/cloud_files.h"
#include "tests/counter.h"
#include "tests/drawn.h"
#include "tests/point_files.h"
#include "tests/splat_scenes.h"

namespace swept {
namespace {

using test::psnr_db;

/// Splats of `random_splats`, each coming and going at a time of its own, in a clip of 20 frames.
Scene clip(std::size_t count, unsigned seed, double speed = 1.0, double shortest = 0.05) {
  Scene scene = test::random_splats(count, seed);
  SplatCloud& cloud = scene.objects[0].splats;
  cloud.velocity.clear();
  cloud.frame = 3.0;
  SplatMotion& motion = cloud.motion.emplace();
  motion.frames = 20.0;
  std::mt19937 generator(seed + 1);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const auto next = [&] { return any(generator); };
  const auto vector = [&](double size) {
    return Eigen::Vector3f((size * Eigen::Vector3d(next(), next(), next())).cast<float>());
  };
  for (std::size_t i = 0; i < count; ++i) {
    motion.center.push_back(static_cast<float>(0.5 + 0.7 * next()));
    motion.duration.push_back(static_cast<float>(shortest * std::pow(20.0, 0.5 + 0.5 * next())));
    motion.path.push_back({vector(5.0 * speed), vector(8.0 * speed), vector(20.0 * speed)});
    motion.turn.push_back((10.0 * speed * Eigen::Vector4d(next(), next(), next(), next())).cast<float>());
  }
  return scene;
}

Scene at_frame(Scene scene, double frame, double open, double close) {
  scene.frame = frame;
  scene.shutter = {open, close};
  return scene;
}

TEST(MovingSplats, AStillIsTheReferencesAtAnyTime) {
  for (const bool flat : {false, true}) {
    Scene scene = clip(600, 41);
    if (flat) {
      scene.objects[0].splats.flat = true;
      for (Eigen::Vector3f& scale : scene.objects[0].splats.scale) scale.z() = 0.0f;
    } else {
      scene.objects[0].splats.filter = SplatFilter::antialiased;
    }
    Image before;
    for (const double frame : {3.0, 7.4, 13.0, 21.5}) {
      const Scene still = at_frame(scene, frame, 0.0, 0.0);
      Image image = test::rendered(still, 1).image;
      EXPECT_GE(psnr_db(image, test::splat_reference(still, 1)), 80.0) << frame << ' ' << flat;
      // A test that can fail: time passes.
      if (!before.rgba.empty()) {
        EXPECT_LE(psnr_db(image, before), 40.0) << frame << ' ' << flat;
      }
      before = std::move(image);
    }
  }
}

TEST(MovingSplats, BlurredAtTheSameInstantsTheyAreTheReferences) {
  Scene scene = at_frame(clip(600, 42), 11.0, -0.5, 0.5);
  EXPECT_GE(psnr_db(test::rendered(scene, 8).image, test::splat_reference(scene, 8)), 80.0);
  // With all else that may move, and a shutter that opens slowly.
  scene.objects[0].transform.keys = {{10.0, {0, 0, 0}}, {12.0, {0.3, -0.2, 0.5}}};
  scene.objects[0].transform.keys[1].rotate_axis = {0, 0, 1};
  scene.objects[0].transform.keys[1].rotate_radians = 0.1;
  LookAtKey to = scene.camera.look_ats[0];
  to.frame = 13.0;
  to.eye.x() += 0.4;
  scene.camera.look_ats.push_back(to);
  scene.shutter.curve = ShutterShape::trapezoid;
  EXPECT_GE(psnr_db(test::rendered(scene, 8).image, test::splat_reference(scene, 8)), 80.0);
}

TEST(MovingSplats, TheErrorAskedForIsReached) {
  struct Case {
    unsigned seed;
    double speed, shortest, exposure;
  };
  for (const Case& c : {Case{51, 1.0, 0.05, 0.5}, Case{52, 1.0, 0.05, 2.0}, Case{53, 0.0, 0.05, 0.5},
                        Case{54, 0.0, 0.01, 2.0}, Case{55, 0.2, 0.02, 1.0}}) {
    const Scene scene =
        at_frame(clip(700, c.seed, c.speed, c.shortest), 12.0, -0.5 * c.exposure, 0.5 * c.exposure);
    const Rendered chosen = test::rendered(scene, 0);
    EXPECT_GE(psnr_db(chosen.image, test::rendered(scene, 1024).image), 60.0)
        << c.seed << ", " << test::counter(chosen, "instants_per_pixel");
  }
}

TEST(MovingSplats, WhoComesAndGoesWithinTheExposureIsSeen) {
  // There for a fiftieth of the exposure, at neither of its ends nor in its middle.
  Scene scene = at_frame(test::one_splat({0, 0, 5}, 0.5f, 0.9f, 0.9f), 0.0, 0.0, 10.0);
  scene.splats.least_light = 0.0;
  SplatMotion& motion = scene.objects[0].splats.motion.emplace();
  motion.frames = 10.0;
  motion.center = {0.3f};
  motion.duration = {0.02f};
  motion.path.resize(1, {Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()});
  motion.turn.resize(1, Eigen::Vector4f::Zero());
  const Image truth = test::splat_reference(scene, 1024), image = test::rendered(scene, 0).image;
  EXPECT_GT(*std::max_element(truth.rgba.begin(), truth.rgba.end()), 0.01f);
  EXPECT_GE(psnr_db(image, truth), 60.0);
}

TEST(MovingSplats, TheirOrderChangesNoBit) {
  const Scene scene = at_frame(clip(300, 43), 11.0, -0.25, 0.25);
  Scene turned = scene;
  SplatCloud& cloud = turned.objects[0].splats;
  const auto reverse = [](auto& values) { std::reverse(values.begin(), values.end()); };
  const SplatCloud& from = scene.objects[0].splats;
  for (std::size_t i = 0, n = from.size(); i < n; ++i) {
    const std::size_t j = n - 1 - i;
    cloud.position[i] = from.position[j];
    cloud.scale[i] = from.scale[j];
    cloud.rotation[i] = from.rotation[j];
    cloud.opacity[i] = from.opacity[j];
    for (std::size_t k = 0; k < 48; ++k) cloud.harmonics[48 * i + k] = from.harmonics[48 * j + k];
  }
  reverse(cloud.motion->center);
  reverse(cloud.motion->duration);
  reverse(cloud.motion->path);
  reverse(cloud.motion->turn);
  EXPECT_EQ(test::rendered(scene, 0).image.rgba, test::rendered(turned, 0).image.rgba);
}

TEST(MovingSplats, PathsBeyondWhatFloatCanSayAreNoHarm) {
  Scene scene = at_frame(clip(64, 44), 11.0, -0.5, 0.5);
  SplatMotion& motion = *scene.objects[0].splats.motion;
  for (std::size_t i = 0; i < 32; ++i) {
    motion.path[i][2] *= 1e38f / motion.path[i][2].cwiseAbs().maxCoeff();
    motion.turn[i] *= 1e37f;
    motion.duration[i] = i < 16 ? 1e-30f : 1e30f;
  }
  const Image image = test::rendered(scene, 0).image;
  EXPECT_TRUE(std::all_of(image.rgba.begin(), image.rgba.end(), [](float v) { return std::isfinite(v); }));
  EXPECT_GE(psnr_db(test::rendered(scene, 4).image, test::splat_reference(scene, 4)), 80.0);
}

TEST(MovingSplats, CountsAndRangesAreChecked) {
  Scene scene = clip(4, 45);
  SplatCloud& cloud = scene.objects[0].splats;
  cloud.motion->duration[2] = 0.0f;
  EXPECT_EQ(scene.validate().error().field, "/objects/0/splats/motion/duration[2]");
  cloud.motion->duration[2] = 1.0f;
  cloud.motion->frames = 0.0;
  EXPECT_EQ(scene.validate().error().field, "/objects/0/splats/motion/frames");
  cloud.motion->frames = 20.0;
  EXPECT_TRUE(scene.validate().ok());
  cloud.velocity.assign(4, Eigen::Vector3f::Zero());
  EXPECT_EQ(scene.validate().error().field, "/objects/0/splats/motion");
}

/// The cloud as SpacetimeGaussians' lite model stores it.
std::string lite_ply(const SplatCloud& cloud) {
  std::vector<std::string> names = {
      "x",        "y",        "z",        "trbf_center", "trbf_scale", "nx",       "ny",       "nz",
      "motion_0", "motion_1", "motion_2", "motion_3",    "motion_4",   "motion_5", "motion_6", "motion_7",
      "motion_8", "f_dc_0",   "f_dc_1",   "f_dc_2",      "opacity",    "scale_0",  "scale_1",  "scale_2",
      "rot_0",    "rot_1",    "rot_2",    "rot_3",       "omega_0",    "omega_1",  "omega_2",  "omega_3"};
  std::vector<std::vector<double>> rows;
  const SplatMotion& motion = *cloud.motion;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    std::vector<double> row;
    const auto put = [&](const auto& values) {
      for (int k = 0; k < static_cast<int>(values.size()); ++k) row.push_back(static_cast<double>(values[k]));
    };
    put(cloud.position[i]);
    row.push_back(motion.center[i]);
    row.push_back(std::log(motion.duration[i]));
    put(Eigen::Vector3d::Zero().eval());
    for (const Eigen::Vector3f& c : motion.path[i]) put(c);
    constexpr float first_harmonic = 0.28209479177387814f;
    for (int c = 0; c < 3; ++c)
      row.push_back(0.5f + first_harmonic * cloud.harmonics[3 * i + static_cast<std::size_t>(c)]);
    row.push_back(std::log(cloud.opacity[i] / (1.0f - cloud.opacity[i])));
    put(cloud.scale[i].array().log().matrix().eval());
    const Eigen::Quaternionf& q = cloud.rotation[i];
    put(Eigen::Vector4f(q.w(), q.x(), q.y(), q.z()));
    put(motion.turn[i]);
    rows.push_back(std::move(row));
  }
  return swept_test::float_ply("binary_little_endian", names, rows);
}

/// `clip` without harmonics beyond the first, as that model has none.
Scene plain_clip() {
  Scene scene = clip(300, 46);
  SplatCloud& cloud = scene.objects[0].splats;
  PointArray<float> first;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) first.push_back(cloud.harmonics[48 * i + c]);
  cloud.harmonics = first;
  cloud.degree = 0;
  for (float& opacity : cloud.opacity) opacity = std::clamp(opacity, 0.05f, 0.95f);
  return scene;
}

Result<SurfelCloud> no_generator(const std::string&, std::size_t, const std::map<std::string, double>&) {
  return Error{"", "", "no generators here"};
}

class MovingSplatsFile : public test::CloudCommandFolder {
 protected:
  /// What the command says while it draws frames 2 and 16 of clip.ply.
  std::string drawn_frames(std::vector<std::string> more) const {
    more.insert(more.begin(),
                {"render", "clip.ply", "-o", "f.%04d.exr", "--frames", "2,16", "--size", "96x54"});
    const test::Outcome outcome = swept(more);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.err;
  }
};

constexpr const char* scene_text = R"({"swept": 1, "frame": 3, "fps": 24, "splats": {"clip_frames": 20},
 "film": {"width": 150, "height": 100}, "shutter": {"open": -0.5, "close": 0.5},
 "camera": {"fov": {"axis": "vertical", "degrees": 50},
            "keys": [{"eye": [0, 0, 0], "target": [0, 0, 1], "up": [0, -1, 0]}]},
 "objects": [{"source": {"file": "clip.ply"}}]})";

TEST_F(MovingSplatsFile, ASceneFileDrawsThem) {
  const Scene made = plain_clip();
  test::put(folder_ / "clip.ply", lite_ply(made.objects[0].splats));
  test::put(folder_ / "scene.json", scene_text);
  Result<SceneFile> file = read_scene_file(folder_ / "scene.json", {});
  ASSERT_TRUE(file.ok()) << file.error().message();
  for (const double frame : {3.0, 12.0}) {
    const Result<const Scene*> scene = file->scene_at(frame, no_generator);
    ASSERT_TRUE(scene.ok()) << scene.error().message();
    EXPECT_GE(
        psnr_db(test::rendered(**scene, 6).image, test::splat_reference(at_frame(made, frame, -0.5, 0.5), 6)),
        80.0)
        << frame;
  }
  const std::vector<std::string> notes = file->notes();
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
    return note.find("over a clip of 20 frames from frame 3 on") != std::string::npos;
  }));
}

TEST_F(MovingSplatsFile, TheCommandDrawsThemFrameByFrame) {
  const Scene made = plain_clip();
  test::put(folder_ / "clip.ply", lite_ply(made.objects[0].splats));
  const std::string err = drawn_frames({"--clip-frames", "20"});
  EXPECT_NE(err.find("splats move by themselves, over a clip of 20 frames from frame 1 on"),
            std::string::npos)
      << err;
  const Result<Image> first = read_exr(folder_ / "f.0002.exr"), last = read_exr(folder_ / "f.0016.exr");
  ASSERT_TRUE(first.ok() && last.ok());
  EXPECT_LT(psnr_db(*first, *last), 40.0);
  // Unless it is said, a clip has fifty frames.
  EXPECT_NE(drawn_frames({"--overwrite"}).find("over a clip of 50 frames"), std::string::npos);
  EXPECT_EQ(swept({"render", "clip.ply", "-o", "x.exr", "--clip-frames", "0"}).exit_code, 2);
}

TEST_F(MovingSplatsFile, EveryTruncationIsRefused) {
  const Scene made = plain_clip();
  SplatCloud few = made.objects[0].splats;
  const std::string whole = lite_ply(few);
  SplatReadOptions options;
  options.motion = true;
  ASSERT_TRUE(io::read_splat_ply("clip.ply", whole, options).ok());
  const std::size_t header = whole.find("end_header"), step = 17;
  for (std::size_t size = 0; size < whole.size(); size += size < header + 500 ? 1 : step) {
    const Result<LoadedSplats> cut =
        io::read_splat_ply("clip.ply", std::string_view(whole).substr(0, size), options);
    ASSERT_FALSE(cut.ok()) << size;
    EXPECT_FALSE(cut.error().reason.empty());
    EXPECT_EQ(cut.error().message().find('\n'), std::string::npos);
  }
}

TEST_F(MovingSplatsFile, ASequenceOfThemIsRefusedByName) {
  const std::string bytes = lite_ply(plain_clip().objects[0].splats);
  test::put(folder_ / "a.0001.ply", bytes);
  test::put(folder_ / "a.0002.ply", bytes);
  const test::Outcome outcome = swept({"render", "a.%04d.ply", "-o", "x.%04d.exr"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("trbf_center"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace swept
