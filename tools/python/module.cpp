// The module swept._swept: what the package's Python is built on.
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <swept/version.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "splat/io/cloud_scene.h"
#include "splat/io/image_file.h"
#include "splat/io/splat_file.h"
#include "tools/python/numpy_arrays.h"
#include "tools/python/python_scene.h"
#include "tools/python/raise.h"
#include "tools/python/render_call.h"
#ifdef SWEPT_HAS_GPU
#include "gpu_passes/gpu_renderer.h"
#endif

namespace py = pybind11;

namespace swept::python {
namespace {

template <class T>
T option(const py::dict& options, const char* name, T otherwise) {
  if (!options.contains(name) || options[name].is_none()) return otherwise;
  try {
    return py::cast<T>(options[name]);
  } catch (const py::cast_error&) {
    const char* const kind = std::is_same_v<T, bool>  ? "true or false"
                             : std::is_same_v<T, int> ? "a whole number below 2^31"
                                                      : "a number";
    throw py::value_error(std::string(name) + " must be " + kind);
  }
}

Result<Rendered> render_gpu(const Scene& scene, int subframes, const RenderControl& control) {
#ifdef SWEPT_HAS_GPU
  Result<GpuRenderer> renderer = GpuRenderer::create();
  if (!renderer) return renderer.error();
  return renderer->render(scene, {.subframes = subframes}, control);
#else
  static_cast<void>(scene);
  static_cast<void>(subframes);
  static_cast<void>(control);
  return Error{"", "method", "this swept was built without the GPU mode", ErrorKind::unsupported};
#endif
}

std::function<Result<Rendered>(const RenderControl&)> method_of(const Scene& scene, const std::string& method,
                                                                const py::dict& options) {
  if (method == "sampled") {
    SampledOptions sampled;
    sampled.samples = option(options, "samples", 0);
    sampled.max_error_db = option(options, "max_error_db", sampled.max_error_db);
    sampled.max_cell_error_db = option(options, "max_cell_error_db", 0.0);
    sampled.max_seconds = option(options, "max_seconds", 0.0);
    sampled.error_channel = option(options, "error_channel", false);
    return
        [&scene, sampled](const RenderControl& control) { return render_sampled(scene, sampled, control); };
  }
  if (method == "exact")
    return [&scene](const RenderControl& control) { return render_abuffer(scene, {}, control); };
  if (method == "reference") {
    ReferenceOptions reference;
    reference.samples = option(options, "samples", reference.samples);
    reference.motion = ReferenceMotion::smooth;
    return [&scene, reference](const RenderControl& control) {
      return render_reference(scene, reference, control);
    };
  }
  if (method == "gpu") {
    const int subframes = option(options, "samples", 0);
    return
        [&scene, subframes](const RenderControl& control) { return render_gpu(scene, subframes, control); };
  }
  throw py::value_error("method must be 'sampled', 'exact', 'reference' or 'gpu', not '" + method + "'");
}

py::dict image_dict(Image image) {
  const py::ssize_t height = image.height, width = image.width;
  py::dict result, channels;
  result["x"] = image.x;
  result["y"] = image.y;
  result["film_width"] = image.film_width;
  result["film_height"] = image.film_height;
  result["rgba"] = array_from(std::move(image.rgba), {height, width, 4});
  result["depth"] = image.depth.empty() ? py::object(py::none())
                                        : py::object(array_from(std::move(image.depth), {height, width}));
  for (ImageChannel& channel : image.channels)
    channels[py::str(channel.name)] = array_from(std::move(channel.values), {height, width});
  result["channels"] = channels;
  return result;
}

py::dict render(PythonScene& scene, std::optional<double> frame, const std::string& method,
                const py::dict& options, int threads, std::size_t max_bytes, const py::object& progress,
                const py::object& log) {
  const Scene& drawn = scene.at(frame);
  RenderControl control;
  control.threads = threads;
  control.max_bytes = max_bytes;
  Rendered rendered = render_call(method_of(drawn, method, options), control, progress, log);
  py::dict result = image_dict(std::move(rendered.image)), counters, seconds;
  for (const auto& [name, value] : rendered.statistics.counters) counters[py::str(name)] = value;
  for (const auto& [name, value] : rendered.statistics.seconds) seconds[py::str(name)] = value;
  result["counters"] = counters;
  result["seconds"] = seconds;
  result["effects"] = rendered.statistics.effects;
  return result;
}

Image image_of(const py::array_t<float, py::array::c_style | py::array::forcecast>& rgba,
               const py::object& depth) {
  if (rgba.ndim() != 3 || rgba.shape(2) != 4)
    throw py::value_error("an image must have the shape (height, width, 4)");
  Image image;
  image.height = image.film_height = static_cast<int>(rgba.shape(0));
  image.width = image.film_width = static_cast<int>(rgba.shape(1));
  image.rgba.assign(rgba.data(), rgba.data() + rgba.size());
  if (!depth.is_none()) {
    Keep keep;
    const Strided<float> values = packed_numbers_of(depth, "depth", keep);
    image.depth.assign(values.data, values.data + values.count);
  }
  return image;
}

PythonScene load(const std::string& path, const std::map<std::string, std::vector<double>>& fields,
                 const std::string& draw, const std::string& camera, double points_scale) {
  SceneOverrides overrides;
  overrides.fields.insert(fields.begin(), fields.end());
  overrides.camera_file = camera;
  overrides.points_scale = points_scale;
  if (draw == "splats") overrides.draw = DrawAs::splats;
  if (draw == "surfels") overrides.draw = DrawAs::surfels;
  if (!draw.empty() && !overrides.draw) throw py::value_error("draw must be 'splats' or 'surfels'");
  return PythonScene(checked(read_scene_or_points(path, overrides)));
}

template <class Rows>
py::array rows_array(const Rows& rows, std::size_t width) {
  std::vector<float> numbers;
  numbers.reserve(rows.size() * width);
  for (const auto& row : rows)
    for (std::size_t i = 0; i < width; ++i)
      numbers.push_back(static_cast<float>(row[static_cast<Eigen::Index>(i)]));
  return array_from(std::move(numbers),
                    {static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(width)});
}

py::dict read_splat_arrays(const std::string& path) {
  const LoadedSplats loaded = checked(read_splats(path));
  const SplatCloud& splats = loaded.splats;
  const auto count = static_cast<py::ssize_t>(splats.size());
  py::array_t<double> positions({count, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis)
      positions.mutable_at(i, axis) = splats.position[static_cast<std::size_t>(i)][axis];
  std::vector<float> rotations;
  for (const Eigen::Quaternionf& q : splats.rotation)
    rotations.insert(rotations.end(), {q.w(), q.x(), q.y(), q.z()});
  const py::ssize_t coefficients = SplatCloud::coefficients(splats.degree);
  py::dict result;
  result["positions"] = positions;
  result["scales"] = rows_array(splats.scale, 3);
  result["rotations"] = array_from(std::move(rotations), {count, 4});
  result["opacities"] = array_from(std::vector<float>(splats.opacity.begin(), splats.opacity.end()), {count});
  result["harmonics"] = array_from(std::vector<float>(splats.harmonics.begin(), splats.harmonics.end()),
                                   {count, coefficients, 3});
  result["degree"] = splats.degree;
  result["antialiased"] = splats.filter == SplatFilter::antialiased;
  result["linear"] = splats.colors == SplatColors::linear;
  if (!splats.velocity.empty()) result["velocities"] = rows_array(splats.velocity, 3);
  return result;
}

}  // namespace
}  // namespace swept::python

PYBIND11_MODULE(_swept, m) {
  using namespace swept::python;
  m.doc() = "What the package swept is built on; use that.";
  m.attr("__version__") = swept::version();
  py::class_<PythonScene>(m, "Scene")
      .def(py::init<>())
      .def("set_field", &PythonScene::set_field)
      .def("field", &PythonScene::field)
      .def("add_points", &PythonScene::add_points)
      .def("add_splats", &PythonScene::add_splats)
      .def("look_at", &PythonScene::look_at)
      .def("look_along", &PythonScene::look_along)
      .def("frame_points", &PythonScene::frame_points)
      .def("notes", &PythonScene::notes)
      .def("hash", &PythonScene::hash)
      .def("frame", [](const PythonScene& scene) { return scene.now().frame; })
      .def("views", &PythonScene::views)
      .def("points", &PythonScene::points);
  m.def("load", &load);
  m.def("render", &render);
  m.def("read_splats", &read_splat_arrays);
  m.def("read_exr", [](const std::string& path) { return image_dict(checked(swept::read_exr(path))); });
  m.def("write_exr",
        [](const std::string& path, const py::array_t<float, py::array::c_style | py::array::forcecast>& rgba,
           const py::object& depth) { check(swept::write_exr(path, image_of(rgba, depth))); });
  m.def("write_png", [](const std::string& path,
                        const py::array_t<float, py::array::c_style | py::array::forcecast>& rgba) {
    check(swept::write_png(path, image_of(rgba, py::none())));
  });
}
