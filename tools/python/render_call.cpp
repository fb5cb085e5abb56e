#include "tools/python/render_call.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "tools/python/raise.h"

namespace swept::python {

namespace py = pybind11;

Rendered render_call(const std::function<Result<Rendered>(const RenderControl&)>& render,
                     RenderControl control, const py::object& progress, const py::object& log) {
  std::stop_source stop;
  control.stop = stop.get_token();
  std::optional<py::error_already_set> raised;  // by a callback; touched under the interpreter's lock
  const auto call = [&](const py::object& function, const auto& argument) {
    const py::gil_scoped_acquire lock;
    if (raised) return;
    try {
      function(argument);
    } catch (py::error_already_set& error) {
      raised.emplace(std::move(error));
      stop.request_stop();
    }
  };
  if (!progress.is_none()) control.progress = [&](double share) { call(progress, share); };
  if (!log.is_none()) control.log = [&](const std::string& line) { call(log, line); };

  std::mutex mutex;
  std::condition_variable changed;
  std::optional<Result<Rendered>> result;  // under `mutex`
  bool interrupted = false;
  {
    const py::gil_scoped_release unlocked;
    std::jthread worker([&] {
      Result<Rendered> rendered = render(control);
      const std::lock_guard lock(mutex);
      result.emplace(std::move(rendered));
      changed.notify_all();
    });
    std::unique_lock lock(mutex);
    while (!changed.wait_for(lock, std::chrono::milliseconds(20), [&] { return result.has_value(); })) {
      // Not with `mutex` held: a callback waits for the interpreter's lock in the other thread.
      lock.unlock();
      {
        const py::gil_scoped_acquire locked;
        if (!interrupted && PyErr_CheckSignals() != 0) {
          interrupted = true;
          raised.emplace();  // takes the pending exception, KeyboardInterrupt as a rule
          stop.request_stop();
        }
      }
      lock.lock();
    }
  }
  if (raised) {
    py::error_already_set error = std::move(*raised);
    raised.reset();
    throw error;
  }
  return checked(std::move(*result));
}

}  // namespace swept::python
