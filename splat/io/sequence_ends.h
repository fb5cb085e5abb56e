// What an exposure sees of a sequence before its first file and after its last.
#pragma once

#include "splat/io/cloud_keys.h"
#include "splat/io/cloud_source.h"

namespace swept::io {

/// Adds keys where frames [first, last] reach beyond the files of `source`, which the keys of `loaded` come
/// from: points move on along the rates of the file at that end, as those of a single file do. Does nothing
/// where that file has none, or is not the one nearest to the middle, whose points the cloud begins with;
/// then the end is held.
[[nodiscard]] Status add_ends(const CloudSource& source, const KeySpan& span, double first, double last,
                              LoadedCloud& loaded);

}  // namespace swept::io
