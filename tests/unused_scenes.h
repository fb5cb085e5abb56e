// The small scenes to which options and members are given that change nothing.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/io/image_file.h"
#include "tests/temporary_folder.h"

namespace swept::test {

inline nlohmann::json unused_scene(const nlohmann::json& objects) {
  nlohmann::json scene = nlohmann::json::parse(R"({
    "swept": 1, "film": {"width": 24, "height": 24}, "frame": 1,
    "camera": {"fov": {"axis": "vertical", "degrees": 40}, "keys": [{"eye": [0, 0, 5], "target": [0, 0, 0]}]}})");
  scene["objects"] = objects;
  return scene;
}

/// A transform that turns and moves.
inline nlohmann::json turning() {
  return nlohmann::json::parse(
      R"({"keys": [{"frame": 0, "rotate": {"axis": [0, 0, 1], "degrees": 0}},
                   {"frame": 2, "rotate": {"axis": [0, 0, 1], "degrees": 90}, "translate": [0.5, 0, 0]}]})");
}

inline const char* one_triangle = "v -1 -1 0 1 0 0\nv 1 -1 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n";

inline std::vector<float> pixels_of(const std::string& path) {
  const Result<Image> image = read_exr(path);
  EXPECT_TRUE(image.ok());
  return image ? image->rgba : std::vector<float>();
}

}  // namespace swept::test
