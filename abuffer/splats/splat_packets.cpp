#include "abuffer/splats/splat_packets.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "abuffer/sources/content_order.h"
#include "abuffer/splats/posed_packet.h"
#include "splat/motion/instant.h"

namespace swept {
namespace {

constexpr auto lanes_of_packet = static_cast<std::size_t>(packet_size);

/// Everything that tells one splat from another, but for what a cloud's splats share.
bool less_by_content(const SplatCloud& cloud, std::uint32_t a, std::uint32_t b) {
  const auto compare = [](const auto& v, const auto& w) {
    for (int i = 0; i < static_cast<int>(v.size()); ++i)
      if (v[i] != w[i]) return v[i] < w[i] ? -1 : 1;
    return 0;
  };
  if (const int c = compare(cloud.position[a], cloud.position[b])) return c < 0;
  if (const int c = compare(cloud.scale[a], cloud.scale[b])) return c < 0;
  if (const int c = compare(cloud.rotation[a].coeffs(), cloud.rotation[b].coeffs())) return c < 0;
  if (cloud.opacity[a] != cloud.opacity[b]) return cloud.opacity[a] < cloud.opacity[b];
  if (!cloud.velocity.empty())
    if (const int c = compare(cloud.velocity[a], cloud.velocity[b])) return c < 0;
  if (cloud.motion) {
    const SplatMotion& m = *cloud.motion;
    if (m.center[a] != m.center[b]) return m.center[a] < m.center[b];
    if (m.duration[a] != m.duration[b]) return m.duration[a] < m.duration[b];
    for (std::size_t k = 0; k < 3; ++k)
      if (const int c = compare(m.path[a][k], m.path[b][k])) return c < 0;
    if (const int c = compare(m.turn[a], m.turn[b])) return c < 0;
  }
  const auto floats = static_cast<std::size_t>(3 * SplatCloud::coefficients(cloud.degree));
  const float *of_a = cloud.harmonics.data() + floats * a, *of_b = cloud.harmonics.data() + floats * b;
  return std::lexicographical_compare(of_a, of_a + floats, of_b, of_b + floats);
}

/// How splat `i` moves by itself, and what turns with it.
void pack_motion(const SplatCloud& cloud, std::size_t i, std::size_t p, std::size_t lane, SplatPackets& to) {
  const SplatMotion& motion = *cloud.motion;
  const auto field = [&](std::size_t which) -> float& {
    return to.motions[(own_numbers * p + which) * lanes_of_packet + lane];
  };
  field(own_center) = motion.center[i];
  field(own_duration) = motion.duration[i];
  for (std::size_t k = 0; k < 9; ++k) field(own_path + k) = motion.path[i][k / 3][static_cast<int>(k % 3)];
  const Eigen::Quaternionf& q = cloud.rotation[i];
  const float rotation[4] = {q.w(), q.x(), q.y(), q.z()};
  for (std::size_t k = 0; k < 4; ++k) {
    field(own_turn + k) = motion.turn[i][static_cast<int>(k)];
    field(own_rotation + k) = rotation[k];
  }
  for (std::size_t k = 0; k < 3; ++k) field(own_scale + k) = cloud.scale[i][static_cast<int>(k)];
}

void pack_packet(const SplatCloud& cloud, const std::uint32_t* splats, std::size_t p, SplatPackets& to) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t lane = 0; lane < lanes_of_packet; ++lane) {
    low = low.cwiseMin(cloud.position[splats[lane]]);
    high = high.cwiseMax(cloud.position[splats[lane]]);
  }
  to.origins[p] = low + (0.5 * high - 0.5 * low);
  const auto floats = static_cast<std::size_t>(3 * SplatCloud::coefficients(cloud.degree));
  for (std::size_t lane = 0; lane < lanes_of_packet; ++lane) {
    const std::uint32_t i = splats[lane];
    const Eigen::Vector3d offset = cloud.position[i] - to.origins[p];
    const Eigen::Matrix3d axes =
        cloud.rotation[i].cast<double>().toRotationMatrix() * cloud.scale[i].cast<double>().asDiagonal();
    const auto field = [&](std::vector<float>& values, std::size_t count, std::size_t which) -> float& {
      return values[(count * p + which) * lanes_of_packet + lane];
    };
    for (std::size_t k = 0; k < 3; ++k) {
      field(to.offsets, 3, k) = static_cast<float>(offset[static_cast<int>(k)]);
      if (!to.velocities.empty()) field(to.velocities, 3, k) = cloud.velocity[i][static_cast<int>(k)];
    }
    if (!to.motions.empty()) pack_motion(cloud, i, p, lane, to);
    for (std::size_t k = 0; k < 9 && !to.axes.empty(); ++k)
      field(to.axes, 9, k) = static_cast<float>(axes(static_cast<int>(k % 3), static_cast<int>(k / 3)));
    to.opacities[p * lanes_of_packet + lane] = cloud.opacity[i];
    for (std::size_t k = 0; k < floats; ++k) field(to.harmonics, floats, k) = cloud.harmonics[floats * i + k];
  }
}

/// Those of `order` for which `is_part` holds.
template <class IsPart>
SplatPackets pack(const Object& object, const std::vector<std::uint32_t>& order, bool moves,
                  const IsPart& is_part) {
  const SplatCloud& cloud = object.splats;
  std::vector<std::uint32_t> splats;
  std::copy_if(order.begin(), order.end(), std::back_inserter(splats), is_part);
  SplatPackets packets;
  packets.object = &object;
  packets.moves = moves;
  packets.splats = splats.size();
  packets.count = (splats.size() + lanes_of_packet - 1) / lanes_of_packet;
  if (packets.count == 0) return packets;
  packets.lanes.assign(packets.count, (1u << packet_size) - 1u);
  if (const std::size_t rest = splats.size() % lanes_of_packet; rest != 0)
    packets.lanes.back() = (1u << rest) - 1u;
  // The last packet repeats its last splat where it has none.
  splats.resize(packets.count * lanes_of_packet, splats.back());
  const std::size_t padded = splats.size();
  packets.origins.resize(packets.count);
  packets.offsets.resize(3 * padded);
  if (cloud.motion)
    packets.motions.resize(own_numbers * padded);
  else
    packets.axes.resize(9 * padded);
  if (moves && !cloud.velocity.empty()) packets.velocities.resize(3 * padded);
  packets.opacities.resize(padded);
  packets.harmonics.resize(static_cast<std::size_t>(3 * SplatCloud::coefficients(cloud.degree)) * padded);
  parallel_for_each_index(packets.count, [&](std::size_t p) {
    pack_packet(cloud, splats.data() + p * lanes_of_packet, p, packets);
  });
  return packets;
}

/// A number that depends on what the splats are and not on the order of the scene.
std::uint64_t content_hash(const SplatPackets& packets, const Exposure& exposure) {
  std::uint64_t hash = packets.moves ? 0x9e3779b97f4a7c15ULL : 0xc2b2ae3d27d4eb4fULL;
  const auto mix = [&](std::uint64_t word) {
    hash = (hash ^ word) * 0xbf58476d1ce4e5b9ULL;
    hash ^= hash >> 29;
  };
  for (const Eigen::Vector3d& origin : packets.origins)
    for (int k = 0; k < 3; ++k) mix(std::bit_cast<std::uint64_t>(origin[k]));
  for (const std::vector<float>* values : {&packets.offsets, &packets.axes, &packets.velocities,
                                           &packets.motions, &packets.opacities, &packets.harmonics})
    for (const float value : *values) mix(std::bit_cast<std::uint32_t>(value));
  for (const double share : {0.0, 0.5, 1.0}) {
    const Eigen::Affine3d world = packets.object->transform.at(exposure.at(share));
    for (int k = 0; k < 12; ++k) mix(std::bit_cast<std::uint64_t>(world.affine()(k % 3, k / 3)));
  }
  return hash;
}

}  // namespace

SplatFields SplatPackets::fields(std::size_t packet) const {
  const std::size_t at = packet * lanes_of_packet;
  const int coefficients = SplatCloud::coefficients(object->splats.degree);
  return {offsets.data() + 3 * at,
          axes.empty() ? nullptr : axes.data() + 9 * at,
          velocities.empty() ? nullptr : velocities.data() + 3 * at,
          opacities.data() + at,
          harmonics.data() + static_cast<std::size_t>(3 * coefficients) * at,
          coefficients,
          lanes[packet]};
}

std::size_t moving_splats(const std::vector<SplatPackets>& sets) {
  std::size_t splats = 0;
  for (const SplatPackets& set : sets) splats += set.moves ? set.splats : 0;
  return splats;
}

Status check_splats(const Scene& scene) {
  const Object* first = nullptr;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Object& object = scene.objects[i];
    const std::string field = "/objects/" + std::to_string(i);
    if (object.splats.size() == 0) continue;
    if (first != nullptr && scene.splats.blending == SplatBlending::file &&
        first->splats.colors != object.splats.colors)
      return Error{"", field,
                   "is blended in other values than another object's splats; say in which with "
                   "/splats/blending"};
    first = &object;
  }
  return Done{};
}

std::size_t packed_splat_bytes(const Scene& scene) {
  std::size_t bytes = 0;
  for (const Object& object : scene.objects) {
    const std::size_t floats = 13 + (object.splats.velocity.empty() ? 0u : 3u) +
                               (object.splats.motion ? own_numbers - 9 : 0u) +
                               static_cast<std::size_t>(3 * SplatCloud::coefficients(object.splats.degree));
    const std::size_t packets = (object.splats.size() + lanes_of_packet - 1) / lanes_of_packet;
    bytes += packets *
             (lanes_of_packet * floats * sizeof(float) + sizeof(Eigen::Vector3d) + sizeof(std::uint32_t));
  }
  return bytes;
}

std::vector<SplatPackets> pack_splats(const Scene& scene, const Exposure& exposure, bool only_standing) {
  std::vector<SplatPackets> sets;
  for (const Object& object : scene.objects) {
    const SplatCloud& cloud = object.splats;
    if (cloud.size() == 0) continue;
    const std::vector<std::uint32_t> order = content_order(
        cloud.size(), [&](std::size_t i) { return cloud.position[i]; },
        [&](std::uint32_t a, std::uint32_t b) { return less_by_content(cloud, a, b); });
    const bool all_move =
        !exposure.instant() && !(object.transform.constant_over(exposure.open, exposure.close) &&
                                 scene.camera.constant_over(exposure.open, exposure.close));
    const auto visible = [&](std::uint32_t i) {
      return double{cloud.opacity[i]} >= scene.splats.least_alpha;
    };
    // At an instant splats with velocities are not where the file has them, and so are packed with those.
    const auto moves = [&](std::uint32_t i) {
      return all_move || cloud.motion || (!cloud.velocity.empty() && !cloud.velocity[i].isZero(0.0f));
    };
    for (const bool moving : {false, true}) {
      if (moving && only_standing && !exposure.instant()) continue;
      SplatPackets set =
          pack(object, order, moving, [&](std::uint32_t i) { return visible(i) && moves(i) == moving; });
      // Through a lens nothing stays where it is.
      set.moves = set.moves || scene.camera.aperture.radius > 0.0;
      if (set.count > 0) sets.push_back(std::move(set));
    }
  }
  if (sets.size() < 2) return sets;
  std::vector<std::uint64_t> hashes(sets.size());
  parallel_for_each_index(sets.size(), [&](std::size_t i) { hashes[i] = content_hash(sets[i], exposure); });
  std::vector<std::size_t> order(sets.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return hashes[a] < hashes[b]; });
  std::vector<SplatPackets> sorted;
  sorted.reserve(sets.size());
  for (const std::size_t i : order) sorted.push_back(std::move(sets[i]));
  return sorted;
}

SplatPose::SplatPose(const Scene& scene, const SplatPackets& packets, double frame)
    : world_from_object_(packets.object->transform.at(frame)) {
  const CameraInstant camera = scene.camera.at(frame);
  const Projection projection = projection_of(scene.film, camera);
  camera_from_world_ = camera.camera_from_world.linear();
  eye_ = camera.eye;
  focal_x_ = projection.focal_px * camera.lens.stretch_x, focal_y_ = projection.focal_px;
  center_x_ = projection.center_x, center_y_ = projection.center_y;
  orthographic_ = projection.orthographic;
  const Eigen::Matrix3d linear = camera_from_world_ * world_from_object_.linear();
  // Colours turn with the object, and are mirrored with it; they are not stretched.
  Eigen::Matrix3d turn = world_from_object_.linear();
  for (int i = 0; i < 3; ++i)
    if (turn.col(i).norm() > 0.0) turn.col(i).normalize();
  const Eigen::Matrix3d to_object = turn.transpose() * camera_from_world_.transpose();
  for (int i = 0; i < 9; ++i) {
    view.linear[i] = static_cast<float>(linear(i / 3, i % 3));
    view.turn[i] = static_cast<float>(to_object(i / 3, i % 3));
  }
  const SplatCloud& cloud = packets.object->splats;
  view.frames = static_cast<float>(frame - cloud.frame);
  if (cloud.motion) clip_time = (frame - cloud.frame) / cloud.motion->frames;
  view.focal_x = static_cast<float>(focal_x_);
  view.focal_y = static_cast<float>(focal_y_);
  // x/z and y/z in the Jacobian are held to 0.3 of half the film beyond its edges: as implementations have
  // it, 1.3 · tan(half the field of view) where the axis meets the film's middle.
  constexpr double beyond = 0.3;
  const double width = scene.film.width, height = scene.film.height;
  view.low_x = static_cast<float>((-center_x_ - 0.5 * beyond * width) / focal_x_);
  view.high_x = static_cast<float>((width - center_x_ + 0.5 * beyond * width) / focal_x_);
  view.low_y = static_cast<float>((-center_y_ - 0.5 * beyond * height) / focal_y_);
  view.high_y = static_cast<float>((height - center_y_ + 0.5 * beyond * height) / focal_y_);
  if (orthographic_) view.low_x = view.high_x = view.low_y = view.high_y = 0.0f;
  view.orthographic = orthographic_;
  view.dilation_px2 = static_cast<float>(scene.splats.dilation_px2);
  view.near = static_cast<float>(scene.splats.near);
  view.least_alpha = static_cast<float>(scene.splats.least_alpha);
  view.antialiased = packets.object->splats.filter == SplatFilter::antialiased;
  view.flat = packets.object->splats.flat;
  view.film_width = scene.film.width;
  view.film_height = scene.film.height;
}

namespace {

void place_pixel(double px, double py, SplatOrigin& origin) {
  origin.pixel_x = static_cast<int>(std::floor(px));
  origin.pixel_y = static_cast<int>(std::floor(py));
  origin.fraction_x = static_cast<float>(px - std::floor(px));
  origin.fraction_y = static_cast<float>(py - std::floor(py));
}

}  // namespace

SplatOrigin SplatPose::origin(const SplatPackets& packets, std::size_t packet) const {
  const Eigen::Vector3d at = camera_from_world_ * (world_from_object_ * packets.origins[packet] - eye_);
  SplatOrigin origin;
  origin.x = static_cast<float>(at.x());
  origin.y = static_cast<float>(at.y());
  origin.z = static_cast<float>(at.z());
  constexpr double widest = 1e3;
  if (orthographic_) {
    // Far to the side places are counted from the axis.
    const double farthest = widest * (std::abs(center_x_) + std::abs(center_y_) + 1.0);
    const bool beside = std::abs(focal_x_ * at.x()) < farthest && std::abs(focal_y_ * at.y()) < farthest;
    const double from_x = beside ? at.x() : 0.0, from_y = beside ? at.y() : 0.0;
    origin.tangent_x = origin.tangent_y = 0.0f;
    origin.rest_x = static_cast<float>(at.x() - from_x);
    origin.rest_y = static_cast<float>(at.y() - from_y);
    place_pixel(center_x_ + focal_x_ * from_x, center_y_ + focal_y_ * from_y, origin);
    return origin;
  }
  // Behind the eye, and far to the side of it, places are counted from the axis.
  const double x = at.x() / at.z(), y = at.y() / at.z();
  const bool ahead = at.z() > 0.0 && std::abs(x) < widest && std::abs(y) < widest;
  origin.tangent_x = ahead ? static_cast<float>(x) : 0.0f;
  origin.tangent_y = ahead ? static_cast<float>(y) : 0.0f;
  // What the tangents were rounded by must not be lost.
  const double from_x = double{origin.tangent_x}, from_y = double{origin.tangent_y};
  origin.rest_x = static_cast<float>(at.x() - from_x * at.z());
  origin.rest_y = static_cast<float>(at.y() - from_y * at.z());
  place_pixel(center_x_ + focal_x_ * from_x, center_y_ + focal_y_ * from_y, origin);
  return origin;
}

}  // namespace swept
