// One attribute of all points of a cloud: an array of its own, or a view of the caller's.
#pragma once

#include <cassert>
#include <compare>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <type_traits>
#include <utility>
#include <vector>

#include "splat/export.h"
#include "splat/strided.h"

namespace SWEPT_API swept {

/// As std::vector, except that it can be a view of the caller's array, made by view() without a copy. The
/// array must outlive the view and its copies, and must not change meanwhile. A view that is written to, or
/// read through an object that is not const, first becomes an array of its own.
template <class T>
class PointArray {
 public:
  using value_type = T;

  class Iterator {
   public:
    using iterator_category = std::random_access_iterator_tag;
    using value_type = T;
    using difference_type = std::ptrdiff_t;
    using pointer = const T*;
    using reference = const T&;

    Iterator() = default;
    Iterator(const PointArray* array, std::size_t at) : array_(array), at_(at) {}
    reference operator*() const { return (*array_)[at_]; }
    pointer operator->() const { return &(*array_)[at_]; }
    reference operator[](difference_type i) const { return *(*this + i); }
    Iterator& operator++() { return *this += 1; }
    Iterator operator++(int) { return std::exchange(*this, *this + 1); }
    Iterator& operator--() { return *this -= 1; }
    Iterator operator--(int) { return std::exchange(*this, *this - 1); }
    Iterator& operator+=(difference_type n) {
      at_ += static_cast<std::size_t>(n);
      return *this;
    }
    Iterator& operator-=(difference_type n) { return *this += -n; }
    friend Iterator operator+(Iterator i, difference_type n) { return i += n; }
    friend Iterator operator+(difference_type n, Iterator i) { return i += n; }
    friend Iterator operator-(Iterator i, difference_type n) { return i -= n; }
    friend difference_type operator-(const Iterator& a, const Iterator& b) {
      return static_cast<difference_type>(a.at_) - static_cast<difference_type>(b.at_);
    }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.at_ == b.at_; }
    friend auto operator<=>(const Iterator& a, const Iterator& b) { return a.at_ <=> b.at_; }

   private:
    const PointArray* array_ = nullptr;
    std::size_t at_ = 0;
  };

  PointArray() = default;
  PointArray(std::vector<T> values) : own_(std::move(values)) {}
  PointArray(std::initializer_list<T> values) : own_(values) {}
  explicit PointArray(std::size_t count, const T& value = T()) : own_(count, value) {}

  [[nodiscard]] static PointArray view(const Strided<T>& values) {
    PointArray array;
    array.view_ = values;
    array.is_view_ = true;
    return array;
  }
  [[nodiscard]] bool is_view() const { return is_view_; }

  [[nodiscard]] std::size_t size() const { return is_view_ ? view_.count : own_.size(); }
  [[nodiscard]] bool empty() const { return size() == 0; }
  [[nodiscard]] const T& operator[](std::size_t i) const {
    assert(i < size());
    return is_view_ ? view_[i] : own_[i];
  }
  [[nodiscard]] T& operator[](std::size_t i) {
    assert(i < size());
    return own()[i];
  }
  [[nodiscard]] const T& front() const { return (*this)[0]; }
  [[nodiscard]] const T& back() const { return (*this)[size() - 1]; }
  [[nodiscard]] T& front() { return own().front(); }
  [[nodiscard]] T& back() { return own().back(); }
  [[nodiscard]] Iterator begin() const { return {this, 0}; }
  [[nodiscard]] Iterator end() const { return {this, size()}; }
  [[nodiscard]] T* begin() { return own().data(); }
  [[nodiscard]] T* end() { return own().data() + own().size(); }

  /// Whether the values lie one after the other, as in an array of T.
  [[nodiscard]] bool contiguous() const {
    return !is_view_ || view_.stride_bytes == static_cast<std::ptrdiff_t>(sizeof(T));
  }
  /// Precondition: contiguous().
  [[nodiscard]] const T* data() const {
    assert(contiguous());
    return is_view_ ? view_.data : own_.data();
  }
  [[nodiscard]] T* data() { return own().data(); }

  /// The values as an array of its own, which can be changed.
  std::vector<T>& own() {
    if (is_view_) {
      std::vector<T> values;
      values.reserve(view_.count);
      for (std::size_t i = 0; i < view_.count; ++i) values.push_back(view_[i]);
      own_ = std::move(values);
      is_view_ = false;
    }
    return own_;
  }

  void push_back(const T& value) { own().push_back(value); }
  template <class... Arguments>
  T& emplace_back(Arguments&&... arguments) {
    return own().emplace_back(std::forward<Arguments>(arguments)...);
  }
  void pop_back() { own().pop_back(); }
  void reserve(std::size_t count) { own().reserve(count); }
  void resize(std::size_t count) { own().resize(count); }
  void resize(std::size_t count, const T& value) { own().resize(count, value); }
  void assign(std::size_t count, const T& value) { *this = PointArray(count, value); }
  template <class Input>
  requires(!std::is_integral_v<Input>) void assign(Input first, Input last) {
    *this = PointArray(std::vector<T>(first, last));
  }
  void clear() { *this = PointArray(); }

  friend bool operator==(const PointArray& a, const PointArray& b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (!(a[i] == b[i])) return false;
    return true;
  }

 private:
  std::vector<T> own_;
  Strided<T> view_;
  bool is_view_ = false;
};

}  // namespace swept
