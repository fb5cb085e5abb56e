#include "abuffer/tiles/point_lists.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "abuffer/parallel.h"

namespace swept {
namespace {

/// Rounding of floats, and more.
constexpr double rounding = 1e-6;

/// Whether an object's packets touch so many more cells than points that move as far that it pays to follow
/// each.
bool come_apart(const PointPackets& packets, std::size_t object, const PacketBins& bins) {
  // More would take long to follow, and are close enough together.
  constexpr std::size_t most = 100'000;
  if (packets.size > most || packets.spins || packets.mortal || !packets.looks.empty()) return false;
  double by_packets = 0.0, by_points = 0.0;
  for (std::size_t p = 0; p < packets.count; ++p) {
    const PacketRef ref{static_cast<std::uint32_t>(object), static_cast<std::uint32_t>(p)};
    const double motion = double{bins.motion_px(ref)};
    if (motion == 0.0) return false;
    if (bins.cells_touched(ref) == 0.0f) continue;
    by_packets += double{bins.cells_touched(ref)};
    by_points += 1.5 * (1.0 + motion / cell_px);
  }
  return by_packets > 2.0 * by_points;
}

Eigen::Vector3d offset_of(const PointPackets& packets, std::size_t pose, std::size_t i) {
  const float* const at =
      packets.offsets[pose].data() + 3 * (i / packet_size) * packet_size + i % packet_size;
  return {double{at[0]}, double{at[packet_size]}, double{at[2 * packet_size]}};
}

/// How far a point's disc reaches in any pose, and what its place may be off by.
double reach_of(const PointPackets& packets, std::size_t i) {
  double reach = 0.0, off = 0.0;
  for (const auto& axes : packets.axes) {
    const float* const axis = axes.data() + 6 * (i / packet_size) * packet_size + i % packet_size;
    double squares = 0.0;
    for (int k = 0; k < 6; ++k) squares += double{axis[k * packet_size]} * double{axis[k * packet_size]};
    reach = std::max(reach, std::sqrt(squares));
  }
  for (std::size_t pose = 0; pose < packets.offsets.size(); ++pose)
    off = std::max(off, offset_of(packets, pose, i).norm());
  return reach * (1.0 + rounding) + rounding * off;
}

/// A packet for each point, which knows where it is and how large, and no more.
PointPackets points_of(const PointPackets& packets) {
  PointPackets points;
  points.object = packets.object;
  points.count = points.size = packets.size;
  points.degree = packets.degree;
  points.frames = packets.frames;
  points.radius.resize(packets.size);
  points.origins.assign(packets.origins.size(), std::vector<Eigen::Vector3d>(packets.size));
  parallel_for_each_index(packets.size, [&](std::size_t i) {
    points.radius[i] = static_cast<float>(reach_of(packets, i) * (1.0 + rounding));
    for (std::size_t pose = 0; pose < packets.origins.size(); ++pose)
      points.origins[pose][i] = packets.origins[pose][i / packet_size] + offset_of(packets, pose, i);
  });
  return points;
}

/// Points `of` an object in packets of their own, in that order.
PointPackets packed(const PointPackets& packets, const PointPackets& points, std::span<const PacketRef> of) {
  PointPackets own;
  own.object = packets.object;
  own.size = of.size();
  own.count = (of.size() + packet_size - 1) / packet_size;
  own.degree = packets.degree;
  own.frames = packets.frames;
  own.lanes.assign(own.count, (1u << packet_size) - 1u);
  if (const std::size_t rest = of.size() % packet_size; rest != 0) own.lanes.back() = (1u << rest) - 1u;
  own.radius.assign(own.count, 0.0f);
  own.points.resize(own.count * packet_size);
  own.colors.resize(4 * own.points.size());
  if (!packets.oriented.empty()) own.oriented.assign(own.count, 0u);
  // The last packet repeats its last point where it has none.
  const auto from = [&](std::size_t i) -> std::size_t { return of[std::min(i, of.size() - 1)].packet; };
  const auto copy = [&](const auto& values, auto& to, std::size_t fields) {
    for (std::size_t i = 0; i < own.points.size(); ++i)
      for (std::size_t k = 0; k < fields; ++k)
        to[(fields * (i / packet_size) + k) * packet_size + i % packet_size] =
            values[(fields * (from(i) / packet_size) + k) * packet_size + from(i) % packet_size];
  };
  copy(packets.points, own.points, 1);
  copy(packets.colors, own.colors, 4);
  for (const auto& axes : packets.axes) {
    own.axes.emplace_back(6 * own.points.size());
    copy(axes, own.axes.back(), 6);
  }
  for (std::size_t i = 0; i < of.size() && !packets.oriented.empty(); ++i)
    own.oriented[i / packet_size] |= (packets.oriented[from(i) / packet_size] >> from(i) % packet_size & 1u)
                                     << i % packet_size;
  for (std::size_t pose = 0; pose < packets.origins.size(); ++pose) {
    std::vector<Eigen::Vector3d>& origins = own.origins.emplace_back(own.count);
    auto& offsets = own.offsets.emplace_back(3 * own.points.size());
    for (std::size_t p = 0; p < own.count; ++p) {
      Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
      for (std::size_t lane = 0; lane < packet_size; ++lane) {
        const Eigen::Vector3d& at = points.origins[pose][from(p * packet_size + lane)];
        low = low.cwiseMin(at);
        high = high.cwiseMax(at);
      }
      origins[p] = low + (0.5 * high - 0.5 * low);
      for (std::size_t lane = 0; lane < packet_size; ++lane) {
        const std::size_t i = from(p * packet_size + lane);
        const Eigen::Vector3d offset = points.origins[pose][i] - origins[p];
        for (int k = 0; k < 3; ++k)
          offsets[3 * p * packet_size + static_cast<std::size_t>(k) * packet_size + lane] =
              static_cast<float>(offset[k]);
        own.radius[p] = std::max(
            own.radius[p], static_cast<float>((offset.norm() + double{points.radius[i]}) * (1.0 + rounding)));
      }
    }
  }
  return own;
}

}  // namespace

PointLists::PointLists(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects,
                       const PacketBins& bins)
    : objects_(objects), bins_(bins) {
  for (std::size_t object = 0; object < objects.size(); ++object)
    if (come_apart(objects[object], object, bins)) {
      followed_.push_back(object);
      points_.push_back(points_of(objects[object]));
    }
  if (!followed_.empty()) passing_.emplace(scene, exposure, points_);
}

std::optional<CellPackets> PointLists::of(std::size_t cell) const {
  if (!passing_) return std::nullopt;
  const std::span<const PacketRef> packets = bins_.packets(cell), passing = passing_->packets(cell);
  CellPackets found;
  for (std::size_t k = 0; k < followed_.size(); ++k) {
    const auto range = [](std::span<const PacketRef> all, std::size_t object) {
      const auto before = [](const PacketRef& ref, std::size_t o) { return ref.object < o; };
      const auto begin = std::lower_bound(all.begin(), all.end(), object, before);
      return std::span(begin, std::lower_bound(begin, all.end(), object + 1, before));
    };
    const std::span<const PacketRef> wide = range(packets, followed_[k]), of = range(passing, k);
    const std::size_t count = (of.size() + packet_size - 1) / packet_size;
    if (3 * count > 2 * wide.size() || wide.empty()) continue;
    if (found.own.empty()) {
      found.own.reserve(followed_.size());
      for (const PointPackets& object : objects_) found.objects.push_back(&object);
    }
    found.own.push_back(packed(objects_[followed_[k]], points_[k], of));
    found.objects[followed_[k]] = &found.own.back();
  }
  if (found.own.empty()) return std::nullopt;
  for (std::size_t i = 0; i < packets.size();) {
    const std::uint32_t object = packets[i].object;
    const bool own = found.objects[object] != &objects_[object];
    for (std::uint32_t p = 0; own && p < found.objects[object]->count; ++p) found.refs.push_back({object, p});
    for (; i < packets.size() && packets[i].object == object; ++i)
      if (!own) found.refs.push_back(packets[i]);
  }
  return found;
}

}  // namespace swept
