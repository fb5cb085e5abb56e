// All objects at an instant, made when it is first asked for.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <tuple>
#include <utility>
#include <vector>

#include "abuffer/lens_looks.h"
#include "abuffer/sources/object_instant.h"

namespace swept {

/// Shared by threads. What it is made of must outlive it.
class InstantTable {
 public:
  /// `looks`: through the scene's lens, if it has one.
  InstantTable(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects,
               const LensLooks& looks)
      : scene_(scene),
        exposure_(exposure),
        objects_(objects),
        looks_(looks),
        pinhole_(looks.any() ? pinhole_of(scene) : Scene()) {}

  /// The objects at shutter time `numerator` / `denominator` of row `row` of the film; where all rows are
  /// exposed at once, of all of them.
  std::shared_ptr<const std::vector<ObjectInstant>> at(int numerator, int denominator, int row) {
    const double share = static_cast<double>(numerator) / denominator;
    // What one row sees no other does.
    if (exposure_.row_delay != 0.0) return make(scene_, exposure_.of_row(row).at(share));
    const std::lock_guard lock(mutex_);
    auto& entry = instants_[{-1, numerator, denominator}];
    if (!entry) entry = make(scene_, exposure_.at(share));
    return entry;
  }
  /// Look `i` through the lens; of given points, `instants` for each.
  std::shared_ptr<const std::vector<ObjectInstant>> look(int i, int instants) {
    const std::lock_guard lock(mutex_);
    auto& entry = instants_[{i, instants, 0}];
    if (!entry) {
      const LensLook look = looks_.at(i, instants);
      pinhole_.camera.lens_point = look.point;
      entry = make(pinhole_, exposure_.at(look.share));
    }
    return entry;
  }

 private:
  [[nodiscard]] std::shared_ptr<const std::vector<ObjectInstant>> make(const Scene& scene,
                                                                       double frame) const {
    auto made = std::make_shared<std::vector<ObjectInstant>>();
    made->reserve(objects_.size());
    for (const PointPackets& object : objects_) made->emplace_back(scene, object, frame);
    return made;
  }

  const Scene& scene_;
  Exposure exposure_;
  const std::vector<PointPackets>& objects_;
  std::mutex mutex_;
  const LensLooks looks_;
  Scene pinhole_;  ///< that is looked through
  std::map<std::tuple<int, int, int>, std::shared_ptr<const std::vector<ObjectInstant>>> instants_;
};

}  // namespace swept
