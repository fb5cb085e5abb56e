// All objects at an instant, made when it is first asked for.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <tuple>
#include <utility>
#include <vector>

#include "abuffer/sources/object_instant.h"

namespace swept {

/// Shared by threads. What it is made of must outlive it.
class InstantTable {
 public:
  InstantTable(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects)
      : scene_(scene), exposure_(exposure), objects_(objects) {}
  /// Of a scene with a lens, that is looked through `lens`.
  InstantTable(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects,
               const std::vector<Eigen::Vector2d>& lens)
      : InstantTable(scene, exposure, objects) {
    Scene pinhole;
    pinhole.film = scene.film;
    pinhole.model = scene.model;
    pinhole.camera = scene.camera;
    pinhole.camera.aperture = {};
    for (const Eigen::Vector2d& point : lens) {
      pinhole.camera.lens_point = point;
      through_.push_back(pinhole);
    }
  }

  /// The objects at shutter time `numerator` / `denominator` of row `row` of the film; where all rows are
  /// exposed at once, of all of them.
  std::shared_ptr<const std::vector<ObjectInstant>> at(int numerator, int denominator, int row) {
    const double share = static_cast<double>(numerator) / denominator;
    // What one row sees no other does.
    if (exposure_.row_delay != 0.0) return make(scene_, exposure_.of_row(row).at(share));
    return find(-1, numerator, denominator, share);
  }
  /// Through point `i` of the lens at the `k`-th of `count` instants, which are evenly spaced for each point
  /// and begin at another time for each, so that those of all points together fill the exposure.
  std::shared_ptr<const std::vector<ObjectInstant>> through_lens(int i, int k, int count) {
    // Van der Corput's sequence: half a point's spacing at least from the ends of its stratum.
    double start = 0.0, digit = 0.5;
    for (int rest = i; rest > 0; rest /= 2, digit *= 0.5) start += digit * (rest % 2);
    start += 0.5 / static_cast<double>(through_.size());
    return find(i, k, count, std::min(1.0, (k + start) / count));
  }

 private:
  std::shared_ptr<const std::vector<ObjectInstant>> find(int point, int k, int count, double share) {
    const std::lock_guard lock(mutex_);
    auto& entry = instants_[{point, k, count}];
    if (!entry)
      entry = make(point < 0 ? scene_ : through_[static_cast<std::size_t>(point)], exposure_.at(share));
    return entry;
  }
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
  std::vector<Scene> through_;  ///< by point of the lens, without objects
  std::map<std::tuple<int, int, int>, std::shared_ptr<const std::vector<ObjectInstant>>> instants_;
};

}  // namespace swept
