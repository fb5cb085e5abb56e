// What would be thrown out of a public function, as an error. For the project's own sources.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <stop_token>
#include <string>

#include "splat/result.h"

namespace swept {

/// In place of what a callback of the caller threw.
struct CallbackThrew : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a render that was stopped returns.
[[nodiscard]] inline Error stopped_error() {
  return Error{"", "", "the render was stopped", ErrorKind::cancelled};
}

/// Thrown out of loops that have nothing else to tell: without_throwing() returns stopped_error() for it.
struct Stopped {};
inline void throw_if_stopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Stopped();
}

/// call(argument...), with what it throws made a CallbackThrew.
template <class Callback, class... Arguments>
void call_back(const Callback& callback, const Arguments&... arguments) {
  std::string what = "something that is no exception";
  try {
    return callback(arguments...);
  } catch (const std::exception& exception) {
    what = exception.what();
  } catch (...) {
  }
  throw CallbackThrew("the caller's function threw: " + what);
}

/// "not enough memory `for_what`"; where there is none for these words either, fewer.
[[nodiscard]] inline Error memory_error(const char* for_what) noexcept {
  Error error;
  error.kind = ErrorKind::out_of_memory;
  try {
    error.reason = "not enough memory";
    if (*for_what != '\0') (error.reason += ' ') += for_what;
  } catch (...) {
    error.reason = "out of memory";  // short enough for the string itself
  }
  return error;
}

/// What `work` returns; errors for what it throws. `for_what` as in memory_error().
template <class Work>
[[nodiscard]] auto without_throwing(const char* for_what, const Work& work) noexcept -> decltype(work()) {
  try {
    try {
      return work();
    } catch (const std::bad_alloc&) {
      return memory_error(for_what);
    } catch (const std::length_error&) {  // a size beyond what any memory could hold
      return memory_error(for_what);
    } catch (const Stopped&) {
      return stopped_error();
    } catch (const CallbackThrew& thrown) {
      return Error{"", "progress", thrown.what(), ErrorKind::argument};
    } catch (const std::exception& exception) {
      return Error{"", "", exception.what(), ErrorKind::device};
    }
  } catch (...) {
    return memory_error(for_what);
  }
}

}  // namespace swept
