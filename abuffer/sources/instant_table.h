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

  /// The objects at shutter time `numerator` / `denominator`.
  std::shared_ptr<const std::vector<ObjectInstant>> at(int numerator, int denominator) {
    const std::lock_guard lock(mutex_);
    auto& entry = instants_[{numerator, denominator}];
    if (!entry) {
      auto made = std::make_shared<std::vector<ObjectInstant>>();
      made->reserve(objects_.size());
      const double frame = exposure_.at(static_cast<double>(numerator) / denominator);
      for (const PointPackets& object : objects_) made->emplace_back(scene_, object, frame);
      entry = std::move(made);
    }
    return entry;
  }

 private:
  const Scene& scene_;
  Exposure exposure_;
  const std::vector<PointPackets>& objects_;
  std::mutex mutex_;
  std::map<std::pair<int, int>, std::shared_ptr<const std::vector<ObjectInstant>>> instants_;
};

}  // namespace swept
