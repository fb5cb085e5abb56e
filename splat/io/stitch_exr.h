// Puts crops of one frame together.
#pragma once

#include <string>
#include <vector>

#include "splat/export.h"
#include "splat/io/atomic_file.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// Writes to `path` the frame of which the files `parts`, in any order, are crops: all of their channels, bit
/// for bit, and the header that the frame has when it is rendered whole. Parts may overlap if they agree
/// there. Deep images are put together likewise, sample by sample.
///
/// Errors: parts that cannot be read; parts that do not say which whole frame they are a part of, or are
/// parts of different ones (their type, wholeHash, film, method or channels differ); parts that disagree
/// where they overlap; film that none of them covers. The message of the last names the missing windows as
/// --crop does.
[[nodiscard]] Status stitch_exr(const std::vector<std::string>& parts, const std::string& path,
                                IfExists existing = IfExists::replace);

}  // namespace swept
