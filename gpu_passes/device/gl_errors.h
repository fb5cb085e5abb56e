// What OpenGL has to say about the calls made so far.
#pragma once

#include "splat/result.h"

namespace swept {

/// Keeps the driver's messages about errors in the current context, for take_errors() to quote.
void keep_error_messages();

/// The first error since the last call, in words, with what the driver says about it. All are taken, so that
/// none is blamed on what comes later. `doing` completes "… while", as in "the frame was drawn". A context
/// must be current.
[[nodiscard]] Status take_errors(const char* doing);

}  // namespace swept
