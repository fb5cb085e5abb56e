#include "splat/io/scene_file.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

namespace swept {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr const char* base_scene = R"({
  "swept": 1,
  "film": {"width": 320, "height": 180},
  "fps": [24000, 1001],
  "frame": 7,
  "shutter": {"open": -0.25, "close": 0.25},
  "camera": {
    "fov": {"axis": "vertical", "degrees": 40},
    "near": 0.01,
    "keys": [{"frame": 1, "eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]},
             {"frame": 9, "eye": [1, 0, 5], "target": [1, 0, 0], "up": [0, 1, 0]}]
  },
  "background": [0, 0, 0, 0],
  "image": {"delta": 3, "coverage": "soft", "segments": 2},
  "objects": [{
    "name": "knot",
    "source": {"generator": "dots", "points": 3, "seed": 1},
    "transform": {"keys": [{"frame": 0, "rotate": {"axis": [0, 2, 0], "degrees": 0}},
                           {"frame": 4, "translate": [1, 2, 3], "rotate": {"axis": [0, 1, 0], "degrees": 720}}]},
    "facing": "one_sided",
    "segments": 4
  }]
})";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "the base scene has no " << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// A fresh folder for each test, removed with it.
class SceneFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "swept-scene-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string write(const std::string& text, const std::string& name = "scene.json") const {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  SceneFile read(const std::string& text, const SceneOverrides& overrides = {}) const {
    Result<SceneFile> file = read_scene_file(write(text), overrides);
    EXPECT_TRUE(file.ok()) << file.error().message();
    if (!file.ok()) std::abort();  // nothing after it would make sense
    return std::move(*file);
  }

  fs::path folder_;
};

/// Points on the x axis with axes of length 0.5 and velocities along z.
Result<SurfelCloud> dots(const std::string& shape, std::size_t points, const std::map<std::string, double>&) {
  if (shape != "dots") return Error{"", "generator", "no such shape"};
  SurfelCloud cloud;
  cloud.keys.emplace_back();
  for (std::size_t i = 0; i < points; ++i) {
    cloud.keys[0].pose.position.emplace_back(static_cast<double>(i), 0.0, 0.0);
    cloud.keys[0].pose.axis_u.emplace_back(0.5f, 0.0f, 0.0f);
    cloud.keys[0].pose.axis_v.emplace_back(0.0f, 0.25f, 0.0f);
    cloud.velocity.emplace_back(0.0f, 0.0f, 1.0f);
  }
  return cloud;
}

struct BadScene {
  const char* name;
  const char* from;  ///< in the base scene
  const char* to;
  const char* field;
  const char* reason;  ///< part of it
};

const BadScene bad_scenes[] = {
    {"syntax", "\"fps\":", "\"fps\"", "line 4, column 9", "expected"},
    {"trailing comma", "\"segments\": 4\n", "\"segments\": 4,\n", "line 22, column 3", "expected"},
    {"comment", "\"fps\"", "// rate\n\"fps\"", "line 4, column 3", "invalid literal"},
    {"NaN", "0.25}", "NaN}", "line 6, column 39", "invalid literal"},
    {"infinity", "0.25}", "1e999}", "line 6, column 43", "too large"},
    {"key twice", "\"seed\": 1", "\"points\": 1", "/objects/0/source/points", "twice"},
    {"no version", "\"swept\": 1,", "", "", "\"swept\", the format's version, is missing"},
    {"newer version", "\"swept\": 1", "\"swept\": 2", "/swept", "newer version"},
    {"no such version", "\"swept\": 1", "\"swept\": 0", "/swept", "only version"},
    {"version of the wrong type", "\"swept\": 1", "\"swept\": \"1\"", "/swept",
     "expected a number, found string"},
    {"unknown key", "\"width\"", "\"widht\"", "/film/widht", "did you mean \"width\"?"},
    {"unknown key at the top", "\"shutter\"", "\"shuter\"", "/shuter", "did you mean \"shutter\"?"},
    {"unknown key, nothing near", "\"near\"", "\"zzzzzz\"", "/camera/zzzzzz", "known here: \"fov\""},
    {"unknown key with a slash", "\"near\"", "\"n/e~ar\"", "/camera/n~1e~0ar", "unknown key"},
    {"wrong type", "\"width\": 320", "\"width\": \"320\"", "/film/width", "expected a number, found string"},
    {"object for array", "\"background\": [0, 0, 0, 0]", "\"background\": {}", "/background",
     "expected an array"},
    {"null", "\"near\": 0.01", "\"near\": null", "/camera/near", "expected a number, found null"},
    {"film without width", "\"width\": 320, ", "", "/film", "\"width\" is missing"},
    {"film of no size", "\"height\": 180", "\"height\": 0", "/film/height", "between 1 and 65536"},
    {"fractional film", "\"width\": 320", "\"width\": 320.5", "/film/width", "whole number"},
    {"huge film", "\"width\": 320", "\"width\": 1e300", "/film/width", "between 1 and 65536"},
    {"fps of zero", "1001]", "0]", "/fps/1", "between 1 and"},
    {"fps of one term", "[24000, 1001]", "[24]", "/fps", "expected 2 numbers, found 1"},
    {"shutter backwards", "\"open\": -0.25", "\"open\": 0.5", "/shutter", "closes before it opens"},
    {"alpha above 1", "\"background\": [0, 0, 0, 0]", "\"background\": [0, 0, 0, 2]", "/background", "alpha"},
    {"background too short", "\"background\": [0, 0, 0, 0]", "\"background\": [0, 0]", "/background",
     "found 2"},
    {"delta", "\"delta\": 3", "\"delta\": 0", "/image/delta", "above 0"},
    {"coverage", "\"soft\"", "\"sofd\"", "/image/coverage", "did you mean \"soft\"?"},
    {"segments", "\"segments\": 2", "\"segments\": 5000", "/image/segments", "between 1 and 4096"},
    {"no camera", "\"camera\"", "\"frame2\"", "/frame2", "unknown key"},
    {"fov without axis", "\"axis\": \"vertical\", ", "", "/camera/fov", "\"axis\" is missing"},
    {"fov axis", "\"vertical\"", "\"verticle\"", "/camera/fov/axis", "did you mean \"vertical\"?"},
    {"fov of zero", "\"degrees\": 40", "\"degrees\": 0", "/camera/fov/degrees", "above 0 and below 180"},
    {"fov of 180", "\"degrees\": 40", "\"degrees\": 180", "/camera/fov/degrees", "above 0 and below 180"},
    {"no fov", "\"fov\": {\"axis\": \"vertical\", \"degrees\": 40},", "", "/camera/keys/0",
     "no field of view"},
    {"near of zero", "\"near\": 0.01", "\"near\": 0", "/camera/near", "above 0"},
    {"no keys", "\"keys\": [{\"frame\": 1,", "\"keys\": [], \"near2\": [{\"frame\": 1,", "/camera/near2",
     "unknown"},
    {"camera keys unsorted", "\"frame\": 9", "\"frame\": 1", "/camera/keys/1/frame", "increasing"},
    {"camera key without frame", "\"frame\": 9, ", "", "/camera/keys/1", "\"frame\" is missing"},
    {"singular camera", "\"eye\": [1, 0, 5]", "\"eye\": [1, 0, 0]", "/camera/keys/1/target",
     "where the eye is"},
    {"up along the view", "\"up\": [0, 1, 0]", "\"up\": [0, 0, 2]", "/camera/keys/0/up", "parallel"},
    {"target through the eye", "\"eye\": [1, 0, 5]", "\"eye\": [1, 0, -5]", "/camera/keys/1",
     "meets the target"},
    {"convention of a look-at", "\"near\": 0.01", "\"convention\": \"opencv\"", "/camera/convention",
     "matrix keys"},
    {"mixed keys", "{\"frame\": 9, \"eye\": [1, 0, 5], \"target\"",
     "{\"frame\": 9, \"matrix\": [], \"target\"", "/camera/keys/1", "all look-ats or all matrices"},
    {"no source", "\"source\"", "\"frame\"", "/objects/0/frame", "unknown key"},
    {"two sources", "\"generator\": \"dots\"", "\"generator\": \"dots\", \"file\": \"a.ply\"",
     "/objects/0/source", "exactly one"},
    {"no points", "\"points\": 3", "\"points\": 0", "/objects/0/source/points", "between 1 and"},
    {"negative points", "\"points\": 3", "\"points\": -1", "/objects/0/source/points", "between 1 and"},
    {"text parameter", "\"seed\": 1", "\"seed\": \"one\"", "/objects/0/source/seed", "expected a number"},
    {"transform keys unsorted", "\"frame\": 4", "\"frame\": -1", "/objects/0/transform/keys/1/frame",
     "increasing"},
    {"axis of zero", "\"axis\": [0, 2, 0]", "\"axis\": [0, 0, 0]", "/objects/0/transform/keys/0/rotate/axis",
     "zero"},
    {"rotation without degrees", ", \"degrees\": 720", "", "/objects/0/transform/keys/1/rotate",
     "\"degrees\" is"},
    {"facing", "\"one_sided\"", "true", "/objects/0/facing", "expected a string, found boolean"},
    {"unit of generated velocities", "\"name\": \"knot\"", "\"velocity\": {\"unit\": \"per_second\"}",
     "/objects/0/velocity/unit", "per frame"},
    {"radius", "\"name\": \"knot\"", "\"radius\": 0", "/objects/0/radius", "above 0"},
    {"sequence backwards", "{\"generator\": \"dots\", \"points\": 3, \"seed\": 1}",
     "{\"sequence\": \"a.%04d.ply\", \"first\": 2, \"last\": 1}", "/objects/0/source/last",
     "before the first"},
    {"end frame alone", "{\"generator\": \"dots\", \"points\": 3, \"seed\": 1}",
     "{\"file\": \"a.ply\", \"end_frame\": 1}", "/objects/0/source/end_frame", "end_file"},
    {"empty path", "{\"generator\": \"dots\", \"points\": 3, \"seed\": 1}", "{\"file\": \"\"}",
     "/objects/0/source/file", "empty"},
};

TEST_F(SceneFiles, ErrorsNameFilePointerAndReason) {
  for (const BadScene& bad : bad_scenes) {
    const std::string path = write(replaced(base_scene, bad.from, bad.to));
    const Result<SceneFile> file = read_scene_file(path);
    ASSERT_FALSE(file.ok()) << bad.name;
    EXPECT_EQ(file.error().file, path) << bad.name;
    EXPECT_EQ(file.error().field, bad.field) << bad.name;
    EXPECT_NE(file.error().reason.find(bad.reason), std::string::npos)
        << bad.name << ": " << file.error().reason;
  }
}

TEST_F(SceneFiles, UnreadableFiles) {
  const std::string missing = (folder_ / "none.json").string();
  for (const auto& [path, reason] : {std::pair{missing, "cannot open"},
                                     {folder_.string(), "folder"},
                                     {write(""), "unexpected end"},
                                     {write("[1, 2]", "array.json"), "one JSON object"},
                                     {write("\xff\xfe{", "utf16.json"), "invalid"},
                                     {write(std::string(1'000'000, '['), "deep.json"), "unexpected end"}}) {
    const Result<SceneFile> file = read_scene_file(path);
    ASSERT_FALSE(file.ok()) << path;
    EXPECT_EQ(file.error().file, path);
    EXPECT_NE(file.error().reason.find(reason), std::string::npos) << file.error().message();
  }
}

/// The error that loading a scene with this source ends in.
Error load_error(const std::string& path) {
  Result<SceneFile> file = read_scene_file(path);
  EXPECT_TRUE(file.ok()) << file.error().message();
  if (!file.ok()) return file.error();
  const Result<const Scene*> scene = file->scene_at(1.0, dots);
  EXPECT_FALSE(scene.ok());
  return scene.ok() ? Error{} : scene.error();
}

TEST_F(SceneFiles, CloudErrorsNameTheSource) {
  const std::string source = "{\"generator\": \"dots\", \"points\": 3, \"seed\": 1}";
  std::string path = write(replaced(base_scene, "\"dots\"", "\"dashes\""));
  Error error = load_error(path);
  EXPECT_EQ(error.file, path);
  EXPECT_EQ(error.field, "/objects/0/source/generator");
  EXPECT_EQ(error.reason, "no such shape");

  path = write(replaced(base_scene, source, R"({"file": "none.ply"})"));
  error = load_error(path);
  EXPECT_EQ(error.file, path);
  EXPECT_EQ(error.field, "/objects/0/source/file");
  EXPECT_EQ(error.reason, "there is no file " + (folder_ / "none.ply").string());

  path = write(replaced(base_scene, source, R"({"sequence": "none.####.ply", "first": 0, "last": 9})"));
  error = load_error(path);
  EXPECT_EQ(error.field, "/objects/0/source/sequence");
  EXPECT_EQ(error.reason, "there is no file " + (folder_ / "none.0000.ply").string());

  path = write(replaced(base_scene, source, R"({"sequence": "none.ply", "first": 0, "last": 9})"));
  EXPECT_EQ(load_error(path).field, "/objects/0/source/sequence");

  std::string text =
      replaced(base_scene, source, R"({"sequence": "none.####.ply", "first": 0, "last": 9, "cycle": true})");
  text = replaced(text, "\"close\": 0.25", "\"close\": 1e9");
  EXPECT_NE(load_error(write(text)).reason.find("more than 10000 files"), std::string::npos);
}

TEST_F(SceneFiles, EverythingArrives) {
  SceneFile file = read(base_scene);
  const Result<const Scene*> loaded = file.scene_at(3.0, dots);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  const Scene& scene = **loaded;
  EXPECT_EQ(scene.frame, 3.0);
  EXPECT_EQ(scene.film.width, 320);
  EXPECT_EQ(scene.film.height, 180);
  EXPECT_EQ(scene.fps.numerator, 24000);
  EXPECT_EQ(scene.fps.denominator, 1001);
  EXPECT_EQ(scene.shutter.open, -0.25);
  EXPECT_EQ(scene.model.segments, 2);
  EXPECT_EQ(scene.camera.near, 0.01);
  ASSERT_EQ(scene.camera.look_ats.size(), 2u);
  EXPECT_EQ(scene.camera.look_ats[1].frame, 9.0);
  EXPECT_DOUBLE_EQ(scene.camera.look_ats[1].tan_half_fov_y, std::tan(std::numbers::pi / 9));
  ASSERT_EQ(scene.objects.size(), 1u);
  const Object& object = scene.objects[0];
  EXPECT_EQ(object.name, "knot");
  EXPECT_EQ(object.cloud.size(), 3u);
  EXPECT_FALSE(object.two_sided);
  EXPECT_EQ(object.segments, 4);
  ASSERT_EQ(object.transform.keys.size(), 2u);
  EXPECT_EQ(object.transform.keys[0].rotate_axis, Vector3d::UnitY());
  EXPECT_DOUBLE_EQ(object.transform.keys[1].rotate_radians, 4 * std::numbers::pi);
  EXPECT_EQ(object.transform.keys[1].translate, Vector3d(1, 2, 3));
  const Status valid = scene.validate();
  EXPECT_TRUE(valid.ok()) << valid.error().message();
}

TEST_F(SceneFiles, DefaultsAreThoseOfTheTypes) {
  const SceneFile file = read(R"({"swept": 1, "objects": [],
    "camera": {"fov": {"axis": "vertical", "degrees": 90}, "keys": [{"eye": [0,0,5], "target": [0,0,0]}]}})");
  const Scene expected, &scene = file.scene();
  EXPECT_EQ(scene.frame, 1.0);
  EXPECT_EQ(scene.film.width, expected.film.width);
  EXPECT_EQ(scene.fps.numerator, expected.fps.numerator);
  EXPECT_EQ(scene.shutter.close, expected.shutter.close);
  EXPECT_EQ(scene.background, expected.background);
  EXPECT_EQ(scene.model.edge_weight, expected.model.edge_weight);
  EXPECT_EQ(scene.camera.look_ats[0].up, Vector3d::UnitY());
}

TEST_F(SceneFiles, FieldOfViewFollowsItsAxis) {
  // 400 × 300 has a diagonal of 500.
  for (const auto& [axis, tangent] :
       {std::pair{"vertical", 1.0}, {"horizontal", 300.0 / 400.0}, {"diagonal", 300.0 / 500.0}}) {
    std::string text = replaced(base_scene, "\"axis\": \"vertical\", \"degrees\": 40",
                                std::string("\"axis\": \"") + axis + "\", \"degrees\": 90");
    SceneOverrides overrides;
    overrides.size = {400, 300};
    EXPECT_DOUBLE_EQ(read(text, overrides).scene().camera.look_ats[0].tan_half_fov_y, tangent) << axis;
  }
}

std::string matrix_scene(const std::string& matrix, const std::string& convention = "") {
  return R"({"swept": 1, "objects": [], "camera": {"fov": {"axis": "vertical", "degrees": 40}, )" +
         convention + R"("keys": [{"matrix": )" + matrix + "}]}}";
}

TEST_F(SceneFiles, MatrixIsCameraToWorldInOpenGlAxesUnlessSaidOtherwise) {
  // Both say: eye at (1, 2, 8), looking along −z, y up.
  const SceneFile opengl = read(matrix_scene("[1,0,0,1, 0,1,0,2, 0,0,1,8, 0,0,0,1]"));
  const SceneFile opencv =
      read(matrix_scene("[1,0,0,1, 0,-1,0,2, 0,0,-1,8, 0,0,0,1]", R"("convention": "opencv", )"));
  for (const SceneFile* file : {&opengl, &opencv}) {
    const CameraInstant camera = file->scene().camera.at(0.0);
    EXPECT_EQ(camera.camera_from_world * Vector3d(1, 2, 3), Vector3d(0, 0, 5));
    EXPECT_EQ(camera.camera_from_world * Vector3d(2, 3, 3), Vector3d(1, -1, 5));
  }
}

TEST_F(SceneFiles, RoundedMatricesPassAndOthersDoNot) {
  // A turn by 30 degrees with four decimals.
  const SceneFile file = read(matrix_scene("[0.8660,0,0.5000,0, 0,1,0,0, -0.5000,0,0.8660,0, 0,0,0,1]"));
  const Eigen::Matrix3d r = file.scene().camera.at(0.0).camera_from_world.linear();
  EXPECT_LE((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(),
            1e-15);  // 16 products of a few ulp each
  for (const auto& [matrix, reason] : {std::pair{"[1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1]", "singular"},
                                       {"[2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1]", "scales"},
                                       {"[1,0.01,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]", "shears"},
                                       {"[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]", "mirrors"},
                                       {"[1e200,0,0,0, 0,1e200,0,0, 0,0,1e200,0, 0,0,0,1]", "not rigid"},
                                       {"[1,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1]", "last row"},
                                       {"[1,0,0,0]", "expected 16 numbers"}}) {
    const Result<SceneFile> bad = read_scene_file(write(matrix_scene(matrix)));
    ASSERT_FALSE(bad.ok()) << matrix;
    EXPECT_EQ(bad.error().field, "/camera/keys/0/matrix");
    EXPECT_NE(bad.error().reason.find(reason), std::string::npos) << bad.error().message();
  }
}

TEST_F(SceneFiles, GeneratedCloudsTakeTheObjectsAttributes) {
  const std::string text = replaced(base_scene, "\"name\": \"knot\"",
                                    R"("color": [0.5, 0.25, 1], "radius": 0.125, "radius_scale": 2,
                                       "velocity": {"unit": "ignore"})");
  SceneOverrides overrides;
  overrides.points_scale = 2.0;
  SceneFile file = read(text, overrides);
  const Result<const Scene*> scene = file.scene_at(1.0, dots);
  ASSERT_TRUE(scene.ok()) << scene.error().message();
  const SurfelCloud& cloud = (*scene)->objects[0].cloud;
  ASSERT_EQ(cloud.size(), 6u);
  EXPECT_TRUE(cloud.velocity.empty());
  EXPECT_EQ(cloud.color.back(), Vector3f(0.5f, 0.25f, 1.0f));
  const SurfelPose& pose = cloud.keys[0].pose;
  const Vector3f normal = pose.axis_u[5].cross(pose.axis_v[5]);
  // Single precision: 4 ulp of the numbers compared.
  EXPECT_NEAR(pose.axis_u[5].norm(), 0.25f, 4 * 0.25f * 1.2e-7f);
  EXPECT_NEAR(pose.axis_v[5].norm(), 0.25f, 4 * 0.25f * 1.2e-7f);
  EXPECT_NEAR(normal.z(), 0.0625f, 4 * 0.0625f * 1.2e-7f);
}

TEST_F(SceneFiles, StillCloudsAreMadeOnce) {
  int calls = 0;
  SceneFile file = read(base_scene);
  const Generator counting = [&](const auto& shape, std::size_t points, const auto& parameters) {
    ++calls;
    EXPECT_EQ(parameters.at("seed"), 1.0);
    return dots(shape, points, parameters);
  };
  for (const double frame : {1.0, 2.0, 3.0}) {
    const Result<const Scene*> scene = file.scene_at(frame, counting);
    ASSERT_TRUE(scene.ok());
    EXPECT_EQ((*scene)->frame, frame);
    EXPECT_EQ((*scene)->objects[0].cloud.size(), 3u);
  }
  EXPECT_EQ(calls, 1);
}

/// A triangle of which the first vertex is at (x, 0, 0).
std::string triangle(double x) { return "v " + std::to_string(x) + " 0 0\nv 1 0 -4\nv 0 1 -4\nf 1 2 3\n"; }

TEST_F(SceneFiles, SequencesHoldTheFilesAroundTheShutterAndCycle) {
  for (int n = 2; n <= 4; ++n) write(triangle(n), "walk.000" + std::to_string(n) + ".obj");
  for (const bool cycle : {false, true}) {
    const std::string text =
        replaced(base_scene, "{\"generator\": \"dots\", \"points\": 3, \"seed\": 1}",
                 std::string(R"({"sequence": "walk.####.obj", "first": 2, "last": 4, "cycle": )") +
                     (cycle ? "true}" : "false}"));
    SceneFile file = read(text);
    // Frame, and where the first point is at it: files 2, 3, 4 say 2, 3, 4.
    for (const auto& [frame, held, cycled] : {std::array{3.0, 3.0, 3.0},
                                              {2.5, 2.5, 2.5},
                                              {1.0, 2.0, 4.0},
                                              {5.0, 4.0, 2.0},
                                              {4.25, 4.0, 3.5},
                                              {-1.0, 2.0, 2.0},
                                              {302.0, 4.0, 2.0}}) {
      const Result<const Scene*> scene = file.scene_at(frame, dots);
      ASSERT_TRUE(scene.ok()) << scene.error().message();
      const SurfelCloud& cloud = (*scene)->objects[0].cloud;
      EXPECT_EQ(surfel_at(cloud, 0, frame).position.x(), cycle ? cycled : held) << frame;
      EXPECT_LE(cloud.keys.size(), 3u);
    }
  }
}

TEST_F(SceneFiles, TwoFilesMoveFromOneFrameToTheNext) {
  write(triangle(2), "a.obj");
  write(triangle(3), "b.obj");
  SceneFile file = read(replaced(base_scene, "{\"generator\": \"dots\", \"points\": 3, \"seed\": 1}",
                                 R"({"file": "a.obj", "end_file": "b.obj"})"));
  const Result<const Scene*> scene = file.scene_at(1.0, dots);
  ASSERT_TRUE(scene.ok()) << scene.error().message();
  // The scene's own frame, 7, is when the first file holds.
  EXPECT_EQ(surfel_at((*scene)->objects[0].cloud, 0, 7.5).position.x(), 2.5);
}

TEST_F(SceneFiles, VelocitiesPerSecondAreDividedByTheFrameRate) {
  write(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property float vx\nproperty float vy\nproperty float vz\nproperty float radius\nend_header\n"
      "0 0 0 48 0 0 0.5\n1 0 0 0 24 0 0.5\n",
      "fast.ply");
  for (const auto& [unit, expected] : {std::pair{"per_second", 2.0f}, {"per_frame", 48.0f}}) {
    std::string text =
        replaced(base_scene, "{\"generator\": \"dots\", \"points\": 3, \"seed\": 1}",
                 std::string(R"({"file": "fast.ply"}, "velocity": {"unit": ")") + unit + "\"}");
    text = replaced(text, "[24000, 1001]", "24");
    SceneFile file = read(text);
    const Result<const Scene*> scene = file.scene_at(1.0, dots);
    ASSERT_TRUE(scene.ok()) << scene.error().message();
    EXPECT_EQ((*scene)->objects[0].cloud.velocity[0], Vector3f(expected, 0, 0));
    EXPECT_EQ((*scene)->objects[0].cloud.keys[0].frame, 7.0);
  }
}

TEST_F(SceneFiles, OverridesReachTheSceneAndAreValidated) {
  SceneOverrides overrides;
  overrides.size = {64, 48};
  overrides.crop = {8, 4, 16, 12};
  overrides.shutter = Shutter{0.0, 0.5};
  overrides.segments = 7;
  overrides.coverage = Coverage::hard;
  const SceneFile file = read(base_scene, overrides);
  EXPECT_EQ(file.scene().film.window_width(), 16);
  EXPECT_EQ(file.scene().shutter.close, 0.5);
  EXPECT_EQ(file.scene().model.segments, 7);
  EXPECT_EQ(file.scene().objects[0].segments, 0);
  EXPECT_EQ(file.scene().model.coverage, Coverage::hard);

  overrides.crop = {60, 0, 16, 12};
  const Result<SceneFile> outside = read_scene_file(write(base_scene), overrides);
  ASSERT_FALSE(outside.ok());
  EXPECT_EQ(outside.error().field, "/film/crop");
}

TEST_F(SceneFiles, HashFollowsContentAndNotLayout) {
  const SceneFile file = read(base_scene);
  EXPECT_EQ(file.hash("").size(), 16u);
  EXPECT_EQ(read(replaced(base_scene, "\"fps\": [", "  \"fps\":[  ")).hash(""), file.hash(""));
  EXPECT_NE(read(replaced(base_scene, "\"frame\": 7", "\"frame\": 8")).hash(""), file.hash(""));
  EXPECT_NE(file.hash("samples 2"), file.hash("samples 4"));
  SceneOverrides overrides;
  overrides.points_scale = 0.5;
  EXPECT_NE(read(base_scene, overrides).hash(""), file.hash(""));
}

}  // namespace
}  // namespace swept
