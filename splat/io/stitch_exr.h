// Crops of one frame, put together.
#pragma once

#include <string>
#include <vector>

#include "splat/export.h"
#include "splat/io/atomic_file.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// Writes to `path` the frame that the files `parts`, in any order, are crops of: all of their channels, bit
/// for bit, and the header that the frame has when it is rendered whole. Parts may overlap where they agree.
/// Deep images are put together likewise, sample by sample, line by line.
///
/// Errors: parts that cannot be read, that say of no whole frame that they are a part of it or of different
/// ones (their type, wholeHash, film, method or channels differ), that disagree where they overlap, and film
/// that none of them covers: the message names the windows that are missing, as --crop has them.
[[nodiscard]] Status stitch_exr(const std::vector<std::string>& parts, const std::string& path,
                                IfExists existing = IfExists::replace);

}  // namespace swept
