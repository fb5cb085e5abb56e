// The fragments that cover one pixel at one time, as structure of arrays padded to whole vectors.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "abuffer/simd/interval_math.h"
#include "splat/interval/fragments.h"

namespace swept {

/// One member's fields, in the order of MemberField.
using Member = std::array<float, member_fields>;

/// At most twice exp(−y²) for |y| ≤ √3, and never less: for what is only to be bounded.
[[nodiscard]] inline float above_gaussian(float y) {
  const float s = y * y;
  return 1.0f / (1.0f + s * (1.0f + s * (0.5f + s * (1.0f / 6.0f + s * (1.0f / 24.0f)))));
}

[[nodiscard]] inline Member member_of(const FragmentArrays& fragments, std::size_t f, const Shade& shade) {
  const float y = fragments.y[f];
  const auto duration = static_cast<float>(share_of(fragments.t_end[f] - fragments.t_begin[f]));
  const float jump =
      fragments.peak[f] * std::max(above_gaussian(y), above_gaussian(y + fragments.rate[f] * duration));
  return {std::bit_cast<float>(fragments.t_begin[f]),
          fragments.y[f],
          fragments.rate[f],
          fragments.peak[f],
          fragments.z[f],
          fragments.z_rate[f],
          shade.depth_tolerance,
          shade.rgba[0],
          shade.rgba[1],
          shade.rgba[2],
          shade.rgba[3],
          std::bit_cast<float>(fragments.t_end[f]),
          jump,
          std::bit_cast<float>(shade.side)};
}

class MemberSet {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }
  void clear() { size_ = 0; }

  void push(const FragmentArrays& fragments, std::size_t f, const Shade& shade) {
    push(member_of(fragments, f, shade));
  }
  void push(const Member& member) {
    if (size_ == stride_) grow(size_ + 1);
    for (std::size_t field = 0; field < member_fields; ++field)
      data_[field * stride_ + size_] = member[field];
    ++size_;
  }

  void pop() { --size_; }

  /// The last member takes the place of member `i`.
  void remove(std::size_t i) {
    --size_;
    for (std::size_t field = 0; field < member_fields; ++field)
      data_[field * stride_ + i] = data_[field * stride_ + size_];
  }

  [[nodiscard]] const float* field(MemberField which) const { return data_.data() + which * stride_; }
  void set(MemberField which, std::size_t i, float value) { data_[which * stride_ + i] = value; }
  [[nodiscard]] Ticks t_begin(std::size_t i) const { return std::bit_cast<Ticks>(field(member_t_begin)[i]); }
  [[nodiscard]] Ticks t_end(std::size_t i) const { return std::bit_cast<Ticks>(field(member_t_end)[i]); }
  [[nodiscard]] Members view() const {
    return {data_.data(), stride_, size_, (size_ + member_lanes - 1) / member_lanes * member_lanes};
  }

 private:
  void grow(std::size_t least) {
    std::size_t stride = std::max<std::size_t>(64, 2 * stride_);  // whole vectors
    while (stride < least) stride *= 2;
    std::vector<float> data(member_fields * stride);
    for (std::size_t field = 0; field < member_fields; ++field)
      std::copy_n(data_.begin() + static_cast<std::ptrdiff_t>(field * stride_), stride_,
                  data.begin() + static_cast<std::ptrdiff_t>(field * stride));
    data_ = std::move(data);
    stride_ = stride;
  }

  std::vector<float> data_;
  std::size_t stride_ = 0, size_ = 0;
};

}  // namespace swept
