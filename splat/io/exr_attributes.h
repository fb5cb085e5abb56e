// The attributes in an OpenEXR file's headers, held against what the file and the format allow.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "splat/result.h"

namespace swept {

/// More bytes of a chunk, unpacked, than a file of so many holds: deflate, the densest of OpenEXR's coders,
/// packs at most 1032 bytes into one. 64 MiB are fine in any case.
[[nodiscard]] inline std::uint64_t most_chunk_bytes(std::uint64_t file_bytes) {
  return std::max(std::uint64_t{64} << 20, 4096 * file_bytes);
}

/// Errors unless every attribute of the first headers up to the pixels ends within the file's `file_bytes`,
/// and is as long as its type is. OpenEXR's C++ reader goes by the one or the other, differently from type to
/// type, and takes as much memory as an attribute says it is long before it finds that the file is shorter.
/// Also an attribute that stands in a header twice, of which the C reader takes the first and the C++ reader
/// the last, and more attributes, channels or parts than it reads in a reasonable time are an error.
[[nodiscard]] Status check_exr_attributes(const std::string& path, std::uint64_t file_bytes);

}  // namespace swept
