#include "splat/io/check_points.h"

#include <limits>
#include <utility>

#include "splat/io/guarded.h"
#include "splat/io/point_file.h"

namespace swept {
namespace {

std::string indexed(const std::string& array, std::size_t i) { return array + "[" + std::to_string(i) + "]"; }

/// An optional array of vectors: none, or one finite one per point.
template <class Vector>
Status check_vectors(const std::string& name, const std::vector<Vector>& array, std::size_t points) {
  if (array.empty()) return Done{};
  if (array.size() != points) return wrong_count(name, array.size(), points);
  for (std::size_t i = 0; i < points; ++i) {
    if (!array[i].allFinite()) return Error{"", indexed(name, i), "is not finite"};
  }
  return Done{};
}

/// An optional array of numbers: none, or one in [0, most] per point.
Status check_numbers(const std::string& name, const std::vector<float>& array, std::size_t points, float most,
                     const char* reason) {
  if (array.empty()) return Done{};
  if (array.size() != points) return wrong_count(name, array.size(), points);
  for (std::size_t i = 0; i < points; ++i) {
    // Written so that NaN fails it too.
    if (!(array[i] >= 0.0f && array[i] <= most)) return Error{"", indexed(name, i), reason};
  }
  return Done{};
}

}  // namespace

Error wrong_count(const std::string& array, std::size_t found, std::size_t points) {
  return {"", array,
          "has " + std::to_string(found) + " entries where there are " + std::to_string(points) + " points"};
}

Status check_positions(const std::vector<Eigen::Vector3d>& positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!positions[i].allFinite()) return Error{"", indexed("position", i), "is not finite"};
  }
  return Done{};
}

Status check_triangles(const std::vector<std::array<std::uint32_t, 3>>& triangles, std::size_t points) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const std::uint32_t corner : triangles[t]) {
      if (corner < points) continue;
      return Error{"", indexed("triangle", t),
                   "has the corner " + std::to_string(corner) + " where there are " + std::to_string(points) +
                       " points, the first of them 0"};
    }
  }
  return Done{};
}

Status check_axes(const SurfelPose& pose) {
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (pose.axis_u[i].allFinite() && pose.axis_v[i].allFinite()) continue;
    return Error{"", "radius", "of point " + std::to_string(i) + " would be beyond the range of float"};
  }
  return Done{};
}

Status PointSet::validate() const {
  return io::guarded("", [&]() -> Status {
    const std::size_t n = size();
    if (n == 0) return Error{"", "position", "has no entries: there are no points"};
    if (Status s = check_positions(position); !s) return s;
    if (axis_u.empty() != axis_v.empty()) {
      return Error{"", axis_u.empty() ? "axis_u" : "axis_v", "is missing: a disc has two axes"};
    }
    for (const auto& [name, array] : {std::pair{"normal", &normal},
                                      {"axis_u", &axis_u},
                                      {"axis_v", &axis_v},
                                      {"color", &color},
                                      {"velocity", &velocity},
                                      {"acceleration", &acceleration},
                                      {"angular_velocity", &angular_velocity}}) {
      if (Status s = check_vectors(name, *array, n); !s) return s;
    }
    if (Status s =
            check_numbers("radius", radius, n, std::numeric_limits<float>::max(), "must be finite and ≥ 0");
        !s) {
      return s;
    }
    if (Status s = check_numbers("opacity", opacity, n, 1.0f, "must lie in [0, 1]"); !s) return s;
    if (!time.empty() && time.size() != n) return wrong_count("time", time.size(), n);
    for (std::size_t i = 0; i < time.size(); ++i)
      if (!std::isfinite(time[i])) return Error{"", "time[" + std::to_string(i) + "]", "is not finite"};
    if (!id.empty() && id.size() != n) return wrong_count("id", id.size(), n);
    if (!texture_corners.empty() && texture_corners.size() != triangle.size())
      return Error{"", "texture_corners",
                   "has " + std::to_string(texture_corners.size()) + " entries where there are " +
                       std::to_string(triangle.size()) + " triangles"};
    if (!corner_normals.empty() && corner_normals.size() != triangle.size())
      return Error{"", "corner_normals",
                   "has " + std::to_string(corner_normals.size()) + " entries where there are " +
                       std::to_string(triangle.size()) + " triangles"};
    return check_triangles(triangle, n);
  });
}

}  // namespace swept
