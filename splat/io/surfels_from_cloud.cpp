#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "splat/io/check_points.h"
#include "splat/io/guarded.h"
#include "splat/io/neighbourhood.h"
#include "splat/io/surfel_estimate.h"

namespace swept {
namespace {

constexpr double kMostTimesMedian = 10.0;

/// Holds radii to a multiple of their median; the number of those it shortens.
std::size_t shorten_outliers(std::vector<double>& radii) {
  std::vector<double> sorted = radii;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double most = kMostTimesMedian * *middle;
  std::size_t shortened = 0;
  for (double& radius : radii) {
    if (radius <= most) continue;
    radius = most;
    ++shortened;
  }
  return shortened;
}

}  // namespace

Result<EstimatedSurfels> surfels_from_cloud(const PointSet& points) {
  return io::guarded("", [&]() -> Result<EstimatedSurfels> {
    if (Status s = points.validate(); !s) return s.error();
    const std::size_t count = points.size();
    EstimatedSurfels surfels;
    std::vector<Eigen::Vector3d> normals(count, Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < points.normal.size(); ++i) normals[i] = points.normal[i].cast<double>();
    for (std::size_t i = 0; i < count; ++i) {
      if (normals[i].isZero(0.0)) surfels.unoriented.push_back(i);
    }
    std::vector<double> radii(points.radius.begin(), points.radius.end());

    surfels.oriented = true;
    std::optional<Neighbourhood> neighbourhood;
    if (radii.empty() || !surfels.unoriented.empty()) neighbourhood.emplace(points.position);
    if (radii.empty()) {
      for (std::size_t i = 0; i < count; ++i) {
        const LocalFit fit = neighbourhood->fit(i);
        if (!(fit.spacing > 0.0)) {
          return Error{"", "radius",
                       "the file gives none, and all points coincide, so none can be estimated; \"radius\" "
                       "of an object says it"};
        }
        radii.push_back(kRadiusPerSpacing * fit.spacing);
        if (normals[i].isZero(0.0)) normals[i] = fit.normal;
      }
      surfels.notes.push_back("radii estimated from the distance of the 6 nearest points");
      if (const std::size_t shortened = shorten_outliers(radii); shortened > 0) {
        surfels.notes.push_back(std::to_string(shortened) + " radii shortened to 10 times the median");
      }
    } else {
      for (const std::size_t i : surfels.unoriented) normals[i] = neighbourhood->fit(i).normal;
    }
    if (!surfels.unoriented.empty()) {
      surfels.notes.push_back(
          "normals of " + std::to_string(surfels.unoriented.size()) +
          " points estimated from the 12 nearest points; which side is front is not known");
    }

    surfels.pose.position = points.position;
    surfels.pose.axis_u.resize(count);
    surfels.pose.axis_v.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      round_disc(normals[i], radii[i], surfels.pose.axis_u[i], surfels.pose.axis_v[i]);
    }
    if (Status s = check_axes(surfels.pose); !s) return s.error();
    return surfels;
  });
}

}  // namespace swept
