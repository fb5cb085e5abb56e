// The plane and the spacing of the points around each point of a cloud.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace swept {

struct LocalFit {
  Eigen::Vector3d normal;  ///< unit, side arbitrary; +z where there is no plane to fit
  double spacing = 0.0;    ///< mean distance of the nearest distinct points; 0: there are none
};

/// A search tree over the distinct points of a cloud. Points that float cannot tell apart after the cloud is
/// moved to its centroid and scaled to [-1, 1] count as one. What a point gets does not depend on the order
/// of the points.
class Neighbourhood {
 public:
  /// Positions must be finite and stay where they are.
  explicit Neighbourhood(const std::vector<Eigen::Vector3d>& positions);
  ~Neighbourhood();
  Neighbourhood(const Neighbourhood&) = delete;
  Neighbourhood& operator=(const Neighbourhood&) = delete;

  /// Plane of point i and the 12 points nearest to it; spacing of the 6 nearest; of fewer where there
  /// are fewer. Of equally near points those with the lesser coordinates count, x first.
  [[nodiscard]] LocalFit fit(std::size_t i) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace swept
