// The attributes in an OpenEXR file's headers, held against what the file and the format allow.
#pragma once

#include <cstdint>
#include <string>

#include "splat/result.h"

namespace swept {

/// Errors unless every attribute of the first headers up to the pixels ends within the file's `file_bytes`,
/// and is as long as its type is. OpenEXR's C++ reader goes by the one or the other, differently from type to
/// type, and takes as much memory as an attribute says it is long before it finds that the file is shorter.
/// Also an attribute that stands in a header twice, of which the C reader takes the first and the C++ reader
/// the last, and more attributes, channels or parts than it reads in a reasonable time are an error.
[[nodiscard]] Status check_exr_attributes(const std::string& path, std::uint64_t file_bytes);

}  // namespace swept
