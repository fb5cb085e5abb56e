// Arrays of hundreds of megabytes, each value of which is written before it is read.
#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace swept {

/// Leaves new values as they are found. That saves one thread's pass over all of them, and the threads that
/// write them have the system make the pages, side by side.
template <class T>
struct UnsetAllocator : std::allocator<T> {
  template <class Other>
  struct rebind {
    using other = UnsetAllocator<Other>;
  };
  UnsetAllocator() = default;
  template <class Other>
  UnsetAllocator(const UnsetAllocator<Other>&) {}

  template <class Value>
  void construct(Value* at) {
    ::new (static_cast<void*>(at)) Value;
  }
  template <class Value, class... Arguments>
  void construct(Value* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) Value(std::forward<Arguments>(arguments)...);
  }
};

template <class T>
using UnsetArray = std::vector<T, UnsetAllocator<T>>;

}  // namespace swept
