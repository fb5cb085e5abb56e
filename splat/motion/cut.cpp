#include "splat/motion/cut.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "splat/kernel/scene_filter.h"
#include "splat/motion/path.h"
#include "splat/motion/rims.h"
#include "splat/motion/turns.h"

namespace swept {
namespace {

/// Between two times at which a path is looked at nothing may turn farther, radians.
constexpr double most_turn = 0.5 * std::numbers::pi;
constexpr double most_spans = 1024.0;
/// Of a colour, or of 1 if that is more: the chord's light is right in the mean, so that far less is seen.
constexpr float light_tolerance = 0x1p-9f;

/// Of the tolerance: what is straighter is a chord, which costs less to draw.
constexpr double least_bend = 0.25;
/// Of the way from end to end: the direction changes by a fifth of a radian to either side, the speed by 0.4.
constexpr double most_bend = 0.1;
/// Halves are numbered as the nodes of a binary tree, the root being 1, below the number of their span.
constexpr int node_bits = 9;
constexpr std::uint32_t whole_path = ~0u;
constexpr double most_spans_in_all = 1 << 22;

/// Where the time `index` of 2^finest is kept: ends, middle, quarters, and so on.
std::size_t slot_of(int index, int finest) {
  if (index == 0) return 0;
  if (index == 1 << finest) return 1;
  const int zeros = std::countr_zero(static_cast<unsigned>(index));
  return 1u + (1u << (finest - zeros - 1)) + (static_cast<unsigned>(index) >> (zeros + 1));
}

/// Radians that the object, its discs and the camera turn by between two frames, or more.
double turning(const Scene& scene, const Object& object, double spin, double first, double last) {
  double turns = spin * (last - first);
  const auto add = [&](const auto& keys, const auto& angle) {
    for (std::size_t k = 1; k < keys.size(); ++k) {
      const double from = std::max(keys[k - 1].frame, first), to = std::min(keys[k].frame, last);
      if (from < to) turns += angle(keys[k - 1], keys[k]) * (to - from) / (keys[k].frame - keys[k - 1].frame);
    }
  };
  add(object.transform.keys, [](const TransformKey& a, const TransformKey& b) {
    return std::max(std::abs(b.rotate_radians - a.rotate_radians),
                    a.rotate_axis == b.rotate_axis ? 0.0 : std::numbers::pi);
  });
  add(scene.camera.poses, [](const CameraKey& a, const CameraKey& b) {
    return a.world_from_camera.angularDistance(b.world_from_camera);
  });
  add(scene.camera.look_ats, [](const LookAtKey& a, const LookAtKey& b) {
    return std::max(std::numbers::pi, std::abs(b.roll_radians - a.roll_radians));
  });
  return turns;
}

Eigen::Vector3d off_chord(const Eigen::Vector3d& first, const Eigen::Vector3d& truth,
                          const Eigen::Vector3d& last, double share) {
  return truth - (first + share * (last - first));
}

}  // namespace

PathCutter::PathCutter(const Scene& scene, const Object& object, const Exposure& exposure, SegmentShape shape)
    : scene_(scene),
      object_(object),
      exposure_(exposure),
      shape_(shape),
      projection_(projection_of(scene.film, scene.camera.at(exposure.middle()))),
      filter_(filter_of(scene, projection_)),
      looks_change_(looks_change(object.cloud, exposure.open, exposure.close)),
      middle_(place(0.5)) {
  add_corners();
  looks_.resize(spans_.size() - 1);
}

void PathCutter::add_corners() {
  const SurfelCloud& cloud = object_.cloud;
  const double open = exposure_.open, close = exposure_.close;
  std::vector<double> frames = path_corners(cloud, open, close);
  for (const double corner : look_corners(cloud, open, close)) frames.push_back(corner);
  frames.push_back(open);
  frames.push_back(close);
  const auto add_keys = [&](const auto& keys) {
    for (const auto& key : keys)
      if (key.frame > open && key.frame < close) frames.push_back(key.frame);
  };
  add_keys(object_.transform.keys);
  add_keys(scene_.camera.poses);
  add_keys(scene_.camera.look_ats);
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  double spin = 0.0;
  for (const Eigen::Vector3f& rate : cloud.angular_velocity)
    spin = std::max(spin, rate.cast<double>().stableNorm());
  // A curve of degree d has d − 2 points of inflexion: no more than two of them between two looks.
  const double of_degree = std::ceil(static_cast<double>(path_degree(cloud)) / 4.0);
  for (std::size_t k = 0; k + 1 < frames.size(); ++k) {
    const double turns = turning(scene_, object_, spin, frames[k], frames[k + 1]);
    const double most =
        std::max(1.0, std::min(most_spans, most_spans_in_all / static_cast<double>(frames.size())));
    const double parts = std::min(std::max(of_degree, std::ceil(turns / most_turn)), most);
    const double first = exposure_.share_at(frames[k]), last = exposure_.share_at(frames[k + 1]);
    for (double part = 0.0; part < parts; part += 1.0)
      spans_.push_back(first + (last - first) * (part / parts));
  }
  spans_.push_back(1.0);
}

PathCutter::Place PathCutter::place(double time) const {
  const Instant instant = instant_at(scene_, object_, exposure_, time);
  return {instant, SurfelsAt(object_.cloud, instant.frame), LooksAt(object_.cloud, instant.frame)};
}

const PathCutter::Place& PathCutter::at(std::size_t span, int index) {
  auto& looks = looks_[span];
  const std::size_t slot = slot_of(index, finest);
  if (slot >= looks.size()) looks.resize(slot < 2 ? 2 : std::bit_ceil(slot) + 1);
  auto& look = looks[slot];
  if (!look) {
    const double share = static_cast<double>(index) / (1 << finest);
    look = std::make_unique<Place>(place(spans_[span] + share * (spans_[span + 1] - spans_[span])));
  }
  return *look;
}

const PathCutter::Place& PathCutter::known(std::size_t span, int index) const {
  return *looks_[span][slot_of(index, finest)];
}

double PathCutter::time(std::size_t span, int index) const {
  if (index == 1 << finest) return spans_[span + 1];  // the very number that the next span begins with
  return spans_[span] + static_cast<double>(index) / (1 << finest) * (spans_[span + 1] - spans_[span]);
}

PathCutter::Seen PathCutter::see(std::size_t i, const Place& place) const {
  const SurfelInstant surfel = place.surfels[i];
  Seen seen{place.instant.to_camera(surfel.position),
            place.instant.to_camera_direction(surfel.axis_u),
            place.instant.to_camera_direction(surfel.axis_v),
            {},
            &place.instant};
  if (looks_change_) seen.light = place.looks[i];
  return seen;
}

/// Pixels per unit of camera space; 0 where nothing is seen, give or take a frame.
double PathCutter::visible_scale(const Eigen::Vector3d& center) const {
  if (!(center.z() > scene_.camera.near)) return 0.0;
  const double scale = projection_.focal_px / projection_.divisor(center.z());
  const double x = projection_.center_x - 0.5 * scene_.film.width + center.x() * scale;
  const double y = projection_.center_y - 0.5 * scene_.film.height + center.y() * scale;
  return std::abs(x) <= scene_.film.width && std::abs(y) <= scene_.film.height ? scale : 0.0;
}

bool PathCutter::same_light(const Seen& first, const Seen& truth, const Seen& last, double share) const {
  if (!looks_change_) return true;
  const Eigen::Vector4f light = first.light + static_cast<float>(share) * (last.light - first.light);
  return (light - truth.light).cwiseAbs().maxCoeff() <=
         light_tolerance * std::max(1.0f, truth.light.cwiseAbs().maxCoeff());
}

/// Parallel rays go along the view, wherever the disc is.
Eigen::Vector2d PathCutter::ray_of(const Eigen::Vector3d& center) const {
  return projection_.orthographic ? Eigen::Vector2d::Zero() : Eigen::Vector2d(center.head<2>() / center.z());
}

/// From the first to the last on the film, in units of the middle.
double PathCutter::way_px(const Seen& first, const Seen& middle, const Seen& last) const {
  const Eigen::Vector3d way = last.center - first.center;
  return visible_scale(middle.center) * (way.head<2>() - way.z() * ray_of(middle.center)).norm();
}

/// Whether the path between the three is worth bending, and turns and changes its speed by so little that any
/// ray sees it once.
bool PathCutter::bends(const Seen& first, const Seen& middle, const Seen& last) const {
  if (shape_ != SegmentShape::parabolas) return false;
  const double bend_px =
      visible_scale(middle.center) * off_chord(first.center, middle.center, last.center, 0.5).norm();
  return bend_px > least_bend * tolerance_px_ && bend_px <= most_bend * way_px(first, middle, last);
}

/// What of the segment's time a ray sees the disc for, or more.
double PathCutter::seen_share(const Seen& first, const Seen& middle, const Seen& last) const {
  const Eigen::Vector2d ray = ray_of(middle.center);
  const FilmEllipse disc({middle.axis_u, middle.axis_v}, ray.x(), ray.y(), visible_scale(middle.center));
  const double half = 0.5 * disc.trace(), filter_px = scene_.model.filter_radius_px;
  const double longest = half + std::sqrt(std::max(0.0, half * half - disc.determinant()));
  return std::min(1.0, 2.0 * std::sqrt(longest + filter_px * filter_px) / way_px(first, middle, last));
}

// What is not a number is cut no further.
bool PathCutter::near_line(const Seen& first, const Seen& middle, const Seen& last) const {
  if (!same_light(first, middle, last, 0.5)) return false;
  const double off_px =
      off_chord(first.center, middle.center, last.center, 0.5).norm() * visible_scale(middle.center);
  if (!(off_px > tolerance_px_)) return true;
  if (!bends(first, middle, last)) return false;
  const double share = seen_share(first, middle, last);
  return off_px * share * share <= tolerance_px_;
}

bool PathCutter::near_path(const Seen& first, const Seen& middle, const Seen& last, const Seen& truth,
                           double share) const {
  if (!same_light(first, truth, last, share)) return false;
  const bool bent = bends(first, middle, last);
  Eigen::Vector3d off = off_chord(first.center, truth.center, last.center, share);
  if (bent) off -= 4.0 * share * (1.0 - share) * off_chord(first.center, middle.center, last.center, 0.5);
  return !(off.norm() * visible_scale(truth.center) > (bent ? bent_part : 1.0) * tolerance_px_);
}

PathSegment PathCutter::segment_of(const std::pair<double, double>& times, const Seen& first,
                                   const Seen& middle, const Seen& last, std::uint32_t piece) const {
  return {times.first,
          times.second,
          first.center,
          middle.center,
          last.center,
          middle.axis_u,
          middle.axis_v,
          bends(first, middle, last),
          turns(first, middle, last),
          first.light,
          middle.light,
          last.light,
          first.axis_u,
          first.axis_v,
          last.axis_u,
          last.axis_v,
          first.at,
          middle.at,
          last.at,
          piece};
}

bool PathCutter::is_one_segment(std::size_t i) {
  const Seen middle = see(i, middle_);
  const Seen first = see(i, at(0, 0)), last = see(i, at(looks_.size() - 1, 1 << finest));
  if (!near_line(first, middle, last)) return false;
  const Axes axes = axes_of(first, middle, last);
  if (!axes.follow) return false;
  for (std::size_t span = 0; span < looks_.size(); ++span)
    for (int quarter = span == 0 ? 1 : 0; quarter < 4; ++quarter) {
      const double time = spans_[span] + 0.25 * quarter * (spans_[span + 1] - spans_[span]);
      const Seen truth = see(i, at(span, quarter << (finest - 2)));
      if (!near_path(first, middle, last, truth, time) || !near_axes(axes, middle, truth, time)) return false;
    }
  segments_.push_back(segment_of({0.0, 1.0}, first, middle, last, whole_path));
  return true;
}

void PathCutter::halve(std::size_t i, std::size_t span, int begin, int end, const Seen& first,
                       const Seen& last) {
  const int half = (end - begin) / 2, quarter = half / 2;
  const Seen middle = see(i, at(span, begin + half));
  bool whole = near_line(first, middle, last);
  if (whole) {
    const Axes axes = axes_of(first, middle, last);
    const auto near = [&](int index, double share) {
      const Seen truth = see(i, at(span, index));
      return near_path(first, middle, last, truth, share) &&
             (!axes.turn || near_axes(axes, middle, truth, share));
    };
    whole = axes.follow && near(begin + quarter, 0.25) && near(end - quarter, 0.75);
  }
  if (!whole && end - begin > 1 << (finest - most_halvings)) {
    halve(i, span, begin, begin + half, first, middle);
    halve(i, span, begin + half, end, middle, last);
    return;
  }
  const int node = ((1 << finest) + begin) / (end - begin);
  segments_.push_back(
      segment_of({time(span, begin), time(span, end)}, first, middle, last,
                 static_cast<std::uint32_t>(span) << node_bits | static_cast<std::uint32_t>(node)));
}

PathSegment PathCutter::segment(std::size_t i, std::uint32_t piece) const {
  const bool whole = piece == whole_path;
  const std::size_t span = whole ? 0 : piece >> node_bits, last_span = whole ? looks_.size() - 1 : span;
  // The root is 1, and there is none before it.
  const std::uint32_t node = whole ? 1 : std::max(1u, piece & ((1u << node_bits) - 1));
  const int length = static_cast<int>((1u << finest) / std::bit_floor(node));
  const int begin = static_cast<int>(node) * length - (1 << finest);
  const int end = whole ? 1 << finest : begin + length;
  const Seen first = see(i, known(span, begin)), last = see(i, known(last_span, end)),
             middle = see(i, whole ? middle_ : known(span, begin + length / 2));
  return segment_of({whole ? 0.0 : time(span, begin), whole ? 1.0 : time(span, end)}, first, middle, last,
                    piece);
}

const std::vector<PathSegment>& PathCutter::cut(std::size_t i, double tolerance_px) {
  tolerance_px_ = tolerance_px;
  segments_.clear();
  if (is_one_segment(i)) return segments_;
  for (std::size_t span = 0; span < looks_.size(); ++span)
    halve(i, span, 0, 1 << finest, see(i, at(span, 0)), see(i, at(span, 1 << finest)));
  return segments_;
}

}  // namespace swept
