// Errors of the library as exceptions of Python.
#pragma once

#include <utility>

#include <pybind11/pybind11.h>

#include "splat/result.h"

namespace swept::python {

/// Throws the exception of swept/_errors.py that is for the error's kind.
[[noreturn]] inline void raise(const Error& error) {
  namespace py = pybind11;
  const py::object exception =
      py::module_::import("swept._errors")
          .attr("exception_of")(std::string(error_kind_name(error.kind)), printable(error.file),
                                printable(error.field), printable(error.reason), error.message());
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(exception.ptr())), exception.ptr());
  throw py::error_already_set();
}

inline void check(const Status& status) {
  if (!status) raise(status.error());
}
template <class T>
T checked(Result<T> result) {
  if (!result) raise(result.error());
  return *std::move(result);
}

}  // namespace swept::python
