#include "tools/python/numpy_arrays.h"

#include <cstddef>
#include <memory>
#include <utility>

namespace swept::python {

namespace py = pybind11;

bool is_double_array(const py::object& array) {
  return py::isinstance<py::array>(array) && py::cast<py::array>(array).dtype().is(py::dtype::of<double>());
}

namespace {

/// An array of `Number` with all numbers of `array`. forcecast: another type, or a list, becomes a copy; an
/// array of this type stays itself. Complex numbers, dates and text would lose what they mean.
template <class Number, int flags = 0>
py::array_t<Number, flags | py::array::forcecast> array_of(const py::object& array, const std::string& name) {
  const py::array any = py::array::ensure(array);
  if (any && std::string("biufO").find(any.dtype().kind()) != std::string::npos) {
    auto numbers = py::array_t<Number, flags | py::array::forcecast>::ensure(any);
    if (numbers) return numbers;
  }
  PyErr_Clear();
  throw py::value_error(name + " must be an array of numbers");
}

/// What is given is not to be taken for what is left out.
void check_not_empty(const py::array& numbers, const std::string& name) {
  if (numbers.size() == 0 && name != "positions")
    throw py::value_error(name + " is empty; None leaves it out");
}

}  // namespace

template <class Row, class Number>
Strided<Row> rows_of(const py::object& array, const std::string& name, Keep& keep) {
  if (array.is_none()) return {};
  constexpr py::ssize_t width = sizeof(Row) / sizeof(Number);
  auto numbers = array_of<Number>(array, name);
  if (numbers.ndim() != 2 || numbers.shape(1) != width)
    throw py::value_error(name + " must have the shape (n, " + std::to_string(width) + ")");
  check_not_empty(numbers, name);
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
  auto numbers = array_of<float>(array, name);
  if (numbers.ndim() > 1) throw py::value_error(name + " must have the shape (n,)");
  check_not_empty(numbers, name);
  keep.push_back(numbers);
  if (numbers.ndim() == 0) return {numbers.data(), 1};
  return {numbers.data(), static_cast<std::size_t>(numbers.shape(0)),
          static_cast<std::ptrdiff_t>(numbers.strides(0))};
}

Strided<float> packed_numbers_of(const py::object& array, const std::string& name, Keep& keep) {
  if (array.is_none()) return {};
  auto numbers = array_of<float, py::array::c_style>(array, name);
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
