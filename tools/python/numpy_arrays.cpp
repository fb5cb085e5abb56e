#include "tools/python/numpy_arrays.h"

#include <cstddef>
#include <memory>
#include <utility>

namespace swept::python {

namespace py = pybind11;

bool is_double_array(const py::object& array) {
  return py::isinstance<py::array>(array) && py::cast<py::array>(array).dtype().is(py::dtype::of<double>());
}

template <class Row, class Number>
Strided<Row> rows_of(const py::object& array, const std::string& name, Keep& keep) {
  if (array.is_none()) return {};
  constexpr py::ssize_t width = sizeof(Row) / sizeof(Number);
  // forcecast: another type, or a list, becomes a copy; an array of this type stays itself.
  auto numbers = py::array_t<Number, py::array::forcecast>::ensure(array);
  if (!numbers) {
    PyErr_Clear();
    throw py::value_error(name + " must be an array of numbers");
  }
  if (numbers.ndim() != 2 || numbers.shape(1) != width)
    throw py::value_error(name + " must have the shape (n, " + std::to_string(width) + ")");
  const bool side_by_side = numbers.strides(1) == static_cast<py::ssize_t>(sizeof(Number));
  if (!side_by_side)
    numbers = py::array_t<Number, py::array::c_style | py::array::forcecast>::ensure(numbers);
  keep.push_back(numbers);
  return {reinterpret_cast<const Row*>(numbers.data()), static_cast<std::size_t>(numbers.shape(0)),
          static_cast<std::ptrdiff_t>(numbers.strides(0))};
}

template Strided<Eigen::Vector3d> rows_of<Eigen::Vector3d, double>(const py::object&, const std::string&,
                                                                   Keep&);
template Strided<Eigen::Vector3f> rows_of<Eigen::Vector3f, float>(const py::object&, const std::string&,
                                                                  Keep&);
template Strided<Eigen::Vector4f> rows_of<Eigen::Vector4f, float>(const py::object&, const std::string&,
                                                                  Keep&);

Strided<float> numbers_of(const py::object& array, const std::string& name, Keep& keep) {
  if (array.is_none()) return {};
  auto numbers = py::array_t<float, py::array::forcecast>::ensure(array);
  if (!numbers) {
    PyErr_Clear();
    throw py::value_error(name + " must be an array of numbers");
  }
  if (numbers.ndim() > 1) throw py::value_error(name + " must have the shape (n,)");
  keep.push_back(numbers);
  if (numbers.ndim() == 0) return {numbers.data(), 1};
  return {numbers.data(), static_cast<std::size_t>(numbers.shape(0)),
          static_cast<std::ptrdiff_t>(numbers.strides(0))};
}

Strided<float> packed_numbers_of(const py::object& array, Keep& keep) {
  if (array.is_none()) return {};
  auto numbers = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!numbers) throw py::error_already_set();
  keep.push_back(numbers);
  return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}

py::array array_from(std::vector<float> values, std::vector<py::ssize_t> shape) {
  auto owner = std::make_unique<std::vector<float>>(std::move(values));
  const float* data = owner->data();
  const py::capsule free(owner.get(), [](void* vector) { delete static_cast<std::vector<float>*>(vector); });
  static_cast<void>(owner.release());
  return py::array_t<float>(std::move(shape), data, free);
}

}  // namespace swept::python
