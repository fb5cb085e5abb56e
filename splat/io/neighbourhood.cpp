#include "splat/io/neighbourhood.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <pcl/features/normal_3d.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

namespace swept {
namespace {

constexpr int kPlaneNeighbours = 12, kSpacingNeighbours = 6;

bool less(const pcl::PointXYZ& a, const pcl::PointXYZ& b) {
  return std::lexicographical_compare(a.data, a.data + 3, b.data, b.data + 3);
}
bool same(const pcl::PointXYZ& a, const pcl::PointXYZ& b) { return std::equal(a.data, a.data + 3, b.data); }

}  // namespace

struct Neighbourhood::Tree {
  pcl::PointCloud<pcl::PointXYZ>::Ptr points{new pcl::PointCloud<pcl::PointXYZ>};  ///< distinct, in [-1, 1]
  std::vector<pcl::index_t> distinct_of;  ///< for each position, its entry of `points`
  double scale = 1.0;                     ///< object units per unit of `points`
  pcl::search::KdTree<pcl::PointXYZ> search;
};

Neighbourhood::Neighbourhood(const std::vector<Eigen::Vector3d>& positions)
    : tree_(std::make_unique<Tree>()) {
  if (positions.empty()) return;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : positions) center += p;
  center /= static_cast<double>(positions.size());
  double extent = 0.0;
  for (const Eigen::Vector3d& p : positions) extent = std::max(extent, (p - center).cwiseAbs().maxCoeff());
  tree_->scale = extent > 0.0 ? extent : 1.0;

  std::vector<pcl::PointXYZ> local;
  local.reserve(positions.size());
  for (const Eigen::Vector3d& p : positions) {
    const Eigen::Vector3f q = ((p - center) / tree_->scale).cast<float>();
    local.emplace_back(q.x(), q.y(), q.z());
  }
  std::vector<std::size_t> order(positions.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return less(local[a], local[b]); });
  tree_->distinct_of.resize(positions.size());
  for (const std::size_t i : order) {
    if (tree_->points->empty() || !same(tree_->points->back(), local[i])) tree_->points->push_back(local[i]);
    tree_->distinct_of[i] = static_cast<pcl::index_t>(tree_->points->size() - 1);
  }
  tree_->search.setInputCloud(tree_->points);
}

Neighbourhood::~Neighbourhood() = default;

LocalFit Neighbourhood::fit(std::size_t i) const {
  const pcl::index_t self = tree_->distinct_of[i];
  const auto available = static_cast<int>(tree_->points->size());
  pcl::Indices nearest;
  std::vector<float> squared;
  tree_->search.nearestKSearch(self, std::min(kPlaneNeighbours + 1, available), nearest, squared);

  LocalFit fit{Eigen::Vector3d::UnitZ(), 0.0};
  // Nearest first, and the nearest is the point itself.
  const std::size_t count = std::min<std::size_t>(nearest.size(), kSpacingNeighbours + 1);
  for (std::size_t n = 1; n < count; ++n) fit.spacing += std::sqrt(static_cast<double>(squared[n]));
  if (count > 1) fit.spacing *= tree_->scale / static_cast<double>(count - 1);

  Eigen::Vector4f plane = Eigen::Vector4f::Zero();
  float curvature = 0.0f;
  if (pcl::computePointNormal(*tree_->points, nearest, plane, curvature)) {
    const Eigen::Vector3d normal = plane.head<3>().cast<double>();
    if (normal.allFinite() && normal.norm() > 0.5) fit.normal = normal.normalized();
  }
  return fit;
}

}  // namespace swept
