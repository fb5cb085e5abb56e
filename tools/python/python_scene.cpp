#include "tools/python/python_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>

#include "datasets/generators.h"
#include "splat/arrays.h"
#include "splat/fields.h"
#include "splat/io/frame_points.h"
#include "splat/io/surfel_estimate.h"
#include "tools/python/raise.h"

namespace swept::python {

namespace py = pybind11;

namespace {

py::object given(const py::dict& arrays, const char* name) {
  return arrays.contains(name) ? py::object(arrays[name]) : py::object(py::none());
}

Eigen::Vector3d vector_of(const std::vector<double>& numbers, const char* name) {
  if (numbers.size() != 3) throw py::value_error(std::string(name) + " must be three numbers");
  return {numbers[0], numbers[1], numbers[2]};
}

double tan_half(double degrees) { return std::tan(degrees * std::numbers::pi / 360.0); }

/// Positions and velocities, which discs and splats have alike.
template <class Arrays>
void take_motion(const py::dict& from, Arrays& arrays, Keep& keep) {
  const py::object positions = given(from, "positions");
  if (is_double_array(positions) || !py::isinstance<py::array_t<float>>(positions))
    arrays.position = rows_of<Eigen::Vector3d, double>(positions, "positions", keep);
  else
    arrays.position_single = rows_of<Eigen::Vector3f, float>(positions, "positions", keep);
  const Strided<Eigen::Vector3f> velocities =
      rows_of<Eigen::Vector3f, float>(given(from, "velocities"), "velocities", keep);
  if (py::cast<std::string>(from["velocity_unit"]) == "per_second")
    arrays.velocity_per_second = velocities;
  else
    arrays.velocity_per_frame = velocities;
  arrays.frames_per_second = py::cast<double>(from["fps"]);
  arrays.frame = py::cast<double>(from["frame"]);
}

/// Looks, a list of dictionaries of frame, colors and opacities.
std::vector<LookArrays> looks_of(const py::object& looks, Keep& keep) {
  std::vector<LookArrays> all;
  if (looks.is_none()) return all;
  for (const py::handle& look : looks) {
    const auto members = py::cast<py::dict>(look);
    const std::string name = "looks[" + std::to_string(all.size()) + "].";
    LookArrays& arrays = all.emplace_back();
    arrays.frame = py::cast<double>(members["frame"]);
    arrays.color = rows_of<Eigen::Vector3f, float>(given(members, "colors"), name + "colors", keep);
    arrays.opacity = numbers_of(given(members, "opacities"), name + "opacities", keep);
  }
  return all;
}

/// Axes of discs of which normals, radii or both are estimated from the nearest points. Which of them are
/// known to face outside.
std::vector<std::uint8_t> estimate_axes(SurfelArrays& arrays, Keep& keep) {
  PointSet points;
  const std::size_t count = std::max(arrays.position.count, arrays.position_single.count);
  for (std::size_t i = 0; i < count; ++i)
    points.position.push_back(arrays.position.empty() ? arrays.position_single[i].cast<double>().eval()
                                                      : arrays.position[i]);
  for (std::size_t i = 0; i < arrays.normal.count; ++i) points.normal.push_back(arrays.normal[i]);
  for (std::size_t i = 0; i < arrays.radius.count; ++i) points.radius.push_back(arrays.radius[i]);
  if (points.radius.size() == 1) points.radius.resize(count, points.radius.front());
  EstimatedSurfels discs = checked(surfels_from_cloud(points));
  const auto keep_axis = [&keep, count](PointArray<Eigen::Vector3f>& axis) {
    std::vector<float> numbers(3 * count);
    std::copy(axis.data()->data(), axis.data()->data() + 3 * count, numbers.begin());
    const py::array array = array_from(std::move(numbers), {static_cast<py::ssize_t>(count), 3});
    keep.push_back(array);
    return Strided<Eigen::Vector3f>(reinterpret_cast<const Eigen::Vector3f*>(array.data()), count);
  };
  arrays.axis_u = keep_axis(discs.pose.axis_u);
  arrays.axis_v = keep_axis(discs.pose.axis_v);
  arrays.normal = {};
  arrays.radius = {};
  std::vector<std::uint8_t> oriented(count, discs.oriented ? 1 : 0);
  for (const std::size_t i : discs.unoriented) oriented[i] = 0;
  return oriented;
}

Result<SurfelCloud> generate_cloud(const std::string& shape, std::size_t points,
                                   const std::map<std::string, double>& parameters) {
  return generate(shape, points, parameters);
}

}  // namespace

const Scene& PythonScene::at(std::optional<double> frame) {
  if (file_) return *checked(file_->scene_at(frame.value_or(file_->scene().frame), generate_cloud));
  if (frame) scene_.frame = *frame;
  return scene_;
}

Scene& PythonScene::own() {
  if (file_) throw py::value_error("a scene that was loaded cannot be changed; give load() its fields");
  return scene_;
}

std::vector<std::string> PythonScene::notes() const {
  return file_ ? file_->notes() : std::vector<std::string>();
}

std::string PythonScene::hash(double frame) const {
  return file_ ? checked(file_->hash(frame)) : std::string();
}

void PythonScene::set_field(const std::string& pointer, const std::vector<double>& values) {
  const Field* field = find_field(pointer);
  if (field == nullptr) throw py::key_error("there is no field " + pointer);
  check(field->legal(values));
  field->set(own(), values);
}

std::vector<double> PythonScene::field(const std::string& pointer) const {
  const Field* field = find_field(pointer);
  if (field == nullptr) throw py::key_error("there is no field " + pointer);
  return field->get(now());
}

void PythonScene::add_points(const py::dict& from) {
  Scene& scene = own();
  Keep keep;
  SurfelArrays arrays;
  take_motion(from, arrays, keep);
  arrays.axis_u = rows_of<Eigen::Vector3f, float>(given(from, "axes_u"), "axes_u", keep);
  arrays.axis_v = rows_of<Eigen::Vector3f, float>(given(from, "axes_v"), "axes_v", keep);
  arrays.normal = rows_of<Eigen::Vector3f, float>(given(from, "normals"), "normals", keep);
  arrays.radius = numbers_of(given(from, "radii"), "radii", keep);
  arrays.color = rows_of<Eigen::Vector3f, float>(given(from, "colors"), "colors", keep);
  arrays.opacity = numbers_of(given(from, "opacities"), "opacities", keep);
  arrays.looks = looks_of(given(from, "looks"), keep);
  const bool axes = !arrays.axis_u.empty() || !arrays.axis_v.empty();
  std::vector<std::uint8_t> oriented;
  if (!axes && (arrays.normal.empty() || arrays.radius.empty())) oriented = estimate_axes(arrays, keep);
  const py::object facing = from["oriented"];
  arrays.oriented = facing.is_none() ? !arrays.normal.empty() : py::cast<bool>(facing);
  Object object;
  object.name = py::cast<std::string>(from["name"]);
  object.two_sided = py::cast<bool>(from["two_sided"]);
  object.cloud = checked(cloud_from_arrays(arrays));
  if (!oriented.empty() && facing.is_none()) object.cloud.oriented = std::move(oriented);
  scene.objects.push_back(std::move(object));
  keep_.insert(keep_.end(), keep.begin(), keep.end());
}

void PythonScene::add_splats(const py::dict& from) {
  Scene& scene = own();
  Keep keep;
  SplatArrays arrays;
  take_motion(from, arrays, keep);
  arrays.scale = rows_of<Eigen::Vector3f, float>(given(from, "scales"), "scales", keep);
  arrays.rotation_wxyz = rows_of<Eigen::Vector4f, float>(given(from, "rotations"), "rotations", keep);
  arrays.opacity = numbers_of(given(from, "opacities"), "opacities", keep);
  arrays.harmonics = packed_numbers_of(given(from, "harmonics"), "harmonics", keep);
  arrays.degree = py::cast<int>(from["degree"]);
  arrays.filter = py::cast<bool>(from["antialiased"]) ? SplatFilter::antialiased : SplatFilter::dilated;
  arrays.colors = py::cast<bool>(from["linear"]) ? SplatColors::linear : SplatColors::srgb;
  Object object;
  object.name = py::cast<std::string>(from["name"]);
  object.splats = checked(splats_from_arrays(arrays));
  scene.objects.push_back(std::move(object));
  keep_.insert(keep_.end(), keep.begin(), keep.end());
}

void PythonScene::look_at(const std::vector<double>& eye, const std::vector<double>& target,
                          const std::vector<double>& up, double fov_y_degrees, double height) {
  LookAtKey key;
  key.frame = own().frame;
  key.eye = vector_of(eye, "eye");
  key.target = vector_of(target, "target");
  key.up = vector_of(up, "up");
  key.tan_half_fov_y = height != 0.0 ? 0.5 * height : tan_half(fov_y_degrees);
  const double near = scene_.camera.near;
  scene_.camera = CameraTrack{{}, {key}, near, height != 0.0};
  check(scene_.camera.validate());
}

void PythonScene::look_along(const py::array_t<double>& camera_to_world, double fov_y_degrees, double height,
                             bool opencv) {
  if (camera_to_world.ndim() != 2 || camera_to_world.shape(0) != 4 || camera_to_world.shape(1) != 4)
    throw py::value_error("camera_to_world must have the shape (4, 4)");
  Eigen::Matrix3d axes;
  CameraKey key;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      axes(row, column) = camera_to_world.at(row, column) * (opencv || column == 0 ? 1.0 : -1.0);
    key.eye[row] = camera_to_world.at(row, 3);
  }
  if (!axes.allFinite() || (axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm() > 1e-5 ||
      axes.determinant() < 0.0)
    throw py::value_error("camera_to_world must be a rotation and a translation");
  key.world_from_camera = Eigen::Quaterniond(axes).normalized();
  key.frame = own().frame;
  key.tan_half_fov_y = height != 0.0 ? 0.5 * height : tan_half(fov_y_degrees);
  scene_.camera = CameraTrack{{key}, {}, scene_.camera.near, height != 0.0};
  check(scene_.camera.validate());
}

void PythonScene::frame_points(double fov_y_degrees) {
  std::vector<Eigen::Vector3d> points;
  for (const Object& object : own().objects) {
    if (object.cloud.size() > 0) {
      const PointArray<Eigen::Vector3d>& positions = object.cloud.keys.front().pose.position;
      points.insert(points.end(), positions.begin(), positions.end());
    }
    points.insert(points.end(), object.splats.position.begin(), object.splats.position.end());
  }
  if (points.empty()) throw py::value_error("there are no points to frame");
  const double tan_y = tan_half(fov_y_degrees);
  const io::Front front{Eigen::Vector3d::UnitY(), -Eigen::Vector3d::UnitZ(), 20.0, 0.0};
  const io::Framing framing =
      checked(io::frame_points(points, 0.0, front, tan_y * scene_.film.width / scene_.film.height, tan_y));
  look_at({framing.eye.x(), framing.eye.y(), framing.eye.z()},
          {framing.target.x(), framing.target.y(), framing.target.z()}, {0.0, 1.0, 0.0}, fov_y_degrees, 0.0);
}

std::size_t PythonScene::views() const {
  std::size_t count = 0;
  const auto look = [&count](const auto& column) { count += column.is_view() ? 1 : 0; };
  for (const Object& object : now().objects) {
    for (const SurfelKey& key : object.cloud.keys) {
      look(key.pose.position);
      look(key.pose.axis_u);
      look(key.pose.axis_v);
    }
    look(object.cloud.velocity);
    look(object.cloud.color);
    look(object.cloud.opacity);
    for (const LookKey& of_frame : object.cloud.looks) {
      look(of_frame.color);
      look(of_frame.opacity);
    }
    look(object.splats.position);
    look(object.splats.scale);
    look(object.splats.opacity);
    look(object.splats.harmonics);
    look(object.splats.velocity);
  }
  return count;
}

std::size_t PythonScene::points() const {
  std::size_t count = 0;
  for (const Object& object : now().objects) count += object.cloud.size() + object.splats.size();
  return count;
}

}  // namespace swept::python
