// Files of a sequence that hold no points: particles that are not born yet, or all gone.
#pragma once

#include <functional>
#include <string>

#include "splat/io/cloud_source.h"

namespace swept::io {

/// "FILE has no points".
[[nodiscard]] std::string empty_note(const std::string& path);

/// Reads what a source shows over frames [first, last].
using ReadSource = std::function<Result<LoadedCloud>(const CloudSource&, double first, double last)>;

/// What `read` makes of `source`, some of whose files may be empty (ErrorKind::empty). The points of the
/// files before an empty one exist until halfway to it, those of the files after it from halfway on, and move
/// there as beyond the ends of a sequence. Where [first, last] has both, those that are there in its middle
/// are taken. Where it has neither the cloud is empty.
[[nodiscard]] Result<LoadedCloud> read_beside_empty(const CloudSource& source, double first, double last,
                                                    const ReadSource& read);

}  // namespace swept::io
