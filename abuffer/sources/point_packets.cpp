#include "abuffer/sources/point_packets.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "abuffer/parallel.h"
#include "abuffer/sources/content_order.h"
#include "abuffer/sources/motion_order.h"
#include "abuffer/sources/object_instant.h"
#include "abuffer/sources/path_groups.h"
#include "splat/motion/instant.h"
#include "splat/motion/look.h"
#include "splat/motion/path.h"

namespace swept {
namespace {

/// Frames at which the exposure has to know the points: its ends, and the corners of paths between.
std::vector<double> pose_frames(const SurfelCloud& cloud, const Exposure& exposure) {
  std::vector<double> frames{exposure.open};
  if (exposure.instant() || !cloud.moves()) return frames;
  for (const double corner : path_corners(cloud, exposure.open, exposure.close)) frames.push_back(corner);
  frames.push_back(exposure.close);
  return frames;
}

/// Where nothing moves rates are not looked at, though there may be some, all zero.
PathWeights weights_at(const SurfelCloud& cloud, double frame) {
  return cloud.moves() ? path_weights(cloud, frame) : PathWeights{};
}

/// The poses of PointPackets.
std::vector<PathWeights> poses_of(const SurfelCloud& cloud, const std::vector<double>& frames,
                                  std::size_t degree) {
  std::vector<PathWeights> poses{weights_at(cloud, frames.front())};
  for (std::size_t j = 1; j < frames.size(); ++j) {
    if (degree == 1) {
      poses.push_back(path_weights(cloud, frames[j]));
      continue;
    }
    std::vector<PathWeights> controls = path_controls(cloud, frames[j - 1], frames[j]);
    for (std::size_t k = 1; k < controls.size(); ++k) poses.push_back(std::move(controls[k]));
  }
  return poses;
}

/// Indices of the looks between which those of the exposure lie, and the one after the last; none where one
/// look holds throughout.
std::pair<std::size_t, std::size_t> looks_of(const SurfelCloud& cloud, const Exposure& exposure) {
  if (!looks_change(cloud, exposure.open, exposure.close)) return {0, 0};
  return {look_place(cloud.looks, exposure.open).before, look_place(cloud.looks, exposure.close).after + 1};
}

/// Everything that tells one point from another.
class Content {
 public:
  Content(const SurfelCloud& cloud, const std::vector<PathWeights>& poses, const Exposure& exposure)
      : cloud_(cloud), spins_(cloud.spins()), color_(&cloud.color), opacity_(&cloud.opacity) {
    for (const PathWeights& pose : poses) poses_.emplace_back(cloud, pose);
    const auto [first, end] = looks_of(cloud, exposure);
    for (std::size_t k = first; k < end; ++k) looks_.emplace_back(cloud, cloud.looks[k].frame);
    if (cloud.looks.empty()) return;
    // Looks that are held are as good as the cloud's own.
    const LookKey& held = cloud.looks[look_place(cloud.looks, exposure.open).before];
    color_ = &held.color;
    opacity_ = &held.opacity;
  }

  [[nodiscard]] bool less(std::size_t a, std::size_t b) const {
    for (const SurfelsAt& pose : poses_) {
      const SurfelInstant s = pose[a], t = pose[b];
      for (const auto& [v, w] : {std::pair(&s.position, &t.position), std::pair(&s.axis_u, &t.axis_u),
                                 std::pair(&s.axis_v, &t.axis_v)})
        for (int i = 0; i < 3; ++i)
          if ((*v)[i] != (*w)[i]) return (*v)[i] < (*w)[i];
    }
    if (spins_)
      for (int i = 0; i < 3; ++i)
        if (cloud_.angular_velocity[a][i] != cloud_.angular_velocity[b][i])
          return cloud_.angular_velocity[a][i] < cloud_.angular_velocity[b][i];
    if (!cloud_.lifetime.empty()) {
      const Lifetime &s = cloud_.lifetime[a], &t = cloud_.lifetime[b];
      if (s.born != t.born) return s.born < t.born;
      if (s.gone != t.gone) return s.gone < t.gone;
    }
    if (looks_.empty() && !color_->empty())
      for (int i = 0; i < 3; ++i)
        if ((*color_)[a][i] != (*color_)[b][i]) return (*color_)[a][i] < (*color_)[b][i];
    if (looks_.empty() && !opacity_->empty() && (*opacity_)[a] != (*opacity_)[b])
      return (*opacity_)[a] < (*opacity_)[b];
    for (const LooksAt& looks : looks_) {
      const Eigen::Vector4f s = looks[a], t = looks[b];
      for (int i = 0; i < 4; ++i)
        if (s[i] != t[i]) return s[i] < t[i];
    }
    return !cloud_.oriented.empty() && cloud_.oriented[a] < cloud_.oriented[b];
  }

  [[nodiscard]] std::uint64_t hash(std::size_t i) const {
    std::uint64_t hash = 0x9e3779b97f4a7c15ULL;
    const auto mix = [&](double value) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0xbf58476d1ce4e5b9ULL;
      hash ^= hash >> 29;
    };
    for (const SurfelsAt& pose : poses_) {
      const SurfelInstant s = pose[i];
      for (const Eigen::Vector3d* v : {&s.position, &s.axis_u, &s.axis_v})
        for (int k = 0; k < 3; ++k) mix((*v)[k]);
    }
    if (spins_)
      for (int k = 0; k < 3; ++k) mix(double{cloud_.angular_velocity[i][k]});
    if (!cloud_.lifetime.empty()) {
      mix(cloud_.lifetime[i].born);
      mix(cloud_.lifetime[i].gone);
    }
    if (looks_.empty() && !color_->empty())
      for (int k = 0; k < 3; ++k) mix(double{(*color_)[i][k]});
    if (looks_.empty() && !opacity_->empty()) mix(double{(*opacity_)[i]});
    for (const LooksAt& looks : looks_)
      for (const float channel : looks[i]) mix(double{channel});
    if (!cloud_.oriented.empty()) mix(double{cloud_.oriented[i] != 0 ? 1.0 : 0.0});
    return hash;
  }

 private:
  const SurfelCloud& cloud_;
  bool spins_;
  std::vector<SurfelsAt> poses_;
  std::vector<LooksAt> looks_;  ///< empty: these hold throughout
  const PointArray<Eigen::Vector3f>* color_;
  const PointArray<float>* opacity_;
};

/// Points along a space-filling curve; those in one cell of it by content.
std::vector<std::uint32_t> order_of(const SurfelCloud& cloud, const std::vector<std::uint32_t>& points,
                                    const std::vector<PathWeights>& poses, const Exposure& exposure) {
  // In the middle points have moved apart half as far as from one end to the other.
  const SurfelsAt pose(cloud, weights_at(cloud, exposure.middle()));
  const Content content(cloud, poses, exposure);
  const auto less = [&](std::uint32_t a, std::uint32_t b) { return content.less(points[a], points[b]); };
  std::vector<std::uint32_t> order = content_order(
      points.size(), [&](std::size_t i) { return pose.position(points[i]); }, less);
  if (!exposure.instant() && cloud.moves()) {
    const SurfelsAt first(cloud, poses.front()), last(cloud, poses.back());
    order = motion_order(
        std::move(order),
        [&](std::uint32_t i) {
          PointEnds ends;
          ends << first.position(points[i]), last.position(points[i]);
          return ends;
        },
        less);
  }
  parallel_for_each_index(order.size(), [&](std::size_t i) { order[i] = points[order[i]]; });
  return order;
}

/// Has the processor fetch a point's value, which lies anywhere, while it works on others.
template <class T>
void fetch(const PointArray<T>& values, std::size_t i) {
  if (!values.empty()) __builtin_prefetch(&values[i]);
}

/// Calls visit(packet, lane, point) for a packet's lanes, and ahead(point) for those of the next.
template <class Visit, class Ahead>
void for_each_lane(const PointPackets& packets, std::size_t p, const Visit& visit, const Ahead& ahead) {
  const std::uint32_t* const points = packets.points.data() + p * packet_size;
  const std::size_t next = p + 1 < packets.count ? packet_size : 0;
  for (std::size_t lane = 0; lane < packet_size; ++lane) {
    ahead(points[lane + next]);
    visit(lane, points[lane]);
  }
}

/// Origins, offsets, axes and the spheres that hold them.
void pack_poses(const SurfelCloud& cloud, const std::vector<PathWeights>& poses, PointPackets& packets) {
  const std::size_t padded = packets.count * packet_size;
  packets.radius.assign(packets.count, 0.0f);
  // Velocities do not turn discs; rates that do are looked up in the cloud at each instant.
  const std::size_t turning = cloud.keys.size() == 1 ? 1 : poses.size();
  for (std::size_t pose = 0; pose < poses.size(); ++pose) {
    const SurfelsAt surfels(cloud, poses[pose]);
    std::vector<Eigen::Vector3d>& origins = packets.origins.emplace_back(packets.count);
    UnsetArray<float>& offsets = packets.offsets.emplace_back(3 * padded);
    if (pose < turning) packets.axes.emplace_back(6 * padded);
    UnsetArray<float>& axes = packets.axes.back();
    const SurfelPose& base = cloud.keys[poses[pose].base].pose;
    parallel_for_each_index(packets.count, [&](std::size_t p) {
      std::array<SurfelInstant, packet_size> at;
      Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
      for_each_lane(
          packets, p,
          [&](std::size_t lane, std::uint32_t point) {
            at[lane] = surfels[point];
            low = low.cwiseMin(at[lane].position);
            high = high.cwiseMax(at[lane].position);
          },
          [&](std::uint32_t point) {
            fetch(base.position, point);
            fetch(base.axis_u, point);
            fetch(base.axis_v, point);
            if (poses[pose].velocity != 0.0) fetch(cloud.velocity, point);
          });
      origins[p] = low + (0.5 * high - 0.5 * low);
      float* const offset = offsets.data() + 3 * p * packet_size;
      float* const axis = axes.data() + 6 * p * packet_size;
      double farthest = 0.0;
      for (std::size_t lane = 0; lane < packet_size; ++lane) {
        const Eigen::Vector3d from_origin = at[lane].position - origins[p];
        farthest = std::max(farthest, from_origin.norm() + std::sqrt(at[lane].axis_u.squaredNorm() +
                                                                     at[lane].axis_v.squaredNorm()));
        for (std::size_t i = 0; i < 3; ++i) {
          offset[i * packet_size + lane] = static_cast<float>(from_origin[static_cast<int>(i)]);
          if (pose >= turning) continue;
          axis[i * packet_size + lane] = static_cast<float>(at[lane].axis_u[static_cast<int>(i)]);
          axis[(3 + i) * packet_size + lane] = static_cast<float>(at[lane].axis_v[static_cast<int>(i)]);
        }
      }
      packets.radius[p] = std::max(packets.radius[p], static_cast<float>(farthest * (1.0 + 1e-6)));
    });
  }
}

UnsetArray<float> packed_colors(const SurfelCloud& cloud, double frame, const PointPackets& packets) {
  UnsetArray<float> colors(4 * packets.count * packet_size);
  const LooksAt looks(cloud, frame);
  parallel_for_each_index(packets.count, [&](std::size_t p) {
    for_each_lane(
        packets, p,
        [&](std::size_t lane, std::uint32_t point) {
          const Eigen::Vector4f rgba = looks[point];
          float* const to = colors.data() + 4 * p * packet_size + lane;
          for (std::size_t c = 0; c < 4; ++c) to[c * packet_size] = rgba[static_cast<int>(c)];
        },
        [&](std::uint32_t point) {
          fetch(cloud.color, point);
          fetch(cloud.opacity, point);
        });
  });
  return colors;
}

void pack_colors(const SurfelCloud& cloud, const Exposure& exposure, PointPackets& packets) {
  const auto [first, end] = looks_of(cloud, exposure);
  if (first == end) packets.colors = packed_colors(cloud, exposure.open, packets);
  for (std::size_t k = first; k < end; ++k)
    packets.looks.push_back({cloud.looks[k].frame, packed_colors(cloud, cloud.looks[k].frame, packets)});
}

void pack_sides(const SurfelCloud& cloud, PointPackets& packets) {
  if (std::none_of(cloud.oriented.begin(), cloud.oriented.end(), [](auto known) { return known != 0; }))
    return;
  packets.oriented.assign(packets.count, 0u);
  parallel_for_each_index(packets.count, [&](std::size_t p) {
    for_each_lane(
        packets, p,
        [&](std::size_t lane, std::uint32_t point) {
          if (cloud.is_oriented(point)) packets.oriented[p] |= 1u << lane;
        },
        [&](std::uint32_t point) { fetch(cloud.oriented, point); });
  });
}

PointPackets pack(const Object& object, const Exposure& exposure, const std::vector<double>& frames,
                  const PathGroup& group) {
  const SurfelCloud& cloud = object.cloud;
  PointPackets packets;
  packets.object = &object;
  packets.frames = frames;
  packets.degree = group.degree(cloud);
  packets.spins = group.spins;
  packets.mortal = group.mortal;
  packets.size = group.points.size();
  const std::vector<PathWeights> poses = poses_of(cloud, packets.frames, packets.degree);
  packets.points = order_of(cloud, group.points, poses, exposure);
  packets.count = (packets.size + packet_size - 1) / packet_size;
  // The last packet repeats its last point where it has none.
  packets.points.resize(packets.count * packet_size, packets.points.back());
  packets.lanes.assign(packets.count, (1u << packet_size) - 1u);
  if (const std::size_t rest = packets.size % packet_size; rest != 0)
    packets.lanes.back() = (1u << rest) - 1u;
  pack_poses(cloud, poses, packets);
  pack_colors(cloud, exposure, packets);
  pack_sides(cloud, packets);
  return packets;
}

/// A number that depends on what the points are and not on their order.
std::uint64_t content_hash(const PointPackets& packets, const Exposure& exposure) {
  const Content content(packets.object->cloud,
                        poses_of(packets.object->cloud, packets.frames, packets.degree), exposure);
  std::uint64_t sum = packets.object->two_sided ? 1 : 2;
  sum += reduced(
      packets.size, std::uint64_t{0},
      [&](std::size_t begin, std::size_t end) {
        std::uint64_t part = 0;
        for (std::size_t i = begin; i != end; ++i) part += content.hash(packets.points[i]);
        return part;
      },
      [](std::uint64_t a, std::uint64_t b) { return a + b; });
  for (const double share : {0.0, 0.5, 1.0}) {
    const Eigen::Affine3d world = packets.object->transform.at(exposure.at(share));
    for (int k = 0; k < 12; ++k)
      sum = (sum ^ std::bit_cast<std::uint64_t>(world.affine()(k % 3, k / 3))) * 0xbf58476d1ce4e5b9ULL;
  }
  return sum;
}

}  // namespace

PacketPoints PointPackets::at(std::size_t p, const ObjectInstant& instant, PacketScratch& scratch) const {
  const std::size_t pose = instant.pose;
  const auto blend = static_cast<float>(instant.blend);
  const bool moves = blend > 0.0f && pose + degree < offsets.size();
  const auto field = [&](const std::vector<UnsetArray<float>>& poses, std::size_t fields, std::size_t which) {
    return poses[which].data() + fields * p * packet_size;
  };
  const bool keyed = axes.size() > 1;
  const float *offset = field(offsets, 3, pose), *axis = field(axes, 6, keyed ? pose : 0);
  PacketPoints found{offset, nullptr, axis, nullptr, blend, lanes[p], oriented.empty() ? 0 : oriented[p]};
  if (moves && degree == 1) {
    found.offset_after = field(offsets, 3, pose + 1);
    if (keyed) found.axes_after = field(axes, 6, pose + 1);
  } else if (moves) {
    const auto curved = [&](const std::vector<UnsetArray<float>>& poses, std::size_t fields,
                            const float* from, float* to) {
      const std::size_t numbers = fields * packet_size;
      std::copy(from, from + numbers, to);
      for (std::size_t k = 1; k <= degree; ++k) {
        const auto weight = static_cast<float>(instant.bernstein[k - 1]);
        const float* const control = field(poses, fields, pose + k);
        for (std::size_t i = 0; i < numbers; ++i) to[i] += weight * (control[i] - from[i]);
      }
      return to;
    };
    found.offset = curved(offsets, 3, offset, scratch.offset);
    if (keyed) found.axes = curved(axes, 6, axis, scratch.axes);
  }
  const SurfelCloud& cloud = object->cloud;
  if (spins) {
    const SurfelsAt& surfels = *instant.surfels;
    for (std::size_t lane = 0; lane < packet_size; ++lane) {
      const SurfelInstant at = surfels[points[p * packet_size + lane]];
      for (std::size_t i = 0; i < 3; ++i) {
        scratch.axes[i * packet_size + lane] = static_cast<float>(at.axis_u[static_cast<int>(i)]);
        scratch.axes[(3 + i) * packet_size + lane] = static_cast<float>(at.axis_v[static_cast<int>(i)]);
      }
    }
    found.axes = scratch.axes;
  }
  if (mortal)
    for (std::uint32_t lane = 0; lane < packet_size; ++lane)
      if (!cloud.exists(points[p * packet_size + lane], instant.instant.frame)) found.lanes &= ~(1u << lane);
  return found;
}

void PointPackets::color(std::size_t p, const ObjectInstant& instant, PlacedPacket& placed) const {
  const auto packed = [&](const UnsetArray<float>& all) { return all.data() + 4 * p * packet_size; };
  const float* const from = packed(looks.empty() ? colors : looks[instant.look.before].colors);
  float* const to[4] = {placed.red, placed.green, placed.blue, placed.alpha};
  for (std::size_t c = 0; c < 4; ++c) std::copy_n(from + c * packet_size, packet_size, to[c]);
  if (!(instant.look.share > 0.0f)) return;
  // As LooksAt has it.
  const float* const after = packed(looks[instant.look.after].colors);
  for (std::size_t c = 0; c < 4; ++c)
    for (std::size_t lane = 0; lane < packet_size; ++lane)
      to[c][lane] += instant.look.share * (after[c * packet_size + lane] - to[c][lane]);
}

std::size_t packed_bytes(const Scene& scene, const Exposure& exposure) {
  std::size_t bytes = 0;
  for (const Object& object : scene.objects) {
    if (object.discs() == 0) continue;
    const std::size_t stretches = pose_frames(object.cloud, exposure).size() - 1;
    const std::size_t poses = stretches * path_degree(object.cloud) + 1;
    const std::size_t turning = object.cloud.keys.size() == 1 ? 1 : poses;
    const std::size_t packets = (object.cloud.size() + packet_size - 1) / packet_size;
    const auto [first_look, end_look] = looks_of(object.cloud, exposure);
    const std::size_t looks = std::max<std::size_t>(1, end_look - first_look);
    const std::size_t a_lane = sizeof(float) * (3 * poses + 6 * turning + 4 * looks) + sizeof(std::uint32_t);
    bytes += packets * (packet_size * a_lane + sizeof(Eigen::Vector3d) * poses + sizeof(float) +
                        sizeof(std::uint32_t) * (object.cloud.oriented.empty() ? 1 : 2));
  }
  return bytes;
}

std::vector<PointPackets> pack_points(const Scene& scene, const Exposure& exposure, bool only_standing) {
  std::vector<PointPackets> objects;
  for (const Object& object : scene.objects)
    if (object.discs() > 0 && !(only_standing && !stands_still(scene, object, exposure))) {
      const std::vector<double> frames = pose_frames(object.cloud, exposure);
      for (const PathGroup& group : path_groups(object.cloud, frames))
        objects.push_back(pack(object, exposure, frames, group));
    }
  if (objects.size() < 2) return objects;
  std::vector<std::uint64_t> hashes(objects.size());
  parallel_for_each_index(objects.size(),
                          [&](std::size_t i) { hashes[i] = content_hash(objects[i], exposure); });
  std::vector<std::size_t> order(objects.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return hashes[a] < hashes[b]; });
  std::vector<PointPackets> sorted;
  sorted.reserve(objects.size());
  for (const std::size_t i : order) sorted.push_back(std::move(objects[i]));
  return sorted;
}

}  // namespace swept
