// What would leave a public function, as an error. For splat/io's own sources.
#pragma once

#include <new>
#include <string>

#include "splat/result.h"
#include "splat/without_throwing.h"

namespace swept::io {

/// What `function` returns; errors about `file` for what it throws, an Error as it is.
template <class Function>
auto guarded(const std::string& file, const Function& function) noexcept -> decltype(function()) {
  const auto about_file = [&file](Error error) {
    if (error.kind != ErrorKind::out_of_memory) error.kind = ErrorKind::malformed;
    try {
      error.file = file;
    } catch (const std::bad_alloc&) {  // which file is then left unsaid
    }
    return error;
  };
  auto result = without_throwing("", [&]() -> decltype(function()) {
    try {
      return function();
    } catch (const Error& error) {
      return error;
    } catch (const std::bad_alloc&) {
      return about_file(memory_error(""));
    } catch (const std::length_error&) {
      return about_file(memory_error(""));
    } catch (const std::exception& exception) {
      return about_file(Error{"", "", exception.what()});
    }
  });
  return result;
}

}  // namespace swept::io
