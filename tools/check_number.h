// A check of numbers on the command line.
#pragma once

#include <cmath>
#include <cstdlib>
#include <string>

namespace swept {

/// For CLI11: empty for a number, else why not. Bounds alone let nan through.
[[nodiscard]] inline std::string check_is_number(const std::string& text) {
  return std::isnan(std::strtod(text.c_str(), nullptr)) ? "must be a number: " + text : "";
}

}  // namespace swept
