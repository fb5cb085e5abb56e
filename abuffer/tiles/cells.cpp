#include "abuffer/tiles/cells.h"

#include <algorithm>
#include <cmath>

#include "abuffer/parallel.h"

namespace swept {
namespace {

/// Packets that one thread follows before it takes more.
constexpr std::size_t run = 512;

/// Angle by which `object` and camera turn over the exposure, radians, or more.
double turning(const Scene& scene, const Object& object, const Exposure& exposure) {
  const auto over = [&](const auto& keys, const auto& angle) {
    double sum = 0.0;
    for (std::size_t i = 1; i < keys.size(); ++i) {
      const double first = std::max(keys[i - 1].frame, exposure.open),
                   last = std::min(keys[i].frame, exposure.close);
      if (first < last)
        sum += angle(keys[i - 1], keys[i]) * (last - first) / (keys[i].frame - keys[i - 1].frame);
    }
    return sum;
  };
  // Keys of different axes are joined by the shorter arc.
  const double of_object = over(object.transform.keys, [](const TransformKey& a, const TransformKey& b) {
    return std::max(std::abs(b.rotate_radians - a.rotate_radians),
                    (a.rotate_axis - b.rotate_axis).norm() > 0.0 ? M_PI : 0.0);
  });
  const double of_poses = over(scene.camera.poses, [](const CameraKey& a, const CameraKey& b) {
    return a.world_from_camera.angularDistance(b.world_from_camera);
  });
  // A camera that looks at something passing by turns fast where it is near, so that no even share will do.
  double of_looks = 0.0;
  for (std::size_t i = 1; i < scene.camera.look_ats.size(); ++i) {
    const LookAtKey &a = scene.camera.look_ats[i - 1], &b = scene.camera.look_ats[i];
    const bool turns = (a.target - a.eye) != (b.target - b.eye) || a.up != b.up;
    if (turns && std::max(a.frame, exposure.open) < std::min(b.frame, exposure.close)) of_looks += M_PI;
  }
  return of_object + of_poses + of_looks;
}

/// Steps so small that a path hardly bends within one.
int steps_of(const Scene& scene, const PointPackets& packets, const Exposure& exposure) {
  if (stands_still(scene, *packets.object, exposure)) return 0;
  const auto keys_within = [&](const auto& keys) {
    return static_cast<double>(std::count_if(keys.begin(), keys.end(), [&](const auto& key) {
      return key.frame > exposure.open && key.frame < exposure.close;
    }));
  };
  constexpr double step = 0.25, most = 2048.0;
  const double keys = static_cast<double>(packets.frames.size()) +
                      keys_within(packets.object->transform.keys) + keys_within(scene.camera.poses) +
                      keys_within(scene.camera.look_ats);
  return static_cast<int>(std::min(most, std::ceil(turning(scene, *packets.object, exposure) / step) + keys));
}

PacketBounds joined(const PacketBounds& a, const PacketBounds& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.x_min, b.x_min), std::max(a.x_max, b.x_max), std::min(a.y_min, b.y_min),
          std::max(a.y_max, b.y_max), std::min(a.nearest, b.nearest)};
}

/// How far the bounds of the middle lie from half-way between those of the ends.
double bend(const PacketBounds& a, const PacketBounds& middle, const PacketBounds& b) {
  if (a.empty() || middle.empty() || b.empty()) return 0.0;
  const auto off = [](double first, double mid, double last) { return std::abs(mid - 0.5 * (first + last)); };
  const double most = std::max({off(a.x_min, middle.x_min, b.x_min), off(a.x_max, middle.x_max, b.x_max),
                                off(a.y_min, middle.y_min, b.y_min), off(a.y_max, middle.y_max, b.y_max)});
  return std::isfinite(most) ? most : 0.0;
}

}  // namespace

PacketBins::PacketBins(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects)
    : film_(scene.film),
      columns_(static_cast<std::size_t>((film_.width + cell_px - 1) / cell_px)),
      rows_(static_cast<std::size_t>((film_.height + cell_px - 1) / cell_px)),
      motion_(objects.size()),
      starts_(columns_ * rows_ + 1, 0) {
  for (std::size_t object = 0; object < objects.size(); ++object)
    follow(scene, exposure, objects[object], object);
  for (const std::vector<Touch>& touches : touched_)
    for (const Touch& touch : touches) ++starts_[touch.cell + 1];
  for (std::size_t cell = 0; cell < cell_count(); ++cell) starts_[cell + 1] += starts_[cell];
  entries_.resize(starts_.back());
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for (const std::vector<Touch>& touches : touched_)
    for (const Touch& touch : touches) entries_[next[touch.cell]++] = touch.packet;
  touched_.clear();
  touched_.shrink_to_fit();
}

Cell PacketBins::cell(std::size_t index) const {
  const int x = static_cast<int>(index % columns_) * cell_px,
            y = static_cast<int>(index / columns_) * cell_px;
  return {x, y, std::min(cell_px, film_.width - x), std::min(cell_px, film_.height - y)};
}

void PacketBins::follow(const Scene& scene, const Exposure& exposure, const PointPackets& packets,
                        std::size_t object) {
  const int steps = steps_of(scene, packets, exposure);
  std::vector<ObjectInstant> instants;
  instants.reserve(static_cast<std::size_t>(2 * steps + 1));
  for (int i = 0; i <= 2 * steps; ++i)
    instants.emplace_back(scene, packets, steps == 0 ? exposure.open : exposure.at(i / (2.0 * steps)));
  motion_[object].assign(packets.count, 0.0f);
  const std::size_t runs = (packets.count + run - 1) / run, first_run = touched_.size();
  touched_.resize(first_run + runs);
  const double farthest = 4.0 * (film_.width + film_.height);
  parallel_for_each_index(runs, [&](std::size_t r) {
    std::vector<Touch>& touches = touched_[first_run + r];
    std::vector<std::uint32_t> cells;
    for (std::size_t p = r * run; p < std::min((r + 1) * run, packets.count); ++p) {
      cells.clear();
      const auto touch = [&](const PacketBounds& box, double padding) {
        if (box.empty()) return;
        const auto cell = [&](double v, std::size_t count) {
          return static_cast<std::size_t>(
              std::clamp(std::floor(v / cell_px), 0.0, static_cast<double>(count - 1)));
        };
        if (!(box.x_max + padding >= 0.0 && box.x_min - padding <= film_.width &&
              box.y_max + padding >= 0.0 && box.y_min - padding <= film_.height))
          return;
        for (std::size_t y = cell(box.y_min - padding, rows_); y <= cell(box.y_max + padding, rows_); ++y)
          for (std::size_t x = cell(box.x_min - padding, columns_); x <= cell(box.x_max + padding, columns_);
               ++x)
            cells.push_back(static_cast<std::uint32_t>(y * columns_ + x));
      };
      const double radius = double{packets.radius[p]};
      Eigen::Vector3d center = instants[0].center(packets, p);
      PacketBounds before = instants[0].bounds(center, radius);
      double length = 0.0;
      if (steps == 0) touch(before, 0.0);
      for (int step = 0; step < steps; ++step) {
        PacketBounds at[2];
        for (int half = 0; half < 2; ++half) {
          const ObjectInstant& next = instants[static_cast<std::size_t>(2 * step + half + 1)];
          const Eigen::Vector3d moved = next.center(packets, p);
          at[half] = next.bounds(moved, radius);
          if (moved.z() > scene.camera.near && center.z() > scene.camera.near) {
            const double far = (moved.head<2>() / moved.z() - center.head<2>() / center.z()).norm();
            length += std::min(farthest, next.projection.focal_px * far);
          } else if (moved != center) {
            length += 1.0;
          }
          center = moved;
        }
        // A smooth path is nowhere farther from its chord than about where the middle is.
        touch(joined(before, joined(at[0], at[1])), 1.0 + 2.0 * bend(before, at[0], at[1]));
        before = at[1];
      }
      // Whatever may move is not still, however little.
      if (steps > 0) length = std::max(length, 1e-9);
      motion_[object][p] = static_cast<float>(std::min(length, farthest));
      std::sort(cells.begin(), cells.end());
      cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
      for (const std::uint32_t cell : cells)
        touches.push_back({cell, {static_cast<std::uint32_t>(object), static_cast<std::uint32_t>(p)}});
    }
  });
}

}  // namespace swept
