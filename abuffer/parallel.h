// Loops shared out to threads. For the project's own sources.
//
// By oneTBB; but under ThreadSanitizer by plain threads, which divide a range as oneTBB would. The library is
// not compiled with it and orders its threads by means that it does not see: every loop would be reported,
// whatever it does. It is our loops that are checked, and so no report needs to be suppressed.
#pragma once

#include <cstddef>

#include <memory>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define SWEPT_TSAN
#endif
#endif
#if defined(__SANITIZE_THREAD__)
#define SWEPT_TSAN
#endif

#ifdef SWEPT_TSAN
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

#include <tbb/task_arena.h>
#endif

#include "splat/without_throwing.h"

namespace swept {

/// A value for each thread of a loop. In memory of the standard allocator: oneTBB's own hands it from thread
/// to thread in ways that ThreadSanitizer does not see.
template <class Value>
using PerThread = tbb::enumerable_thread_specific<Value, std::allocator<Value>>;

#ifdef SWEPT_TSAN

/// Whether ThreadSanitizer watches. Libraries that are not compiled with it must not start threads then.
inline constexpr bool thread_sanitizer = true;

/// Calls `body(part)` for parts of a range of oneTBB's, in any order, on as many threads as the arena has.
/// What it throws, one of it if several do, is thrown on.
template <class Range, class Body>
void parallel_for_parts(const Range& range, const Body& body) {
  const auto count = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  std::vector<Range> parts;
  if (!range.empty()) parts.push_back(range);
  // Several parts a thread, so that they meet in many orders.
  for (bool divided = true; divided && parts.size() < 8 * count;) {
    divided = false;
    for (std::size_t i = 0, size = parts.size(); i < size; ++i) {
      if (!parts[i].is_divisible()) continue;
      Range right(parts[i], tbb::split());
      parts.push_back(right);
      divided = true;
    }
  }

  std::atomic<std::size_t> next{0};
  std::vector<std::exception_ptr> thrown(count);
  const auto work = [&](std::size_t thread) {
    try {
      for (std::size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < parts.size();) body(parts[i]);
    } catch (...) {
      thrown[thread] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t thread = 1; thread < count; ++thread) threads.emplace_back(work, thread);
    work(0);
  }
  for (const std::exception_ptr& exception : thrown)
    if (exception) std::rethrow_exception(exception);
}

#else

inline constexpr bool thread_sanitizer = false;

/// A loop of a render that is stopped (run_in_arena) leaves out what it has not begun, and throws Stopped.
template <class Range, class Body>
void parallel_for_parts(const Range& range, const Body& body) {
  tbb::parallel_for(range, body);
  if (tbb::is_current_task_group_canceling()) throw Stopped();
}

#endif

/// Calls `body(index)` for every index of [0, count), likewise.
template <class Body>
void parallel_for_each_index(std::size_t count, const Body& body) {
  parallel_for_parts(tbb::blocked_range<std::size_t>(0, count), [&](const auto& part) {
    for (std::size_t index = part.begin(); index != part.end(); ++index) {
      // Parts may be long; of many indices each takes no time.
      if ((count < 4096 || index % 256 == 0) && tbb::is_current_task_group_canceling()) return;
      body(index);
    }
  });
}

}  // namespace swept
