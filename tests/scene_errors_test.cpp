// What a scene file may not say: each error names file, JSON pointer and reason.
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "splat/io/scene_file.h"
#include "tests/scene_text.h"

namespace swept {
namespace {

using test::base_scene;
using test::base_source;
using test::dots;
using test::matrix_scene;
using test::replaced;
using SceneErrors = test::SceneFiles;

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
    {"alpha above 1", "\"background\": [0, 0, 0, 0]", "\"background\": [0, 0, 0, 2]", "/background/3",
     "alpha"},
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
    {"two lenses", "\"near\": 0.01", "\"near\": 0.01, \"intrinsics\": {}", "/camera/intrinsics", "beside it"},
    {"intrinsics without a size", "\"fov\": {\"axis\": \"vertical\", \"degrees\": 40}",
     "\"intrinsics\": {\"fx\": 100, \"width\": 640}", "/camera/intrinsics", "\"height\" is missing"},
    {"no focal length", "\"fov\": {\"axis\": \"vertical\", \"degrees\": 40}",
     "\"intrinsics\": {\"fx\": 0, \"width\": 640, \"height\": 480}", "/camera/intrinsics/fx", "above 0"},
    {"focal lengths far apart", "\"fov\": {\"axis\": \"vertical\", \"degrees\": 40}",
     "\"intrinsics\": {\"fx\": 1e6, \"fy\": 1, \"width\": 640, \"height\": 480}",
     "/camera/keys/0/intrinsics/fx", "1000 times"},
    {"principal point far away", "\"fov\": {\"axis\": \"vertical\", \"degrees\": 40}",
     "\"intrinsics\": {\"fx\": 1, \"width\": 640, \"height\": 480, \"cy\": 1e9}",
     "/camera/keys/0/intrinsics/cy", "1000 heights"},
    {"roll", "\"up\": [0, 1, 0]", "\"up\": [0, 1, 0], \"roll\": 1e30", "/camera/keys/0/roll", "roll"},
    {"direction of normals", "\"facing\": \"one_sided\"", "\"color\": {\"normals\": [0, 0, 0]}",
     "/objects/0/color/normals", "direction is zero"},
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
    {"sequence backwards", base_source, "{\"sequence\": \"a.%04d.ply\", \"first\": 2, \"last\": 1}",
     "/objects/0/source/last", "before the first"},
    {"end frame alone", base_source, "{\"file\": \"a.ply\", \"end_frame\": 1}", "/objects/0/source/end_frame",
     "end_file"},
    {"empty path", base_source, "{\"file\": \"\"}", "/objects/0/source/file", "empty"},
};

TEST_F(SceneErrors, ErrorsNameFilePointerAndReason) {
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

TEST_F(SceneErrors, UnreadableFiles) {
  const std::string missing = folder_ / "none.json";
  for (const auto& [path, reason] : {std::pair{missing, "cannot open"},
                                     {folder_ / "", "folder"},
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

TEST_F(SceneErrors, CloudErrorsNameTheSource) {
  std::string path = write(replaced(base_scene, "\"dots\"", "\"dashes\""));
  Error error = load_error(path);
  EXPECT_EQ(error.file, path);
  EXPECT_EQ(error.field, "/objects/0/source/generator");
  EXPECT_EQ(error.reason, "no such shape");

  path = write(replaced(base_scene, base_source, R"({"file": "none.ply"})"));
  error = load_error(path);
  EXPECT_EQ(error.file, path);
  EXPECT_EQ(error.field, "/objects/0/source/file");
  EXPECT_EQ(error.reason, "there is no file " + (folder_ / "none.ply"));

  path = write(replaced(base_scene, base_source, R"({"sequence": "none.####.ply", "first": 0, "last": 9})"));
  error = load_error(path);
  EXPECT_EQ(error.field, "/objects/0/source/sequence");
  EXPECT_EQ(error.reason, "there is no file " + (folder_ / "none.0000.ply"));

  path = write(replaced(base_scene, base_source, R"({"sequence": "none.ply", "first": 0, "last": 9})"));
  EXPECT_EQ(load_error(path).field, "/objects/0/source/sequence");

  std::string text = replaced(base_scene, base_source,
                              R"({"sequence": "none.####.ply", "first": 0, "last": 9, "cycle": true})");
  text = replaced(text, "\"close\": 0.25", "\"close\": 1e9");
  EXPECT_NE(load_error(write(text)).reason.find("more than 10000 files"), std::string::npos);
}

TEST_F(SceneErrors, MatricesThatAreNotRigid) {
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

}  // namespace
}  // namespace swept
