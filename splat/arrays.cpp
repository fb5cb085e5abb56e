#include "splat/arrays.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "splat/without_throwing.h"

namespace swept {
namespace {

Error lacks(const std::string& array, const char* reason) { return Error{"", array, reason}; }

Error at(const char* array, std::size_t i, const char* reason) {
  return Error{"", std::string(array) + "[" + std::to_string(i) + "]", reason};
}

template <class T>
Status check_count(const std::string& name, const Strided<T>& array, std::size_t expected) {
  if (array.count > 0 && array.data == nullptr) return lacks(name, "has entries, and is nowhere");
  if (array.empty() || array.count == expected) return Done{};
  return Error{"", name,
               "has " + std::to_string(array.count) + " entries for " + std::to_string(expected) + " points"};
}

template <class T>
bool aligned(const Strided<T>& array) {
  const auto bytes = static_cast<std::ptrdiff_t>(alignof(T));
  return reinterpret_cast<std::uintptr_t>(array.data) % alignof(T) == 0 && array.stride_bytes % bytes == 0;
}

/// A view where that can be read in place.
template <class T>
PointArray<T> column_of(const Strided<T>& array) {
  if (array.empty()) return {};
  if (aligned(array)) return PointArray<T>::view(array);
  std::vector<T> values(array.count);
  const char* from = reinterpret_cast<const char*>(array.data);
  for (std::size_t i = 0; i < array.count; ++i)
    std::memcpy(static_cast<void*>(&values[i]), from + static_cast<std::ptrdiff_t>(i) * array.stride_bytes,
                sizeof(T));
  return values;
}

template <class Arrays>
Result<PointArray<Eigen::Vector3d>> positions_of(const Arrays& arrays) {
  if (arrays.position.empty() == arrays.position_single.empty())
    return lacks("position", arrays.position.empty() ? "is missing, or has no points" : "is given twice");
  if (!arrays.position.empty()) {
    if (Status status = check_count("position", arrays.position, arrays.position.count); !status)
      return status.error();
    return column_of(arrays.position);
  }
  if (Status status = check_count("position_single", arrays.position_single, arrays.position_single.count);
      !status)
    return status.error();
  const PointArray<Eigen::Vector3f> single = column_of(arrays.position_single);
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(single.size());
  for (const Eigen::Vector3f& position : single) positions.push_back(position.cast<double>());
  return PointArray<Eigen::Vector3d>(std::move(positions));
}

template <class Arrays>
Result<PointArray<Eigen::Vector3f>> velocities_of(const Arrays& arrays, std::size_t points) {
  if (Status status = check_count("velocity_per_frame", arrays.velocity_per_frame, points); !status)
    return status.error();
  if (Status status = check_count("velocity_per_second", arrays.velocity_per_second, points); !status)
    return status.error();
  if (arrays.velocity_per_second.empty()) return column_of(arrays.velocity_per_frame);
  if (!arrays.velocity_per_frame.empty())
    return lacks("velocity_per_second", "is given, and velocity_per_frame too");
  if (!(std::isfinite(arrays.frames_per_second) && arrays.frames_per_second > 0.0))
    return lacks("frames_per_second", "must be a finite number above 0");
  // As files are read: the factor in double precision, each product rounded once.
  const double seconds = 1.0 / arrays.frames_per_second;
  const PointArray<Eigen::Vector3f> given = column_of(arrays.velocity_per_second);
  std::vector<Eigen::Vector3f> velocities;
  velocities.reserve(points);
  for (const Eigen::Vector3f& velocity : given)
    velocities.push_back((seconds * velocity.cast<double>()).cast<float>());
  return PointArray<Eigen::Vector3f>(std::move(velocities));
}

Status add_axes(const SurfelArrays& arrays, SurfelPose& pose) {
  const std::size_t points = pose.position.size();
  if (!arrays.axis_u.empty() || !arrays.axis_v.empty()) {
    if (!arrays.normal.empty() || !arrays.radius.empty())
      return lacks("axis_u", "and axis_v are given, and a normal or a radius too");
    if (arrays.axis_u.empty()) return lacks("axis_u", "is missing: a disc has two axes");
    if (arrays.axis_v.empty()) return lacks("axis_v", "is missing: a disc has two axes");
    if (Status status = check_count("axis_u", arrays.axis_u, points); !status) return status;
    if (Status status = check_count("axis_v", arrays.axis_v, points); !status) return status;
    pose.axis_u = column_of(arrays.axis_u);
    pose.axis_v = column_of(arrays.axis_v);
    return Done{};
  }
  if (arrays.normal.empty()) return lacks("normal", "is missing, and so are axis_u and axis_v");
  if (arrays.radius.empty()) return lacks("radius", "is missing, and so are axis_u and axis_v");
  if (Status status = check_count("normal", arrays.normal, points); !status) return status;
  if (arrays.radius.count != 1)
    if (Status status = check_count("radius", arrays.radius, points); !status) return status;
  const PointArray<Eigen::Vector3f> normals = column_of(arrays.normal);
  const PointArray<float> radii = column_of(arrays.radius);
  std::vector<Eigen::Vector3f> axis_u(points), axis_v(points);
  for (std::size_t i = 0; i < points; ++i) {
    const Eigen::Vector3d normal = std::as_const(normals)[i].cast<double>();
    const float radius = std::as_const(radii)[radii.size() == 1 ? 0 : i];
    if (!normal.allFinite() || normal.isZero(0.0)) return at("normal", i, "must be finite and not zero");
    if (!(std::isfinite(radius) && radius >= 0.0f)) return at("radius", i, "must be finite and not negative");
    round_disc(normal, static_cast<double>(radius), axis_u[i], axis_v[i]);
  }
  pose.axis_u = std::move(axis_u);
  pose.axis_v = std::move(axis_v);
  return Done{};
}

Status add_looks(const SurfelArrays& arrays, SurfelCloud& cloud) {
  const std::size_t points = cloud.size();
  if (!arrays.looks.empty() && !arrays.color.empty()) return lacks("color", "is given, and looks too");
  if (!arrays.looks.empty() && !arrays.opacity.empty()) return lacks("opacity", "is given, and looks too");
  if (Status status = check_count("color", arrays.color, points); !status) return status;
  if (Status status = check_count("opacity", arrays.opacity, points); !status) return status;
  cloud.color = column_of(arrays.color);
  cloud.opacity = column_of(arrays.opacity);
  for (std::size_t k = 0; k < arrays.looks.size(); ++k) {
    const LookArrays& look = arrays.looks[k];
    const std::string name = "looks[" + std::to_string(k) + "].";
    if (Status status = check_count(name + "color", look.color, points); !status) return status;
    if (Status status = check_count(name + "opacity", look.opacity, points); !status) return status;
    cloud.looks.push_back({look.frame, column_of(look.color), column_of(look.opacity)});
  }
  return Done{};
}

Result<SurfelCloud> cloud_of(const SurfelArrays& arrays) {
  Result<PointArray<Eigen::Vector3d>> positions = positions_of(arrays);
  if (!positions) return positions.error();
  const std::size_t points = positions->size();
  SurfelCloud cloud;
  cloud.keys.resize(1);
  cloud.keys[0].frame = arrays.frame;
  cloud.keys[0].pose.position = *std::move(positions);
  if (Status status = add_axes(arrays, cloud.keys[0].pose); !status) return status.error();
  Result<PointArray<Eigen::Vector3f>> velocities = velocities_of(arrays, points);
  if (!velocities) return velocities.error();
  cloud.velocity = *std::move(velocities);
  if (Status status = add_looks(arrays, cloud); !status) return status.error();
  if (arrays.oriented) cloud.oriented.assign(points, 1);
  if (Status status = cloud.validate(); !status) return status.error();
  return cloud;
}

Result<SplatCloud> splats_of(const SplatArrays& arrays) {
  Result<PointArray<Eigen::Vector3d>> positions = positions_of(arrays);
  if (!positions) return positions.error();
  const std::size_t splats = positions->size();
  SplatCloud cloud;
  cloud.position = *std::move(positions);
  if (Status status = check_count("scale", arrays.scale, splats); !status) return status.error();
  if (Status status = check_count("rotation_wxyz", arrays.rotation_wxyz, splats); !status)
    return status.error();
  if (Status status = check_count("opacity", arrays.opacity, splats); !status) return status.error();
  if (arrays.harmonics.count > 0 && arrays.harmonics.data == nullptr)
    return lacks("harmonics", "has entries, and is nowhere");
  cloud.scale = column_of(arrays.scale);
  cloud.opacity = column_of(arrays.opacity);
  cloud.degree = arrays.degree;
  cloud.harmonics = column_of(arrays.harmonics);
  if (!std::as_const(cloud.harmonics).contiguous()) cloud.harmonics.own();

  std::vector<Eigen::Quaternionf> rotations;
  rotations.reserve(splats);
  const char* from = reinterpret_cast<const char*>(arrays.rotation_wxyz.data);
  for (std::size_t i = 0; i < arrays.rotation_wxyz.count; ++i) {
    float q[4];
    std::memcpy(q, from + static_cast<std::ptrdiff_t>(i) * arrays.rotation_wxyz.stride_bytes, sizeof q);
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    if (!rotation.coeffs().allFinite() || rotation.coeffs().isZero(0.0))
      return at("rotation_wxyz", i, "must be finite and not zero");
    rotations.push_back(rotation.normalized().cast<float>());
  }
  cloud.rotation = std::move(rotations);

  Result<PointArray<Eigen::Vector3f>> velocities = velocities_of(arrays, splats);
  if (!velocities) return velocities.error();
  cloud.velocity = *std::move(velocities);
  cloud.frame = arrays.frame;
  cloud.filter = arrays.filter;
  cloud.colors = arrays.colors;
  if (Status status = cloud.validate(); !status) return status.error();
  return cloud;
}

}  // namespace

Result<SurfelCloud> cloud_from_arrays(const SurfelArrays& arrays) noexcept {
  return without_throwing("for the cloud", [&] { return cloud_of(arrays); });
}

Result<SplatCloud> splats_from_arrays(const SplatArrays& arrays) noexcept {
  return without_throwing("for the splats", [&] { return splats_of(arrays); });
}

}  // namespace swept
