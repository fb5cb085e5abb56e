// What a shared library shows: the namespace of every public header, and of those that other libraries of
// ours use, is opened as `namespace SWEPT_API swept`, and all else in it stays hidden.
#pragma once

#if defined(__GNUC__) && !defined(_WIN32)
#define SWEPT_API [[gnu::visibility("default")]]
#else
#define SWEPT_API
#endif
