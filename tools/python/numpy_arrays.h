// Arrays of NumPy as the library takes and gives them.
#pragma once

#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <Eigen/Core>

#include "splat/strided.h"

namespace swept::python {

/// Arrays that something looks into, and that so have to live as long.
using Keep = std::vector<pybind11::object>;

[[nodiscard]] bool is_double_array(const pybind11::object& array);

/// Rows of `width` numbers of type Number, e.g. (n, 3) for vectors; a view where the array has that type and
/// each row's numbers lie side by side, else of a copy. None: none. Raises ValueError about `name`.
template <class Row, class Number>
[[nodiscard]] Strided<Row> rows_of(const pybind11::object& array, const std::string& name, Keep& keep);

extern template Strided<Eigen::Vector3d> rows_of<Eigen::Vector3d, double>(const pybind11::object&,
                                                                          const std::string&, Keep&);
extern template Strided<Eigen::Vector3f> rows_of<Eigen::Vector3f, float>(const pybind11::object&,
                                                                         const std::string&, Keep&);
extern template Strided<Eigen::Vector4f> rows_of<Eigen::Vector4f, float>(const pybind11::object&,
                                                                         const std::string&, Keep&);

/// A number for each point, or a single one.
[[nodiscard]] Strided<float> numbers_of(const pybind11::object& array, const std::string& name, Keep& keep);

/// All numbers of an array of any shape, one after the other.
[[nodiscard]] Strided<float> packed_numbers_of(const pybind11::object& array, const std::string& name,
                                               Keep& keep);

/// An array that owns `values`, which are not copied.
[[nodiscard]] pybind11::array array_from(std::vector<float> values, std::vector<pybind11::ssize_t> shape);

}  // namespace swept::python
