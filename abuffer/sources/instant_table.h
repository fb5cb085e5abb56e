// All objects at an instant, made when it is first asked for.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "abuffer/sources/object_instant.h"

namespace swept {

/// Shared by threads. What it is made of must outlive it.
class InstantTable {
 public:
  InstantTable(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects)
      : scene_(scene), exposure_(exposure), objects_(objects) {}

  /// The objects at shutter time `numerator` / `denominator` of row `row` of the film; where all rows are
  /// exposed at once, of all of them.
  std::shared_ptr<const std::vector<ObjectInstant>> at(int numerator, int denominator, int row) {
    const double share = static_cast<double>(numerator) / denominator;
    // What one row sees no other does.
    if (exposure_.row_delay != 0.0) return make(exposure_.of_row(row).at(share));
    const std::lock_guard lock(mutex_);
    auto& entry = instants_[{numerator, denominator}];
    if (!entry) entry = make(exposure_.at(share));
    return entry;
  }

 private:
  [[nodiscard]] std::shared_ptr<const std::vector<ObjectInstant>> make(double frame) const {
    auto made = std::make_shared<std::vector<ObjectInstant>>();
    made->reserve(objects_.size());
    for (const PointPackets& object : objects_) made->emplace_back(scene_, object, frame);
    return made;
  }

  const Scene& scene_;
  Exposure exposure_;
  const std::vector<PointPackets>& objects_;
  std::mutex mutex_;
  std::map<std::pair<int, int>, std::shared_ptr<const std::vector<ObjectInstant>>> instants_;
};

}  // namespace swept
