#include "splat/io/cloud_source.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "splat/io/cloud_keys.h"
#include "splat/io/empty_files.h"
#include "splat/io/guarded.h"
#include "splat/io/match_points.h"
#include "splat/io/mesh_creases.h"
#include "splat/io/mesh_normals.h"
#include "splat/io/normal_looks.h"
#include "splat/io/sequence_ends.h"
#include "splat/io/sequence_looks.h"
#include "splat/io/surfel_estimate.h"

namespace swept {
namespace {

/// Gives guessed sides the side they have in `reference`: else the disc would turn over between the keys.
void keep_sides(const SurfelPose& reference, EstimatedSurfels& discs) {
  for (const std::size_t i : discs.unoriented) {
    Eigen::Vector3f &u = discs.pose.axis_u[i], &v = discs.pose.axis_v[i];
    if (u.cross(v).dot(reference.axis_u[i].cross(reference.axis_v[i])) < 0.0f) std::swap(u, v);
  }
}

void leave_rates(ReadOptions& options) {
  for (const char* rate : {"velocity", "acceleration", "angular_velocity"}) options.attributes[rate] = "";
}

ReadOptions read_options(const CloudSource& source) {
  ReadOptions options;
  options.texture = source.texture;
  options.corner_normals = source.triangles;
  options.split_normals = source.triangles && source.crease_angle;
  options.materials = source.materials;
  options.attributes = source.attributes;
  options.delta = source.delta;
  options.skip_invalid = source.skip_invalid;
  options.color_range = source.color_range;
  options.color_space = source.color_space;
  if (source.velocity_unit == VelocityUnit::ignore) leave_rates(options);
  options.stamps = source.stamps.has_value();
  return options;
}

/// Several keys say themselves how the points move.
ReadOptions key_options(const CloudSource& source) {
  ReadOptions options = read_options(source);
  if (source.files.size() > 1) leave_rates(options);
  return options;
}

}  // namespace

namespace io {

Result<EstimatedSurfels> discs_of(PointSet& set, const CloudSource& source) {
  if (source.radius) set.radius.assign(set.size(), static_cast<float>(*source.radius));
  Result<EstimatedSurfels> discs = EstimatedSurfels{};
  if (!set.axis_u.empty()) {
    discs->pose = {set.position, std::move(set.axis_u), std::move(set.axis_v)};
  } else if (!set.triangle.empty()) {
    discs = surfels_from_mesh(set.position, set.triangle);
    if (discs && source.triangles) turn_along_normals(set, discs->pose);
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

double velocity_scale(const CloudSource& source) {
  if (source.velocity_unit == VelocityUnit::per_frame) return 1.0;
  return static_cast<double>(source.fps.denominator) / static_cast<double>(source.fps.numerator);
}

void push_key(EstimatedSurfels discs, double frame, SurfelCloud& cloud) {
  if (!cloud.keys.empty()) {
    keep_sides(cloud.keys.back().pose, discs);
    align_axes(cloud.keys.back().pose, discs.pose);
  }
  cloud.keys.push_back({frame, std::move(discs.pose)});
}

Result<PointSet> read_with_rates(const CloudSource& source, const KeyFile& file) {
  Result<PointSet> set = read_points(file.path, read_options(source));
  return set ? std::move(set) : read_points(file.path, key_options(source));
}

}  // namespace io

namespace {

using io::discs_of;
using io::KeySpan;
using io::push_key;
using io::velocity_scale;

Error option_error(const std::string& field, const std::string& reason) { return {"", field, reason}; }

Status check_options(const CloudSource& source) {
  const auto positive = [](double x) { return x > 0.0 && std::isfinite(x); };
  if (source.radius && !positive(*source.radius)) {
    return option_error("radius", "must be positive and finite");
  }
  if (!positive(source.radius_scale)) return option_error("radius_scale", "must be positive and finite");
  if (source.color && !source.color->allFinite()) return option_error("color", "must be finite");
  if (source.color_range && !positive(*source.color_range)) {
    return option_error("color_range", "must be positive and finite");
  }
  if (source.crease_angle && !(*source.crease_angle >= 0.0 && *source.crease_angle <= 180.0))
    return option_error("crease_angle", "must be between 0 and 180 degrees");
  if (source.stamps && source.files.size() > 1)
    return option_error("stamps", "belong to a single file, for points of several have the files' times");
  if (source.stamps && !std::isfinite(source.stamps->zero))
    return option_error("stamps", "zero is not finite");
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

/// Rates of change per frame, of which `order` time units are under the line.
std::vector<Eigen::Vector3f> per_frame(std::vector<Eigen::Vector3f> rates, int order,
                                       const CloudSource& source) {
  if (source.velocity_unit == VelocityUnit::per_frame) return rates;
  const double scale = std::pow(velocity_scale(source), order);
  for (Eigen::Vector3f& rate : rates) rate = (scale * rate.cast<double>()).cast<float>();
  return rates;
}

void take_velocity(PointSet& set, const CloudSource& source, LoadedCloud& loaded) {
  if (source.velocity_unit == VelocityUnit::ignore) return;
  loaded.cloud.acceleration = per_frame(std::move(set.acceleration), 2, source);
  loaded.cloud.angular_velocity = per_frame(std::move(set.angular_velocity), 1, source);
  if (set.velocity.empty()) {
    if (loaded.cloud.accelerates() || loaded.cloud.spins()) return;
    if (source.files.size() < 2)
      loaded.report.assumed.push_back("there are no velocities: the points stand still");
    return;
  }
  if (std::all_of(set.velocity.begin(), set.velocity.end(), [](const auto& v) { return v.isZero(0.0f); }))
    loaded.report.assumed.push_back("the velocities are all zero");
  loaded.cloud.velocity = std::move(set.velocity);
  if (source.velocity_unit == VelocityUnit::per_frame) {
    loaded.report.assumed.push_back("velocities are per frame");
    return;
  }
  std::string rate = std::to_string(source.fps.numerator);
  if (source.fps.denominator != 1) rate += "/" + std::to_string(source.fps.denominator);
  loaded.report.assumed.push_back("velocities are per second, at " + rate + " frames per second");
  const double frame_seconds = velocity_scale(source);
  for (Eigen::Vector3f& v : loaded.cloud.velocity) v = (frame_seconds * v.cast<double>()).cast<float>();
}

/// The rest of what the first key says, after its discs are taken.
Result<LoadedCloud> first_key(PointSet set, EstimatedSurfels discs, double frame, const CloudSource& source) {
  LoadedCloud loaded;
  loaded.report = std::move(set.report);
  if (source.triangles && !set.triangle.empty())
    if (std::string normals = io::what_normals_are(set); !normals.empty())
      loaded.report.assumed.push_back(std::move(normals));
  if (source.triangles && source.crease_angle) {
    for (const Eigen::Vector3f& normal : set.normal) loaded.smooth.push_back(normal.isZero(0.0f) ? 0 : 1);
    loaded.corner_normals = std::move(set.corner_normals);
  }
  loaded.cloud.keys.push_back({frame, std::move(discs.pose)});
  if (discs.oriented && discs.unoriented.size() < loaded.cloud.size()) {
    loaded.cloud.oriented.assign(loaded.cloud.size(), 1);
    for (const std::size_t i : discs.unoriented) loaded.cloud.oriented[i] = 0;
  }
  loaded.notes = std::move(set.notes);
  loaded.notes.insert(loaded.notes.end(), discs.notes.begin(), discs.notes.end());
  loaded.cloud.color = std::move(set.color);
  if (loaded.cloud.color.empty() && !source.color && !source.color_by_normals)
    loaded.report.assumed.push_back("there are no colours: white");
  if (source.color) loaded.cloud.color.assign(loaded.cloud.size(), *source.color);
  if (source.color_by_normals) {
    if (Status s = color_by_normals(loaded.cloud); !s) return s.error();
    // Of two guesses neighbours should make the same one. Vertices without triangles have made it already.
    const Eigen::Vector3f toward = source.normals_toward.stableNormalized().cast<float>();
    if (!set.triangle.empty()) discs.unoriented.clear();
    for (const std::size_t i : discs.unoriented)
      if (Eigen::Vector3f& color = loaded.cloud.color[i];
          (color - Eigen::Vector3f::Constant(0.5f)).dot(toward) < 0.0f)
        color = Eigen::Vector3f::Ones() - color;
  }
  loaded.cloud.opacity = std::move(set.opacity);
  loaded.triangles = std::move(set.triangle);
  loaded.texture_corners = std::move(set.texture_corners);
  loaded.materials = std::move(set.materials);
  take_velocity(set, source, loaded);
  if (source.stamps)
    if (Status s = io::take_stamps(set, source, loaded); !s) return s.error();
  return loaded;
}

Result<LoadedCloud> first_key(PointSet set, double frame, const CloudSource& source) {
  const bool normals_unused =
      !source.triangles && !set.triangle.empty() && !set.normal.empty() && set.axis_u.empty();
  Result<EstimatedSurfels> discs = discs_of(set, source);
  if (!discs) return discs.error();
  if (normals_unused)
    set.report.assumed.push_back("discs lie along the triangles, and the normals are not used");
  return first_key(std::move(set), *std::move(discs), frame, source);
}

Error in_file(Error error, const std::string& path) {
  if (error.file.empty()) {
    error.file = path;
    error.kind = in_a_file(error.kind);
  }
  return error;
}

Error counts_differ(const std::string& what, const KeyFile& a, std::size_t in_a, const KeyFile& b,
                    std::size_t in_b) {
  return {b.path, what,
          "has " + std::to_string(in_b) + " where " + a.path + " has " + std::to_string(in_a) +
              "; keys must be the same points in the same order, write them out by id, or use one file with "
              "velocities"};
}

KeySpan span_of(const std::vector<KeyFile>& files, double first, double last, KeyPath path) {
  KeySpan span{0, files.size(), 0};
  while (span.begin + 1 < span.end && files[span.begin + 1].frame <= first) ++span.begin;
  while (span.end > span.begin + 1 && files[span.end - 2].frame >= last) --span.end;
  const std::size_t begin = span.begin, end = span.end;
  const double middle = first + 0.5 * (last - first);
  span.nearest = span.begin;
  for (std::size_t k = begin; k < end; ++k) {
    if (std::abs(files[k].frame - middle) < std::abs(files[span.nearest].frame - middle)) span.nearest = k;
  }
  // A spline between two keys depends on those beside them; one that is held needs none.
  if (path == KeyPath::spline && end > begin + 1) {
    if (span.begin > 0) --span.begin;
    if (span.end < files.size()) ++span.end;
  }
  return span;
}

bool is_rate(const std::string& attribute) {
  return attribute == "velocity" || attribute == "acceleration" || attribute == "angular_velocity";
}

/// Rates apart, which are not always asked for.
void compare_reports(const ReadReport& other, const KeyFile& file, ReadReport& report) {
  std::vector<ReadReport::Use> a = report.used, b = other.used;
  for (auto* uses : {&a, &b}) std::erase_if(*uses, [](const auto& use) { return is_rate(use.attribute); });
  if (a != b) report.assumed.push_back(file.path + " has other attributes than the rest of its sequence");
}

/// Keys without ids: point i is point i. `set` is the first. A count that differs is an error in the field
/// "points".
Result<LoadedCloud> read_in_order(const CloudSource& source, const KeySpan& span, PointSet set) {
  const std::vector<KeyFile>& files = source.files;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  if (files.size() > 1) triangles = set.triangle;
  Result<LoadedCloud> loaded = first_key(std::move(set), files[span.begin].frame, source);
  if (!loaded) return in_file(loaded.error(), files[span.begin].path);
  SurfelCloud& cloud = loaded->cloud;
  std::vector<LookKey> looks{{files[span.begin].frame, {}, {}}};
  for (std::size_t k = span.begin + 1; k < span.end; ++k) {
    Result<PointSet> next = read_points(files[k].path, key_options(source));
    if (!next) return next.error();
    if (next->size() != cloud.size()) {
      return counts_differ("points", files[span.begin], cloud.size(), files[k], next->size());
    }
    if (next->triangle.size() != triangles.size()) {
      return counts_differ("triangles", files[span.begin], triangles.size(), files[k], next->triangle.size());
    }
    compare_reports(next->report, files[k], loaded->report);
    looks.push_back(
        io::look_of(source, cloud, files[k].frame, std::move(next->color), std::move(next->opacity)));
    std::swap(next->triangle, triangles);
    Result<EstimatedSurfels> discs = discs_of(*next, source);
    std::swap(next->triangle, triangles);
    if (!discs) return in_file(discs.error(), files[k].path);
    push_key(*std::move(discs), files[k].frame, cloud);
  }
  io::take_looks(std::move(looks), cloud);
  return loaded;
}

void report_match(const MatchedPoints& matched, const KeyFile& reference, const KeyFile& file, bool moves,
                  ReadReport& report) {
  if (matched.missing > 0) {
    report.assumed.push_back(std::to_string(matched.missing) + " points of " + reference.path +
                             " are not in " + file.path + ", and " +
                             (moves ? "move along their velocities" : "stand still") + " on the way there");
  }
  if (matched.extra > 0) {
    report.assumed.push_back(std::to_string(matched.extra) + " points of " + file.path + " are not in " +
                             reference.path + ", and are left out");
  }
}

/// Keys with ids.
Result<LoadedCloud> read_by_id(const CloudSource& source, const KeySpan& span, double from, double to) {
  const std::vector<KeyFile>& files = source.files;
  const KeyFile& nearest = files[span.nearest];
  Result<PointSet> reference = io::read_with_rates(source, nearest);
  if (!reference) return reference.error();
  const auto no_ids = [](const KeyFile& file) {
    return Error{file.path, "id",
                 "has no ids that name each point once, as other files of its sequence have; "
                 "\"attributes\": {\"id\": \"\"} leaves them unread"};
  };
  if (reference->id.empty()) return no_ids(nearest);
  PointSet still = *reference;
  still.velocity.clear();
  still.acceleration.clear();
  still.angular_velocity.clear();
  Result<EstimatedSurfels> nearest_discs = discs_of(still, source);
  if (!nearest_discs) return in_file(nearest_discs.error(), nearest.path);
  Result<LoadedCloud> first = first_key(std::move(still), *nearest_discs, nearest.frame, source);
  if (!first) return in_file(first.error(), nearest.path);
  LoadedCloud loaded = *std::move(first);
  SurfelCloud& cloud = loaded.cloud;
  cloud.keys.clear();
  loaded.report.assumed.push_back("points of several files are the same by id");
  bool all_there = true, others_too = false;
  std::vector<LookKey> looks;
  for (std::size_t k = span.begin; k < span.end; ++k) {
    if (k == span.nearest) {
      push_key(std::move(*nearest_discs), nearest.frame, cloud);
      looks.push_back({nearest.frame, {}, {}});
      continue;
    }
    const Result<PointSet> other = read_points(files[k].path, key_options(source));
    if (!other) return other.error();
    if (other->id.empty()) return no_ids(files[k]);
    Result<MatchedPoints> matched =
        match_by_id(*reference, *other, (files[k].frame - nearest.frame) * velocity_scale(source));
    if (!matched) return in_file(matched.error(), files[k].path);
    all_there = all_there && matched->missing == 0;
    others_too = others_too || matched->extra > 0;
    compare_reports(other->report, files[k], loaded.report);
    report_match(*matched, nearest, files[k], !reference->velocity.empty(), loaded.report);
    looks.push_back(io::look_of(source, cloud, files[k].frame, std::move(matched->set.color),
                                std::move(matched->set.opacity)));
    Result<EstimatedSurfels> discs = discs_of(matched->set, source);
    if (!discs) return in_file(discs.error(), files[k].path);
    push_key(*std::move(discs), files[k].frame, cloud);
  }
  io::take_looks(std::move(looks), cloud);
  if (!all_there || others_too)
    if (Status lives = io::take_lives(source, span, from, to, loaded); !lives) return lives.error();
  if (all_there) {
    ReadReport& report = loaded.report;
    for (const char* rate : {"velocity", "acceleration", "angular_velocity"}) {
      const std::vector<std::string> names = report.properties_of(rate);
      report.unread.insert(report.unread.end(), names.begin(), names.end());
    }
    std::erase_if(report.used, [](const auto& use) { return is_rate(use.attribute); });
  }
  return loaded;
}

Result<LoadedCloud> read_files(const CloudSource& source, double first, double last) {
  const std::vector<KeyFile>& files = source.files;
  const KeySpan span = span_of(files, first, last, source.path);
  Result<PointSet> set = read_points(files[span.begin].path, key_options(source));
  if (!set) return set.error();
  const bool several = span.end > span.begin + 1;
  std::size_t from = span.begin;
  Result<LoadedCloud> loaded = LoadedCloud{};
  if (several && !set->id.empty()) {
    loaded = read_by_id(source, span, first, last);
    from = span.nearest;
  } else {
    loaded = read_in_order(source, span, *std::move(set));
  }
  if (!loaded && several && loaded.error().field == "points") {
    // Particles come and go. One file says how its own move on, if it has velocities.
    Result<PointSet> alone = io::read_with_rates(source, files[span.nearest]);
    if (!alone || (alone->velocity.empty() && alone->acceleration.empty())) return loaded.error();
    from = span.nearest;
    loaded = first_key(*std::move(alone), files[from].frame, source);
    if (loaded)
      loaded->report.assumed.push_back(
          "the numbers of points differ between the files and there are no ids, so those of " +
          files[from].path + " move along their velocities");
  }
  if (!loaded) return in_file(loaded.error(), files[from].path);
  if (!loaded->materials.names.empty()) loaded->materials_of = files[from].path;
  const std::size_t reference = from < span.end && loaded->cloud.keys.size() > 1 ? from - span.begin : 0;
  if (Status s = io::split_at_creases(source, reference, *loaded); !s)
    return in_file(s.error(), files[from].path);
  if (source.color_by_normals && !source.color) io::turn_colors(reference, first, last, loaded->cloud);
  if (several)
    if (Status ends = io::add_ends(source, span, first, last, *loaded); !ends) return ends.error();
  if (loaded->cloud.keys.size() > 1) loaded->cloud.path = source.path;
  if (std::string changes = io::what_changes(loaded->cloud); !changes.empty())
    loaded->report.assumed.push_back(std::move(changes));
  // Of one file whoever asked for it knows the name.
  if (several)
    for (std::string& note : loaded->notes) note = files[from].path + ": " + note;
  if (Status s = loaded->cloud.validate(); !s) return in_file(s.error(), files[from].path);
  return loaded;
}

}  // namespace

Status color_by_normals(SurfelCloud& cloud) {
  return io::guarded("", [&]() -> Status {
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
  });
}

Result<LoadedCloud> cloud_from_points(PointSet points, double frame, const CloudSource& source) {
  return io::guarded("", [&]() -> Result<LoadedCloud> {
    if (Status s = check_options(source); !s) return s.error();
    if (!std::isfinite(frame)) return option_error("frame", "is not finite");
    if (Status s = points.validate(); !s) return s.error();
    Result<LoadedCloud> loaded = first_key(std::move(points), frame, source);
    if (!loaded) return loaded;
    if (Status s = io::split_at_creases(source, 0, *loaded); !s) return s.error();
    if (Status s = loaded->cloud.validate(); !s) return s.error();
    return loaded;
  });
}

Result<LoadedCloud> read_cloud(const CloudSource& source, double first, double last) {
  return io::guarded("", [&]() -> Result<LoadedCloud> {
    if (Status s = check_options(source); !s) return s.error();
    if (Status s = check_files(source); !s) return s.error();
    if (!(first <= last)) return option_error("frames", "the interval to cover runs backwards");

    return source.may_be_empty ? io::read_beside_empty(source, first, last, read_files)
                               : read_files(source, first, last);
  });
}

}  // namespace swept
