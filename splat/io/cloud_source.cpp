#include "splat/io/cloud_source.h"

#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "splat/io/surfel_estimate.h"

namespace swept {
namespace {

Error option_error(const std::string& field, const std::string& reason) { return {"", field, reason}; }

Status check_options(const CloudSource& source) {
  const auto positive = [](double x) { return x > 0.0 && std::isfinite(x); };
  if (source.radius && !positive(*source.radius)) {
    return option_error("radius", "must be positive and finite");
  }
  if (!positive(source.radius_scale)) return option_error("radius_scale", "must be positive and finite");
  if (source.color && !source.color->allFinite()) return option_error("color", "must be finite");
  if (source.fps.numerator < 1 || source.fps.denominator < 1) {
    return option_error("fps", "must be two numbers ≥ 1");
  }
  return Done{};
}

Status check_files(const CloudSource& source) {
  if (source.files.empty()) return option_error("files", "names no file");
  for (std::size_t k = 0; k < source.files.size(); ++k) {
    if (!std::isfinite(source.files[k].frame) ||
        (k > 0 && !(source.files[k - 1].frame < source.files[k].frame))) {
      return Error{source.files[k].path, "frame", "the frames of the files must be finite and increase"};
    }
  }
  if (source.skip_invalid && source.files.size() > 1) {
    return option_error("skip_invalid",
                        "cannot be used with several files: dropping points from one "
                        "would pair the rest with the wrong points of the next");
  }
  return Done{};
}

/// Discs by the best the set has to offer: its own axes, else its triangles, else its nearest points.
Result<EstimatedSurfels> discs_of(PointSet& set, const CloudSource& source) {
  if (source.radius) set.radius.assign(set.size(), static_cast<float>(*source.radius));
  Result<EstimatedSurfels> discs = EstimatedSurfels{};
  if (!set.axis_u.empty()) {
    discs->pose = {set.position, std::move(set.axis_u), std::move(set.axis_v)};
  } else if (!set.triangle.empty()) {
    discs = surfels_from_mesh(set.position, set.triangle);
  } else {
    discs = surfels_from_cloud(set);
  }
  if (!discs) return discs;
  SurfelPose& pose = discs->pose;
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!set.radius.empty()) {
      const Eigen::Vector3d n = pose.axis_u[i].cast<double>().cross(pose.axis_v[i].cast<double>());
      if (!n.isZero(0.0)) round_disc(n, static_cast<double>(set.radius[i]), pose.axis_u[i], pose.axis_v[i]);
    }
    pose.axis_u[i] = (source.radius_scale * pose.axis_u[i].cast<double>()).cast<float>();
    pose.axis_v[i] = (source.radius_scale * pose.axis_v[i].cast<double>()).cast<float>();
  }
  return discs;
}

/// Gives guessed sides the side they have in `reference`: else the disc would turn over between the keys.
void keep_sides(const SurfelPose& reference, EstimatedSurfels& discs) {
  for (const std::size_t i : discs.unoriented) {
    Eigen::Vector3f &u = discs.pose.axis_u[i], &v = discs.pose.axis_v[i];
    if (u.cross(v).dot(reference.axis_u[i].cross(reference.axis_v[i])) < 0.0f) std::swap(u, v);
  }
}

void take_velocity(PointSet& set, const CloudSource& source, LoadedCloud& loaded) {
  if (set.velocity.empty() || source.velocity_unit == VelocityUnit::ignore) return;
  loaded.cloud.velocity = std::move(set.velocity);
  if (source.velocity_unit == VelocityUnit::per_frame) return;
  const double frame_seconds =
      static_cast<double>(source.fps.denominator) / static_cast<double>(source.fps.numerator);
  for (Eigen::Vector3f& v : loaded.cloud.velocity) v = (frame_seconds * v.cast<double>()).cast<float>();
}

/// The rest of what the first key says, after its discs are taken.
Result<LoadedCloud> first_key(PointSet set, double frame, const CloudSource& source) {
  Result<EstimatedSurfels> discs = discs_of(set, source);
  if (!discs) return discs.error();
  LoadedCloud loaded;
  loaded.cloud.keys.push_back({frame, std::move(discs->pose)});
  loaded.notes = std::move(set.notes);
  loaded.notes.insert(loaded.notes.end(), discs->notes.begin(), discs->notes.end());
  loaded.cloud.color = std::move(set.color);
  if (source.color) loaded.cloud.color.assign(loaded.cloud.size(), *source.color);
  if (source.color_by_normals) {
    if (Status s = color_by_normals(loaded.cloud); !s) return s.error();
  }
  loaded.cloud.opacity = std::move(set.opacity);
  take_velocity(set, source, loaded);
  return loaded;
}

ReadOptions read_options(const CloudSource& source) {
  ReadOptions options;
  options.attributes = source.attributes;
  options.delta = source.delta;
  options.skip_invalid = source.skip_invalid;
  // Several keys say themselves how the points move.
  if (source.velocity_unit == VelocityUnit::ignore || source.files.size() > 1) {
    options.attributes["velocity"] = "";
  }
  return options;
}

Error in_file(Error error, const std::string& path) {
  if (error.file.empty()) error.file = path;
  return error;
}

Error counts_differ(const std::string& what, const KeyFile& a, std::size_t in_a, const KeyFile& b,
                    std::size_t in_b) {
  return {b.path, what,
          "has " + std::to_string(in_b) + " where " + a.path + " has " + std::to_string(in_a) +
              "; keys must be the same points in the same order, write them out by id, or use one file with "
              "velocities"};
}

/// Reads a later key and joins it to those before. `triangles` and `first` are those of the first.
Status add_key(const CloudSource& source, const KeyFile& first, const KeyFile& file,
               std::vector<std::array<std::uint32_t, 3>>& triangles, SurfelCloud& cloud) {
  Result<PointSet> set = read_points(file.path, read_options(source));
  if (!set) return set.error();
  if (set->size() != cloud.size()) {
    return counts_differ("points", first, cloud.size(), file, set->size());
  }
  if (set->triangle.size() != triangles.size()) {
    return counts_differ("triangles", first, triangles.size(), file, set->triangle.size());
  }
  const SurfelPose& before = cloud.keys.back().pose;
  std::swap(set->triangle, triangles);
  Result<EstimatedSurfels> discs = discs_of(*set, source);
  std::swap(set->triangle, triangles);
  if (!discs) return in_file(discs.error(), file.path);
  keep_sides(before, *discs);
  align_axes(before, discs->pose);
  cloud.keys.push_back({file.frame, std::move(discs->pose)});
  return Done{};
}

}  // namespace

Status color_by_normals(SurfelCloud& cloud) {
  if (Status s = cloud.validate(); !s) return s;
  if (cloud.keys.empty()) return option_error("keys", "the cloud has none");
  const SurfelPose& pose = cloud.keys.front().pose;
  cloud.color.resize(pose.size());
  for (std::size_t i = 0; i < pose.size(); ++i) {
    // In double, where the product of tiny axes does not underflow.
    const Eigen::Vector3d normal =
        pose.axis_u[i].cast<double>().cross(pose.axis_v[i].cast<double>()).normalized();
    cloud.color[i] = (0.5 * (normal + Eigen::Vector3d::Ones())).cast<float>();
  }
  return Done{};
}

Result<LoadedCloud> cloud_from_points(PointSet points, double frame, const CloudSource& source) {
  if (Status s = check_options(source); !s) return s.error();
  if (!std::isfinite(frame)) return option_error("frame", "is not finite");
  if (Status s = points.validate(); !s) return s.error();
  Result<LoadedCloud> loaded = first_key(std::move(points), frame, source);
  if (!loaded) return loaded;
  if (Status s = loaded->cloud.validate(); !s) return s.error();
  return loaded;
}

Result<LoadedCloud> read_cloud(const CloudSource& source, double first, double last) {
  if (Status s = check_options(source); !s) return s.error();
  if (Status s = check_files(source); !s) return s.error();
  if (!(first <= last)) return option_error("frames", "the interval to cover runs backwards");

  const std::vector<KeyFile>& files = source.files;
  std::size_t begin = 0, end = files.size();
  while (begin + 1 < end && files[begin + 1].frame <= first) ++begin;
  while (end > begin + 1 && files[end - 2].frame >= last) --end;

  Result<PointSet> set = read_points(files[begin].path, read_options(source));
  if (!set) return set.error();
  std::vector<std::array<std::uint32_t, 3>> triangles;
  if (files.size() > 1) triangles = set->triangle;
  Result<LoadedCloud> loaded = first_key(*std::move(set), files[begin].frame, source);
  if (!loaded) return in_file(loaded.error(), files[begin].path);
  for (std::string& note : loaded->notes) note = files[begin].path + ": " + note;
  for (std::size_t k = begin + 1; k < end; ++k) {
    if (Status s = add_key(source, files[begin], files[k], triangles, loaded->cloud); !s) return s.error();
  }
  if (Status s = loaded->cloud.validate(); !s) return in_file(s.error(), files[begin].path);
  return loaded;
}

}  // namespace swept
