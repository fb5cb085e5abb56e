// The scenes of the traversals' tables.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/core.h>

#include "datasets/generators.h"
#include "splat/io/atomic_file.h"
#include "splat/io/scene_file.h"
#include "tools/random_numbers.h"
#include "tools/study/traversal.h"

namespace swept {

Scene square_stage(int side_px) {
  Scene scene;
  scene.film = {side_px, side_px, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats.emplace_back();
  return scene;
}

std::uint32_t add_point(Object& object, const Eigen::Vector3d& position, const Eigen::Vector3f& color) {
  if (object.cloud.keys.empty()) object.cloud.keys.resize(1);
  SurfelPose& pose = object.cloud.keys.front().pose;
  pose.position.push_back(position);
  pose.axis_u.emplace_back(0.01f, 0.0f, 0.0f);
  pose.axis_v.emplace_back(0.0f, 0.01f, 0.0f);
  object.cloud.color.push_back(color);
  return static_cast<std::uint32_t>(pose.size() - 1);
}

void turn(Object& object, double degrees, const Eigen::Vector3d& axis) {
  TransformKey open, close;
  close.frame = 1.0;
  open.rotate_axis = close.rotate_axis = axis.normalized();
  close.rotate_radians = degrees * M_PI / 180.0;
  object.transform.keys = {open, close};
}

namespace {

/// A ball of 6,144 triangles that turns by a third.
Scene rotation(int side_px) {
  Scene scene = square_stage(side_px);
  Object& object = scene.objects.emplace_back();
  constexpr std::uint32_t rows = 48, columns = 64;
  for (std::uint32_t i = 0; i <= rows; ++i)
    for (std::uint32_t j = 0; j < columns; ++j) {
      const double polar = M_PI * i / rows, around = 2.0 * M_PI * j / columns;
      const Eigen::Vector3d n(std::sin(polar) * std::cos(around), std::cos(polar),
                              std::sin(polar) * std::sin(around));
      add_point(object, 1.6 * n, (0.5 * (n + Eigen::Vector3d::Ones())).cast<float>());
    }
  for (std::uint32_t i = 0; i < rows; ++i)
    for (std::uint32_t j = 0; j < columns; ++j) {
      const std::uint32_t a = i * columns + j, b = i * columns + (j + 1) % columns, c = a + columns,
                          d = b + columns;
      object.triangles.push_back({a, b, c});
      object.triangles.push_back({b, d, c});
    }
  turn(object, 120.0, {0.3, 1.0, 0.5});
  return scene;
}

/// 20,000 triangles of about a pixel on curves of their own.
Scene small_triangles(int side_px) {
  Scene scene = square_stage(side_px);
  Object& object = scene.objects.emplace_back();
  Random random(7);
  for (int t = 0; t < 20000; ++t) {
    const Eigen::Vector3d middle = random.vector(-1.4, 1.4);
    const Eigen::Vector3f color = (0.5 * (random.vector(-1.0, 1.0) + Eigen::Vector3d::Ones())).cast<float>(),
                          velocity = random.vector(-0.4, 0.4).cast<float>(),
                          acceleration = random.vector(-0.8, 0.8).cast<float>();
    std::uint32_t first = 0;
    for (int i = 0; i < 3; ++i) {
      first = add_point(object, middle + random.vector(-0.02, 0.02), color);
      object.cloud.velocity.push_back(velocity);
      object.cloud.acceleration.push_back(acceleration);
    }
    object.triangles.push_back({first - 2, first - 1, first});
  }
  return scene;
}

/// 160 triangles as large as walls, that turn as they do for a camera that pans.
Scene large_triangles(int side_px) {
  Scene scene = square_stage(side_px);
  Object& object = scene.objects.emplace_back();
  Random random(9);
  for (int t = 0; t < 160; ++t) {
    const Eigen::Vector3d middle = random.vector(-2.5, 2.5);
    std::uint32_t first = 0;
    for (int i = 0; i < 3; ++i)
      first = add_point(object, middle + random.vector(-1.0, 1.0),
                        (0.5 * (random.vector(-1.0, 1.0) + Eigen::Vector3d::Ones())).cast<float>());
    object.triangles.push_back({first - 2, first - 1, first});
  }
  turn(object, 20.0, {0.0, 1.0, 0.0});
  return scene;
}

constexpr const char* cloth_json = R"({{
  "swept": 1, "frame": 92, "film": {{"width": 512, "height": 512}}, "shutter": {{"open": 0, "close": 1}},
  "camera": {{"fov": {{"axis": "vertical", "degrees": 40}}, "keys": [{{"eye": [6, 22, 34], "target": [0, 5, 0]}}]}},
  "objects": [{{"source": {{"file": {0}, "end_file": {1}}}, "draw": "triangles", "color": "normals"}}]
}}
)";
constexpr const char* horse_json = R"({{
  "swept": 1, "frame": 3, "film": {{"width": 512, "height": 512}}, "shutter": {{"open": 0, "close": 1}},
  "camera": {{"fov": {{"axis": "vertical", "degrees": 34}}, "keys": [{{"eye": [4, 1, 1.2], "target": [0, 0.7, -0.35]}}]}},
  "objects": [{{"source": {{"sequence": {0}, "first": 1, "last": 12, "cycle": true}}, "draw": "triangles", "color": "normals"}}]
}}
)";

std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

}  // namespace

TraversalScene traversal_scene(const std::string& title, const std::string& path, int longest_side_px) {
  TraversalScene out{title, "", {}};
  Result<SceneFile> file = read_scene_file(path);
  if (!file) {
    out.error = file.error().message();
    return out;
  }
  const Result<const Scene*> scene = file->scene_at(file->scene().frame, generate);
  if (!scene) {
    out.error = scene.error().message();
    return out;
  }
  out.scene = **scene;
  Film& film = out.scene.film;
  const double scale =
      std::min(1.0, static_cast<double>(longest_side_px) / std::max(film.width, film.height));
  film = {std::max(1, static_cast<int>(std::lround(film.width * scale))),
          std::max(1, static_cast<int>(std::lround(film.height * scale))),
          0,
          0,
          0,
          0};
  return out;
}

std::vector<TraversalScene> traversal_scenes(int side_px, const std::string& folder) {
  std::vector<TraversalScene> scenes;
  if (const char* data = std::getenv("SWEPT_DATA_DIR"); data != nullptr && *data != '\0') {
    const std::string at = data;
    const auto add = [&](const std::string& title, const std::string& paper, const std::string& path,
                         const std::string& json) {
      const Status written = write_file(path, json);
      scenes.push_back(written ? traversal_scene(title, path, side_px)
                               : TraversalScene{title, paper, {}, written.error().message()});
      scenes.back().paper = paper;
    };
    add("Cloth ball", "Cloth ball", folder + "/cloth_ball.json",
        fmt::format(cloth_json, quoted(at + "/clothball/cloth_ball92.ply"),
                    quoted(at + "/clothball/cloth_ball93.ply")));
    add("Horse", "", folder + "/horse.json", fmt::format(horse_json, quoted(at + "/horse/%04d.obj")));
  }
  scenes.push_back({"Rotation", "BigGuy", rotation(side_px)});
  scenes.push_back({"Small triangles", "Hairball", small_triangles(side_px)});
  scenes.push_back({"Large triangles", "Sponza", large_triangles(side_px)});
  return scenes;
}

}  // namespace swept
