// Cameras of other tools: points are projected where these tools' own formulas have them.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "splat/io/scene_file.h"
#include "tests/command.h"
#include "tests/gltf_files.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::put;

constexpr const char* plain_scene = R"({"swept": 1, "film": {"width": 640, "height": 480},
  "camera": {"near": 0.25, "fov": {"axis": "vertical", "degrees": 40},
             "keys": [{"eye": [0, 0, 9], "target": [0, 0, 0]}]}, "objects": []})";

class CameraFiles : public testing::Test {
 protected:
  Result<SceneFile> open(const std::string& name) {
    SceneOverrides overrides;
    overrides.camera_file = folder_ / name;
    return scene_from_text(plain_scene, "scene.json", overrides);
  }
  SceneFile read(const std::string& name) {
    Result<SceneFile> file = open(name);
    if (!file) throw std::runtime_error(file.error().message());
    return std::move(*file);
  }
  void expect_refused(const std::string& name, const std::string& message) {
    const Result<SceneFile> file = open(name);
    ASSERT_FALSE(file.ok()) << message;
    EXPECT_NE(file.error().message().find(message), std::string::npos) << file.error().message();
    EXPECT_NE(file.error().file.find(folder_ / ""), std::string::npos) << file.error().message();
  }

  test::TemporaryFolder folder_;
};

/// Where the camera at a frame sees a point, px from the upper left corner.
Vector2d seen(const Scene& scene, double frame, const Vector3d& point) {
  const CameraInstant camera = scene.camera.at(frame);
  const Projection film = projection_of(scene.film, camera);
  const Vector3d p = lens_matrix(camera, camera) * (camera.camera_from_world * point);
  EXPECT_GT(p.z(), 0.0);
  return Vector2d(film.center_x, film.center_y) + film.focal_px * p.head<2>() / p.z();
}

const Vector3d points[] = {{0, 0, 0}, {0.3, -0.2, 0.5}, {-0.4, 0.6, -1}};

/// Camera to world, in the axes of OpenGL: turned about y, at `eye`.
Eigen::Matrix4d pose(double radians, const Vector3d& eye) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = Eigen::AngleAxisd(radians, Vector3d::UnitY()).toRotationMatrix();
  matrix.topRightCorner<3, 1>() = eye;
  return matrix;
}

std::string rows(const Eigen::Matrix4d& matrix) {
  std::string text = "[";
  for (int row = 0; row < 4; ++row) {
    text += row > 0 ? ",[" : "[";
    for (int column = 0; column < 4; ++column) {
      if (column > 0) text += ',';
      text += shortest_text(matrix(row, column));
    }
    text += ']';
  }
  return text + ']';
}

struct Focal {
  double x, y, cx, cy;
};

/// By the formula of OpenGL's axes: x right, y up, z towards the eye.
Vector2d expected(const Eigen::Matrix4d& matrix, const Focal& f, const Vector3d& point) {
  const Vector3d p = matrix.topLeftCorner<3, 3>().transpose() * (point - matrix.topRightCorner<3, 1>());
  return {f.cx - f.x * p.x() / p.z(), f.cy + f.y * p.y() / p.z()};
}

TEST_F(CameraFiles, TransformsHaveIntrinsicsOfAllFramesAndOfEach) {
  const Eigen::Matrix4d first = pose(0.3, {1.5, 0.2, 4}), second = pose(-0.2, {-1, 0.5, 6});
  put(folder_ / "transforms.json",
      R"({"camera_model": "OPENCV", "fl_x": 700, "fl_y": 650, "cx": 300, "cy": 261.5, "w": 640, "h": 480,
          "k1": 0.02, "k2": 0, "applied_scale": 1, "frames": [
          {"file_path": "a.png", "transform_matrix": )" +
          rows(first) + R"(}, {"file_path": "b.png", "fl_x": 350, "fl_y": 300, "cx": 100, "w": 320, "h": 240,
          "cy": 130, "transform_matrix": )" +
          rows(second) + "}]}");
  const SceneFile file = read("transforms.json");
  // The second picture is half as large: it is seen at twice its size.
  for (const Vector3d& p : points) {
    EXPECT_LT((seen(file.scene(), 1, p) - expected(first, {700, 650, 300, 261.5}, p)).norm(), 1e-9);
    EXPECT_LT((seen(file.scene(), 2, p) - 2.0 * expected(second, {350, 300, 100, 130}, p)).norm(), 1e-9);
  }
  EXPECT_EQ(file.scene().camera.near, 0.25) << "the scene's own stays";
  ASSERT_EQ(file.notes().size(), 2u);
  EXPECT_NE(file.notes()[1].find("distortion k1 of"), std::string::npos);
}

TEST_F(CameraFiles, AnglesAreFocalLengthsOfTheFilm) {
  const Eigen::Matrix4d matrix = pose(0.3, {1.5, 0.2, 4});
  const auto write = [&](const std::string& lens) {
    put(folder_ / "t.json", "{" + lens + R"(, "frames": [{"transform_matrix": )" + rows(matrix) + "}]}");
  };
  const double focal = 320.0 / std::tan(0.5 * 0.9), focal_y = 240.0 / std::tan(0.5 * 0.8);
  for (const auto& [lens, wanted] :
       {std::pair<const char*, Focal>{R"("camera_angle_x": 0.9)", {focal, focal, 320, 240}},
        {R"("camera_angle_x": 0.9, "w": 320, "h": 240)", {focal, focal, 320, 240}},
        {R"("camera_angle_x": 0.9, "camera_angle_y": 0.8, "w": 320, "h": 240)", {focal, focal_y, 320, 240}},
        {R"("camera_angle_x": 0.9, "w": 320, "h": 240, "cx": 150)", {focal, focal, 300, 240}},
        {R"("camera_angle_y": 0.8)", {focal_y, focal_y, 320, 240}},
        {R"("fl_x": 100, "h": 240)", {200, 200, 320, 240}}}) {
    write(lens);
    const SceneFile file = read("t.json");
    for (const Vector3d& p : points)
      EXPECT_LT((seen(file.scene(), 1, p) - expected(matrix, wanted, p)).norm(), 1e-9) << lens;
  }
  for (const auto& [lens, message] :
       {std::pair{R"("fl_x": 100, "cx": 50)", "/cx: comes without w"},
        {R"("fl_x": 100)", "/frames/0: no field of view"},
        {R"("camera_angle_x": 3.2)", "/camera_angle_x: must be below pi"},
        {R"("fl_x": 1e9, "fl_y": 1, "w": 640, "h": 480)", "/frames/0: one focal length"},
        {R"("fl_x": 9, "cy": 1e9, "w": 640, "h": 480)", "/frames/0: the principal point"},
        {R"("camera_angle_x": 1, "camera_model": "EQUIRECTANGULAR")", "/camera_model: only perspective"}}) {
    write(lens);
    expect_refused("t.json", message);
  }
}

TEST_F(CameraFiles, NerfstudiosPathsHaveAVerticalFieldOfView) {
  const Eigen::Matrix4d matrix = pose(0.1, {0.5, 0.2, 5});
  std::string numbers;
  for (int i = 0; i < 16; ++i) {
    if (i > 0) numbers += ',';
    numbers += shortest_text(matrix(i / 4, i % 4));
  }
  put(folder_ / "path.json",
      R"({"camera_type": "perspective", "render_height": 1080, "render_width": 1920, "fps": 24,
    "seconds": 4, "camera_path": [{"camera_to_world": [)" +
          numbers + R"(], "fov": 50, "aspect": 1.7}]})");
  const SceneFile file = read("path.json");
  const double focal = 240.0 / std::tan(25.0 * std::numbers::pi / 180.0);
  for (const Vector3d& p : points)
    EXPECT_LT((seen(file.scene(), 1, p) - expected(matrix, {focal, focal, 320, 240}, p)).norm(), 1e-9);
  put(folder_ / "path.json", R"({"camera_path": [{"camera_to_world": [1, 2], "fov": 50}]})");
  expect_refused("path.json", "/camera_path/0/camera_to_world");
  put(folder_ / "path.json", R"({"camera_path": [{"fov": 50}]})");
  expect_refused("path.json", "\"camera_to_world\" is missing");
}

/// Three images of two cameras, out of order, with and without points.
constexpr const char* colmap_cameras =
    "# Camera list with one line of data per camera:\n"
    "1 PINHOLE 640 480 700 650 300 261.5\r\n"
    "\n7 SIMPLE_RADIAL 320 240 350 160 120 0.01\n";
constexpr const char* colmap_images =
    "# Image list with two lines of data per image:\n"
    "12 0.9 0.1 -0.2 0.05 0.3 -0.1 5 7 shot 10.png\n"
    "10 20 -1 30 40 17\n"
    "3 1 0 0 0 0 0 4 1 shot 2.png\n"
    "\n"
    "4 0 0 1 0 0.5 0 6 1 shot 1.png\n";

TEST_F(CameraFiles, ColmapIsWorldToCamera) {
  put(folder_ / "cameras.txt", colmap_cameras);
  put(folder_ / "images.txt", colmap_images);
  struct Shot {
    Eigen::Quaterniond q;
    Vector3d t;
    Focal focal;
  };
  const Shot shots[] = {{{0, 0, 1, 0}, {0.5, 0, 6}, {700, 650, 300, 261.5}},
                        {{1, 0, 0, 0}, {0, 0, 4}, {700, 650, 300, 261.5}},
                        {{0.9, 0.1, -0.2, 0.05}, {0.3, -0.1, 5}, {700, 700, 320, 240}}};
  for (const char* name : {"images.txt", "cameras.txt", ""}) {
    const SceneFile file = read(name);
    ASSERT_EQ(file.scene().camera.poses.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i)
      for (const Vector3d& point : points) {
        const Shot& shot = shots[i];
        const Vector3d p = shot.q.normalized() * point + shot.t;
        const Vector2d pixel(shot.focal.cx + shot.focal.x * p.x() / p.z(),
                             shot.focal.cy + shot.focal.y * p.y() / p.z());
        EXPECT_LT((seen(file.scene(), static_cast<double>(i) + 1.0, point) - pixel).norm(), 1e-9) << i;
      }
    ASSERT_EQ(file.notes().size(), 2u);
    EXPECT_NE(file.notes()[0].find("3 images, in the order of their names"), std::string::npos);
    EXPECT_NE(file.notes()[1].find("distortion of a SIMPLE_RADIAL lens"), std::string::npos);
  }
}

TEST_F(CameraFiles, ColmapsFaultsAreNamedByLine) {
  const auto expect_fault = [&](const std::string& cameras, const std::string& images,
                                const std::string& message) {
    put(folder_ / "cameras.txt", cameras);
    put(folder_ / "images.txt", images);
    expect_refused("images.txt", message);
  };
  const std::string camera = "1 PINHOLE 640 480 700 650 300 261.5\n", image = "3 1 0 0 0 0 0 4 1 a.png\n\n";
  expect_fault("1 OPENCV_FISHEYE 640 480 1 1 1 1 0 0 0 0\n", image, "line 1: the camera is a OPENCV_FISHEYE");
  expect_fault("\n1 FOV 640 480 1 1 1 1 0\n", image, "line 2: the camera is a FOV");
  expect_fault("1 NONE 640 480 1 1 1 1\n", image, "there is no model \"NONE\"");
  expect_fault("1 PINHOLE 640 480 700 650 300\n", image, "4 parameters, found 5 numbers");
  expect_fault("1 PINHOLE 640 480 700 nan 300 1\n", image, "line 1: ");
  expect_fault("1 PINHOLE 640 0 700 650 300 1\n", image, "whole numbers");
  expect_fault("1 PINHOLE 640 480 0 650 300 1\n", image, "focal lengths must be above 0");
  expect_fault("1 PINHOLE 640 480 1e9 650 300 1\n", image, "line 1: one focal length");
  expect_fault(camera + camera, image, "line 2: there is a camera 1 already");
  expect_fault(camera, "", "has no images");
  expect_fault(camera, "3 1 0 0 0 0 0 4 2 a.png\n\n", "line 1: the image's camera, \"2\", is not in");
  expect_fault(camera, "3 0 0 0 0 0 0 4 1 a.png\n\n", "line 1: the quaternion");
  expect_fault(camera, "3 1 0 0 0 0 0\n\n", "line 1: expected ID QW");
  expect_fault(camera, "3 1 0 0 0 0 x 4 1 a.png\n\n", "line 1: ");
  // Images one below the other, without the lines of points between.
  expect_fault(camera, "3 1 0 0 0 0 0 4 1 a.png\n4 1 0 0 0 0 0 4 1 b.png\n", "line 2: expected the points");
  std::filesystem::remove(folder_ / "cameras.txt");
  expect_refused("images.txt", "has no cameras.txt and images.txt");
  put(folder_ / "images.bin", "");
  expect_refused("", "in binary; colmap model_converter");
  expect_refused("none.txt", "cannot be opened");
}

using swept_test::raw;

/// A .glb of a camera node below another one, with accessors of floats one after the other.
struct GltfCamera {
  std::string nodes, animation;
  std::vector<std::pair<const char*, std::vector<float>>> accessors;  ///< type and numbers

  [[nodiscard]] std::string bytes(
      const std::string& camera = R"("type":"perspective","perspective":{"yfov":0.8})") const {
    std::string buffer, views, list;
    for (const auto& [type, numbers] : accessors) {
      const std::size_t width = std::string(type) == "SCALAR" ? 1 : std::string(type) == "VEC3" ? 3 : 4;
      const std::string comma = views.empty() ? "" : ",";
      views += comma + "{\"buffer\":0,\"byteOffset\":" + std::to_string(buffer.size()) +
               ",\"byteLength\":" + std::to_string(4 * numbers.size()) + "}";
      list += comma + "{\"bufferView\":" + std::to_string(index_of(numbers)) +
              ",\"componentType\":5126,\"type\":\"" + type +
              "\",\"count\":" + std::to_string(numbers.size() / width) + "}";
      for (const float number : numbers) buffer += raw(number);
    }
    std::string text = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"cameras":[{)" +
                       camera + "}],\"nodes\":[" + nodes + "]";
    if (!accessors.empty())
      text += ",\"animations\":[" + animation + "],\"accessors\":[" + list + "],\"bufferViews\":[" + views +
              "],\"buffers\":[{\"byteLength\":" + std::to_string(buffer.size()) + "}]";
    return swept_test::glb(text + "}", buffer);
  }

 private:
  [[nodiscard]] std::size_t index_of(const std::vector<float>& numbers) const {
    std::size_t index = 0;
    while (&accessors[index].second != &numbers) ++index;
    return index;
  }
};

TEST_F(CameraFiles, GltfCamerasStandWhereTheirNodesAre) {
  // The parent turns by 90 degrees about y and doubles: (0, 1, 3) before it is (6, 2, 0) + (0.5, 0, 0).
  GltfCamera gltf;
  gltf.nodes = R"({"children":[1],"rotation":[0,0.70710678118654757,0,0.70710678118654757],"scale":[2,2,2],
                   "translation":[0.5,0,0]},{"camera":0,"translation":[0,1,3]})";
  put(folder_ / "a.glb", gltf.bytes());
  const SceneFile file = read("a.glb");
  Eigen::Matrix4d truth = pose(std::numbers::pi / 2.0, {6.5, 2, 0});
  const double focal = 240.0 / std::tan(0.4);
  for (const Vector3d& p : points)
    EXPECT_LT((seen(file.scene(), 1, p) - expected(truth, {focal, focal, 320, 240}, p)).norm(), 1e-9);
  EXPECT_EQ(file.scene().camera.poses.size(), 1u);
  put(folder_ / "a.glb", gltf.bytes(R"("type":"panoramic","panoramic":{"yfov":1})"));
  expect_refused("a.glb", "/cameras/0/type");
  put(folder_ / "a.glb", gltf.bytes(R"("type":"orthographic","orthographic":{"xmag":1})"));
  expect_refused("a.glb", "/cameras/0/orthographic");
  put(folder_ / "a.glb", gltf.bytes(R"("type":"orthographic","orthographic":{"xmag":1,"ymag":0})"));
  expect_refused("a.glb", "/cameras/0/orthographic/ymag");
  put(folder_ / "a.glb", gltf.bytes(R"("type":"perspective","perspective":{"yfov":4})"));
  expect_refused("a.glb", "yfov: must be below pi");
  gltf.nodes = "{}";
  put(folder_ / "a.glb", gltf.bytes());
  expect_refused("a.glb", "there is no camera in its scene");
  put(folder_ / "a.glb", "glTF");
  expect_refused("a.glb", "");
}

TEST_F(CameraFiles, GltfCamerasMayBeOrthographic) {
  GltfCamera gltf;
  gltf.nodes = R"({"camera":0,"translation":[1,2,3]})";
  put(folder_ / "a.glb", gltf.bytes(R"("type":"orthographic","orthographic":{"xmag":3,"ymag":1.5})"));
  const SceneFile file = read("a.glb");
  const CameraTrack& camera = file.scene().camera;
  EXPECT_TRUE(camera.orthographic);
  // On 480 px of height there are 3 world units, x to the right and y up, at any depth.
  const Projection film = projection_of(file.scene().film, camera.at(1.0));
  EXPECT_TRUE(film.orthographic);
  for (const double depth : {1.0, 50.0}) {
    const Vector3d p =
        camera.at(1.0).camera_from_world.linear() * (Vector3d(1.5, 2.25, 3.0 - depth) - camera.at(1.0).eye);
    EXPECT_NEAR(film.center_x + film.focal_px * p.x() / film.divisor(p.z()), 320.0 + 160.0 * 0.5, 1e-9);
    EXPECT_NEAR(film.center_y + film.focal_px * p.y() / film.divisor(p.z()), 240.0 - 160.0 * 0.25, 1e-9);
    EXPECT_NEAR(p.z(), depth, 1e-12);
  }
}

TEST_F(CameraFiles, GltfAnimationsAreFollowed) {
  GltfCamera gltf;
  gltf.nodes = R"({"children":[1]},{"camera":0,"translation":[0,0,5]})";
  const auto animated = [&](const char* curve, const char* path, std::size_t node, const char* type,
                            const std::vector<float>& times, const std::vector<float>& values) {
    gltf.accessors = {{"SCALAR", times}, {type, values}};
    gltf.animation = std::string(R"({"samplers":[{"input":0,"output":1,"interpolation":")") + curve +
                     R"("}],"channels":[{"sampler":0,"target":{"node":)" + std::to_string(node) +
                     R"(,"path":")" + path + R"("}}]})";
    put(folder_ / "a.glb", gltf.bytes());
    return read("a.glb");
  };
  const auto eye = [](const SceneFile& file, double seconds) {
    return file.scene().camera.at(1.0 + 24.0 * seconds).eye;
  };
  const SceneFile linear = animated("LINEAR", "translation", 1, "VEC3", {0.5f, 1.5f}, {0, 0, 5, 4, 0, 7});
  EXPECT_LT((eye(linear, 0.0) - Vector3d(0, 0, 5)).norm(), 1e-12);
  EXPECT_LT((eye(linear, 0.75) - Vector3d(1, 0, 5.5)).norm(), 1e-12);
  EXPECT_LT((eye(linear, 9.0) - Vector3d(4, 0, 7)).norm(), 1e-12);
  EXPECT_EQ(linear.scene().camera.poses.size(), 2u);

  const SceneFile step = animated("STEP", "translation", 1, "VEC3", {0, 1}, {0, 0, 5, 4, 0, 7});
  EXPECT_LT((eye(step, 0.99) - Vector3d(0, 0, 5)).norm(), 1e-12);
  EXPECT_LT((eye(step, 1.0) - Vector3d(4, 0, 7)).norm(), 1e-12);

  // 1 at rest becomes 3 with the slope 2 at its end: by Hermite's formula 1.75 half-way.
  const SceneFile cubic = animated("CUBICSPLINE", "translation", 1, "VEC3", {0, 1},
                                   {0, 0, 0, 1, 0, 5, 0, 0, 0, 2, 0, 0, 3, 0, 5, 0, 0, 0});
  EXPECT_LT((eye(cubic, 0.5) - Vector3d(1.75, 0, 5)).norm(), 1e-12);
  EXPECT_GT(cubic.scene().camera.poses.size(), 100u);

  // A parent that turns carries the camera around on an arc, not on its chord.
  const auto h = static_cast<float>(std::sqrt(0.5));
  const SceneFile around = animated("LINEAR", "rotation", 0, "VEC4", {0, 1}, {0, 0, 0, 1, 0, h, 0, h});
  const Vector3d half = eye(around, 0.5);
  EXPECT_NEAR(half.norm(), 5.0, 1e-6);
  EXPECT_NEAR(half.x(), 5.0 * std::sqrt(0.5), 1e-5);
  const Vector2d middle = seen(around.scene(), 1.0 + 12.0, Vector3d(0, 0, 0));
  EXPECT_LT((middle - Vector2d(320, 240)).norm(), 1e-3);

  // Frames are those of the scene's rate.
  SceneOverrides overrides;
  overrides.camera_file = folder_ / "a.glb";
  overrides.fields["/fps"] = {48, 1};
  const auto faster = scene_from_text(plain_scene, "scene.json", overrides);
  ASSERT_TRUE(faster.ok());
  EXPECT_LT((faster->scene().camera.at(1.0 + 24.0).eye - half).norm(), 1e-12);

  gltf.accessors[1].second.pop_back();
  gltf.accessors[1].second.resize(4);
  put(folder_ / "a.glb", gltf.bytes());
  expect_refused("a.glb", "times and values do not fit");
  gltf.accessors = {{"SCALAR", {1, 1}}, {"VEC4", {0, 0, 0, 1, 0, 0, 0, 1}}};
  put(folder_ / "a.glb", gltf.bytes());
  expect_refused("a.glb", "times must increase");
}

/// Splats of glTF are read into the axes that splats are trained in, and the camera has to follow.
TEST_F(CameraFiles, GltfCamerasGoWithTheSplatsOfGltf) {
  GltfCamera gltf;
  gltf.nodes = R"({"camera":0,"translation":[1,2,5]})";
  put(folder_ / "a.glb", gltf.bytes());
  std::string text = plain_scene;
  text.replace(text.find("\"objects\": []"), 13, R"("objects": [{"source": {"file": "b.glb"}}])");
  SceneOverrides overrides;
  overrides.camera_file = folder_ / "a.glb";
  const auto file = scene_from_text(text, "scene.json", overrides);
  ASSERT_TRUE(file.ok()) << file.error().message();
  EXPECT_EQ(file->scene().camera.at(1.0).eye, Vector3d(-1, -2, 5));
  // What is left of the camera in glTF is left of it there too.
  const Vector2d left = seen(file->scene(), 1.0, Vector3d(-1 + 0.5, -2, 0));
  EXPECT_LT(left.x(), 320.0);
}

}  // namespace
}  // namespace swept
