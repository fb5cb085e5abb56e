// What of the standard library's exceptions would leave a public function, as an error. For splat/io's own
// sources.
#pragma once

#include <exception>
#include <new>
#include <string>

#include "splat/result.h"

namespace swept::io {

/// What `function` returns; errors about `file` for what it throws.
template <class Function>
auto guarded(const std::string& file, const Function& function) -> decltype(function()) {
  try {
    return function();
  } catch (const Error& error) {
    return error;
  } catch (const std::bad_alloc&) {
    return Error{file, "", "not enough memory"};
  } catch (const std::exception& exception) {
    return Error{file, "", exception.what()};
  }
}

}  // namespace swept::io
