// The names that attributes go by in the files of the tools we know: one table for all formats.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace swept {

/// An attribute, and the properties that make it up under each of its usual names, the likeliest first.
struct AttributeNames {
  const char* attribute;
  std::size_t least, most;                      ///< how many properties a caller may name
  std::vector<std::vector<std::string>> usual;  ///< folded
};

/// position, normal, velocity, color, radius, width, opacity, intensity, id, in this order.
[[nodiscard]] const std::vector<AttributeNames>& attribute_names();

/// A name as the table has it: lower case, without CloudCompare's "scalar_", a unit in brackets, and what
/// parts words: "Velocity_X", "velocityX" and "velocity[x]" are velocityx, "x [m]" is x.
[[nodiscard]] std::string folded(std::string_view name);

/// Whether a property of this name that holds several numbers is one of our vectors: v, N, Cd, position, …
[[nodiscard]] bool is_vector_name(std::string_view name);

}  // namespace swept
