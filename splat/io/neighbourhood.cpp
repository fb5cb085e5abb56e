#include "splat/io/neighbourhood.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nanoflann.hpp>
#include <numeric>

#include <Eigen/Eigenvalues>

namespace swept {
namespace {

constexpr std::size_t kPlaneNeighbours = 12, kSpacingNeighbours = 6;

using Point = std::array<float, 3>;

/// The distinct points as the tree sees them. Differences of floats and their squares are taken in double,
/// where they do not underflow.
struct PointTable {
  std::vector<Point> points;

  // The names are nanoflann's.
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return static_cast<double>(points[i][axis]);
  }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointTable>,
                                                   PointTable, 3, std::size_t>;

/// The nearest points, nearest first; of equally near ones those that come first in the table. Which points
/// these are does not depend on how the tree is cut.
class Nearest {
 public:
  using DistanceType = double;

  explicit Nearest(std::size_t capacity) : capacity_(capacity) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t point(std::size_t n) const { return entries_[n + 1].point; }
  [[nodiscard]] double squared_distance(std::size_t n) const { return entries_[n + 1].squared_distance; }

  // What nanoflann calls, by its names.
  [[nodiscard]] bool full() const { return size_ == capacity_; }
  [[nodiscard]] double worstDist() const {
    // The tree passes over what is not nearer than this. It has to see what is as near, and its own sums are
    // good to a few ulp.
    return full() ? entries_[size_].squared_distance * (1.0 + 1e-12) + kLeast
                  : std::numeric_limits<double>::max();
  }
  bool addPoint(double squared_distance, std::size_t point) {
    const Entry entry{squared_distance, point};
    std::size_t at = size_ + 1;  // behind all others, and in no one's way if they stay
    for (; before(entry, entries_[at - 1]); --at) entries_[at] = entries_[at - 1];
    entries_[at] = entry;
    size_ = std::min(size_ + 1, capacity_);
    return true;
  }
  void sort() {}  // newer versions ask for it

 private:
  struct Entry {
    double squared_distance = -1.0;
    std::size_t point = 0;
  };
  static bool before(const Entry& a, const Entry& b) {
    return a.squared_distance < b.squared_distance ||
           (a.squared_distance == b.squared_distance && a.point < b.point);
  }
  static constexpr double kLeast = std::numeric_limits<double>::min();

  std::array<Entry, kPlaneNeighbours + 3> entries_;  // the first is nearer than any point, and stays
  std::size_t capacity_, size_ = 0;
};

/// Where the points are moved to and scaled from: their centroid, and their extent from it along an axis.
struct Frame {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double scale = 1.0;

  /// Halves first: the difference of two finite numbers need not be finite.
  [[nodiscard]] Eigen::Vector3d local(const Eigen::Vector3d& p) const {
    return (0.5 * p - 0.5 * center) / (0.5 * scale);
  }
};

/// The sums are of integers, and so the same for every order of the points.
Frame frame_of(const std::vector<Eigen::Vector3d>& positions) {
  Eigen::Vector3d low = positions.front(), high = low;
  for (const Eigen::Vector3d& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3d half = 0.5 * high - 0.5 * low;
  Frame frame;
  double half_extent = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    frame.center[axis] = low[axis];
    if (!(half[axis] > 0.0)) continue;
    std::uint64_t sum = 0;  // fewer than 2³² points
    for (const Eigen::Vector3d& p : positions) {
      sum += static_cast<std::uint64_t>(0x1p31 * ((0.5 * p[axis] - 0.5 * low[axis]) / half[axis]));
    }
    const double mean = 0x1p-31 * static_cast<double>(sum) / static_cast<double>(positions.size());
    frame.center[axis] += half[axis] * mean;
    frame.center[axis] += half[axis] * mean;
    const double c = 0.5 * frame.center[axis];
    half_extent = std::max({half_extent, 0.5 * high[axis] - c, c - 0.5 * low[axis]});
  }
  if (half_extent > 0.0) frame.scale = 2.0 * half_extent;
  return frame;
}

}  // namespace

struct Neighbourhood::Tree {
  PointTable distinct;                   ///< in lexicographic order, in [-1, 1]
  std::vector<std::size_t> distinct_of;  ///< for each position, its entry of `distinct`
  double scale = 1.0;                    ///< object units per unit of `distinct`
  std::unique_ptr<KdTree> search;
};

Neighbourhood::Neighbourhood(const std::vector<Eigen::Vector3d>& positions)
    : tree_(std::make_unique<Tree>()) {
  if (positions.empty()) return;
  const Frame frame = frame_of(positions);
  tree_->scale = frame.scale;
  std::vector<Point> local;
  local.reserve(positions.size());
  for (const Eigen::Vector3d& p : positions) {
    const Eigen::Vector3f q = frame.local(p).cast<float>();
    local.push_back({q.x(), q.y(), q.z()});
  }
  std::vector<std::size_t> order(positions.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return local[a] < local[b]; });
  std::vector<Point>& distinct = tree_->distinct.points;
  tree_->distinct_of.resize(positions.size());
  for (const std::size_t i : order) {
    if (distinct.empty() || distinct.back() != local[i]) distinct.push_back(local[i]);
    tree_->distinct_of[i] = distinct.size() - 1;
  }
  tree_->search = std::make_unique<KdTree>(3, tree_->distinct);
  tree_->search->buildIndex();
}

Neighbourhood::~Neighbourhood() = default;

LocalFit Neighbourhood::fit(std::size_t i) const {
  const std::vector<Point>& points = tree_->distinct.points;
  const auto at = [&](std::size_t n) {
    return Eigen::Map<const Eigen::Vector3f>(points[n].data()).cast<double>();
  };
  const Eigen::Vector3d self = at(tree_->distinct_of[i]);
  Nearest nearest(std::min(kPlaneNeighbours + 1, points.size()));
  tree_->search->findNeighbors(nearest, self.data(), {});

  LocalFit fit{Eigen::Vector3d::UnitZ(), 0.0};
  // The nearest is the point itself.
  const std::size_t count = std::min(nearest.size(), kSpacingNeighbours + 1);
  for (std::size_t n = 1; n < count; ++n) fit.spacing += std::sqrt(nearest.squared_distance(n));
  if (count > 1) fit.spacing *= tree_->scale / static_cast<double>(count - 1);

  if (nearest.size() < 3) return fit;
  std::array<Eigen::Vector3d, kPlaneNeighbours + 1> edge;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t n = 0; n < nearest.size(); ++n) {
    edge[n] = at(nearest.point(n)) - self;
    mean += edge[n];
  }
  mean /= static_cast<double>(nearest.size());
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  for (std::size_t n = 0; n < nearest.size(); ++n) {
    moment += (edge[n] - mean) * (edge[n] - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moment);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  if (solver.info() == Eigen::Success && normal.allFinite()) fit.normal = normal.normalized();
  return fit;
}

}  // namespace swept
