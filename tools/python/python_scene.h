// A scene as Python holds it: one that was loaded from a file, or one made of arrays, which it keeps alive.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <pybind11/pybind11.h>

#include "splat/io/scene_file.h"
#include "splat/scene.h"
#include "tools/python/numpy_arrays.h"

namespace swept::python {

class PythonScene {
 public:
  PythonScene() { scene_.camera.look_ats.emplace_back(); }
  explicit PythonScene(SceneFile file) : file_(std::move(file)) {}

  /// The scene at `frame`, or at its own; loads what the frame needs.
  [[nodiscard]] const Scene& at(std::optional<double> frame);
  [[nodiscard]] Scene& own();  ///< raises where the scene is a file's
  [[nodiscard]] const Scene& now() const { return file_ ? file_->scene() : scene_; }
  [[nodiscard]] std::vector<std::string> notes() const;
  [[nodiscard]] std::string hash(double frame) const;

  void set_field(const std::string& pointer, const std::vector<double>& values);
  [[nodiscard]] std::vector<double> field(const std::string& pointer) const;
  void add_points(const pybind11::dict& arrays);
  void add_splats(const pybind11::dict& arrays);
  void look_at(const std::vector<double>& eye, const std::vector<double>& target,
               const std::vector<double>& up, double fov_y_degrees, double height);
  void look_along(const pybind11::array_t<double>& camera_to_world, double fov_y_degrees, double height,
                  bool opencv);
  /// From the front and a little above, so that all points are seen.
  void frame_points(double fov_y_degrees);
  /// How many of the arrays given are looked into where they are.
  [[nodiscard]] std::size_t views() const;
  [[nodiscard]] std::size_t points() const;

 private:
  std::optional<SceneFile> file_;
  Scene scene_;
  Keep keep_;
};

}  // namespace swept::python
