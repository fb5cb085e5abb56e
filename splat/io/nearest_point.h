// Which of some points is nearest to a place: a tree of boxes.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

namespace swept {

class NearestPoint {
 public:
  /// Among positions[i] for i in `among`, which must not be empty. Positions must be finite and stay where
  /// they are.
  NearestPoint(const std::vector<Eigen::Vector3d>& positions, std::vector<std::size_t> among);

  /// An index of `among`; of several at the same distance any, but always the same.
  [[nodiscard]] std::size_t to(const Eigen::Vector3d& place) const;

 private:
  struct Best {
    double squared;
    std::size_t index;
  };
  void build(std::size_t node, std::size_t begin, std::size_t end);
  void search(std::size_t node, std::size_t begin, std::size_t end, const Eigen::Vector3d& place,
              Best& best) const;

  const std::vector<Eigen::Vector3d>& positions_;
  std::vector<std::size_t> order_;
  std::vector<Eigen::AlignedBox3d> box_;  ///< node n has the children 2 n + 1 and 2 n + 2
};

}  // namespace swept
