// SWEPT_WITH_ASAN: 1 under AddressSanitizer, otherwise 0.
#pragma once

#if defined(__SANITIZE_ADDRESS__)
#define SWEPT_WITH_ASAN 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SWEPT_WITH_ASAN 1
#endif
#endif
#ifndef SWEPT_WITH_ASAN
#define SWEPT_WITH_ASAN 0
#endif
