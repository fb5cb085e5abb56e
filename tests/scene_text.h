// A scene file to start from, and the folder to put variants of it in.
#pragma once

#include <map>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "splat/io/scene_file.h"
#include "tests/temporary_folder.h"

namespace swept::test {

inline constexpr const char* base_scene = R"({
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

/// What in base_scene says where the points come from.
inline constexpr const char* base_source = R"({"generator": "dots", "points": 3, "seed": 1})";

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "the base scene has no " << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// A camera with one matrix key and nothing to see.
inline std::string matrix_scene(const std::string& matrix, const std::string& convention = "") {
  return R"({"swept": 1, "objects": [], "camera": {"fov": {"axis": "vertical", "degrees": 40}, )" +
         convention + R"("keys": [{"matrix": )" + matrix + "}]}}";
}

/// Points on the x axis with axes of length 0.5 and velocities along z.
inline Result<SurfelCloud> dots(const std::string& shape, std::size_t points,
                                const std::map<std::string, double>&) {
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

/// A fresh folder for each test.
class SceneFiles : public ::testing::Test {
 protected:
  std::string write(const std::string& text, const std::string& name = "scene.json") const {
    test::put(folder_ / name, text);
    return folder_ / name;
  }

  TemporaryFolder folder_;
};

}  // namespace swept::test
