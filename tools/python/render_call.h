// A render that Python waits for: other threads of Python go on, and Ctrl-C stops it.
#pragma once

#include <functional>

#include <pybind11/pybind11.h>

#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"

namespace swept::python {

/// render(control) in a thread of its own, without the interpreter's lock, with the callbacks made Python's
/// `progress` and `log`, which may be None. A signal, and what a callback raises, stop the render and are
/// raised. Errors of the render are raised, too.
[[nodiscard]] Rendered render_call(const std::function<Result<Rendered>(const RenderControl&)>& render,
                                   RenderControl control, const pybind11::object& progress,
                                   const pybind11::object& log);

}  // namespace swept::python
