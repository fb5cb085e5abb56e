#include "splat/io/nearest_point.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace swept {
namespace {

constexpr std::size_t kLeaf = 8;

}  // namespace

NearestPoint::NearestPoint(const std::vector<Eigen::Vector3d>& positions, std::vector<std::size_t> among)
    : positions_(positions), order_(std::move(among)) {
  build(0, 0, order_.size());
}

void NearestPoint::build(std::size_t node, std::size_t begin, std::size_t end) {
  Eigen::AlignedBox3d box;
  for (std::size_t k = begin; k < end; ++k) box.extend(positions_[order_[k]]);
  if (box_.size() <= node) box_.resize(node + 1);
  box_[node] = box;
  if (end - begin <= kLeaf) return;
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t k) { return order_.begin() + static_cast<std::ptrdiff_t>(k); };
  // Ties by index, so that the tree does not depend on the library's nth_element.
  std::nth_element(at(begin), at(middle), at(end), [&](std::size_t a, std::size_t b) {
    return std::pair(positions_[a][axis], a) < std::pair(positions_[b][axis], b);
  });
  build(2 * node + 1, begin, middle);
  build(2 * node + 2, middle, end);
}

void NearestPoint::search(std::size_t node, std::size_t begin, std::size_t end, const Eigen::Vector3d& place,
                          Best& best) const {
  if (!(box_[node].squaredExteriorDistance(place) < best.squared)) return;
  if (end - begin <= kLeaf) {
    for (std::size_t k = begin; k < end; ++k) {
      const double squared = (positions_[order_[k]] - place).squaredNorm();
      if (squared < best.squared) best = {squared, order_[k]};
    }
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2, left = 2 * node + 1, right = left + 1;
  const bool left_first =
      box_[left].squaredExteriorDistance(place) <= box_[right].squaredExteriorDistance(place);
  if (left_first) search(left, begin, middle, place, best);
  search(right, middle, end, place, best);
  if (!left_first) search(left, begin, middle, place, best);
}

std::size_t NearestPoint::to(const Eigen::Vector3d& place) const {
  Best best{std::numeric_limits<double>::infinity(), order_.front()};
  search(0, 0, order_.size(), place, best);
  return best.index;
}

}  // namespace swept
