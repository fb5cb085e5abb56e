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
  [[nodiscard]] float get(MemberField field, std::size_t i) const { return fields_[field][i]; }
  [[nodiscard]] float depth_at(std::size_t i, float time) const {
    return get(member_z, i) + get(member_z_rate, i) * (time - get(member_t_begin, i));
  }

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
    for (std::size_t field = 0; field < member_fields; ++field) values[field] = other.fields_[field][i];
    append(values);
  }

  /// The last member takes the place of member `i`.
  void remove(std::size_t i) {
    --size_;
    padded_ = false;
    for (std::vector<float>& field : fields_) field[i] = field[size_];
  }

  /// Fills the last vector with members of no weight.
  [[nodiscard]] Members view() {
    const std::size_t padded = (size_ + member_lanes - 1) / member_lanes * member_lanes;
    Members members{{}, size_, padded};
    if (!padded_) reserve(padded);
    for (std::size_t field = 0; field < member_fields; ++field) {
      // Copies of a real member but for the weight, so that no lane leaves the range of the others.
      if (!padded_)
        std::fill(fields_[field].begin() + size_, fields_[field].begin() + padded,
                  field == member_peak ? 0.0f : fields_[field][0]);
      members.field[field] = fields_[field].data();
    }
    padded_ = true;
    return members;
  }

 private:
  void append(const std::array<float, member_fields>& values) {
    reserve(size_ + 1);
    for (std::size_t field = 0; field < member_fields; ++field) fields_[field][size_] = values[field];
    ++size_;
    padded_ = false;
  }
  void reserve(std::size_t size) {
    if (size <= fields_[0].size()) return;
    for (std::vector<float>& field : fields_) field.resize(std::max<std::size_t>(64, 2 * size));
  }

  std::array<std::vector<float>, member_fields> fields_;
  std::size_t size_ = 0;
  bool padded_ = false;
};

}  // namespace swept
