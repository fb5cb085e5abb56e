// A JSON schema of scene files, for editors: they complete keys, show what they mean and mark mistakes.
#pragma once

#include <string>

namespace swept {

/// Draft 07, indented, from the tables of splat/fields.h and the generators. What no schema can say, such as
/// keys in order of their frames, swept says when it reads the file.
[[nodiscard]] std::string scene_schema();

}  // namespace swept
