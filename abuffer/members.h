// The fragments that cover one pixel at one time, as structure of arrays padded to whole vectors.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "abuffer/fragments.h"
#include "abuffer/interval_math.h"

namespace swept {

class MemberSet {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] float get(MemberField field, std::size_t i) const { return data_[field * stride_ + i]; }

  void clear() {
    size_ = 0;
    padded_ = false;
  }

  void push(const FragmentArrays& fragments, std::size_t f, const Shade& shade) {
    append({fragments.t_begin[f], fragments.y[f], fragments.rate[f], fragments.peak[f], fragments.z[f],
            fragments.z_rate[f], shade.depth_tolerance, shade.rgba[0], shade.rgba[1], shade.rgba[2],
            shade.rgba[3]});
  }

  void push(const MemberSet& other, std::size_t i) {
    std::array<float, member_fields> values;
    for (std::size_t field = 0; field < member_fields; ++field)
      values[field] = other.data_[field * other.stride_ + i];
    append(values);
  }

  /// The last member takes the place of member `i`.
  void remove(std::size_t i) {
    --size_;
    padded_ = false;
    for (std::size_t field = 0; field < member_fields; ++field)
      data_[field * stride_ + i] = data_[field * stride_ + size_];
  }

  /// Fills the last vector with members of no weight. Precondition: size() > 0.
  [[nodiscard]] Members view() {
    const std::size_t padded = (size_ + member_lanes - 1) / member_lanes * member_lanes;
    if (!padded_)
      for (std::size_t field = 0; field < member_fields; ++field) {
        // Copies of a real member but for the weight, so that no lane leaves the range of the others.
        float* const values = data_.data() + field * stride_;
        std::fill(values + size_, values + padded, field == member_peak ? 0.0f : values[0]);
      }
    padded_ = true;
    return {data_.data(), stride_, size_, padded};
  }

 private:
  void append(const std::array<float, member_fields>& values) {
    if (size_ == stride_) grow();
    for (std::size_t field = 0; field < member_fields; ++field)
      data_[field * stride_ + size_] = values[field];
    ++size_;
    padded_ = false;
  }
  void grow() {
    const std::size_t stride = std::max<std::size_t>(64, 2 * stride_);  // whole vectors
    std::vector<float> data(member_fields * stride);
    for (std::size_t field = 0; field < member_fields; ++field)
      std::copy_n(data_.begin() + static_cast<std::ptrdiff_t>(field * stride_), size_,
                  data.begin() + static_cast<std::ptrdiff_t>(field * stride));
    data_ = std::move(data);
    stride_ = stride;
  }

  std::vector<float> data_;
  std::size_t stride_ = 0, size_ = 0;
  bool padded_ = false;
};

}  // namespace swept
