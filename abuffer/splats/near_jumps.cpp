#include "abuffer/splats/near_jumps.h"

#include <algorithm>
#include <cmath>

#include "abuffer/parallel.h"
#include "abuffer/splats/placed_lanes.h"
#include "abuffer/splats/posed_packet.h"

namespace swept {
namespace {

/// Side of a film on which splats are followed beyond the real one's edges.
constexpr int wide_film_px = 65536;
/// One of so many pixels each way is looked at.
constexpr int look_px = 8;

/// Of a splat in a pixel, or of a disc at its best.
float alpha_at(const NearSplat& near, float x, float y, float most_alpha) {
  const PlacedSplat& s = near.splat;
  if (near.disc) return std::min(most_alpha, s.opacity);
  const float dx = x - s.pixel_x + s.center_x - 0.5f, dy = y - s.pixel_y + s.center_y - 0.5f;
  const float u = s.ux * dx + s.uy * dy, v = s.vy * dy;
  return std::min(most_alpha, s.opacity * std::exp2(-(u * u + v * v)));
}

}  // namespace

std::optional<NearSplat> at_near_plane(const Scene& scene, const SplatPackets& set, std::size_t packet,
                                       std::size_t lane, double seen_at, double unseen_at,
                                       const SplatMath& math, const CellGrid& grid) {
  const int shift_x = (wide_film_px - grid.film.width) / 2, shift_y = (wide_film_px - grid.film.height) / 2;
  std::optional<PlacedSplat> seen;
  PosedPacket memory;
  const auto look = [&](double frame) {
    SplatPose pose(scene, set, frame);
    pose.view.film_width = pose.view.film_height = wide_film_px;
    SplatOrigin origin = pose.origin(set, packet);
    origin.pixel_x += shift_x, origin.pixel_y += shift_y;
    const PlacedLanes lanes = placed_lanes(math, fields_at(set, packet, pose, memory), pose.view, origin);
    if ((lanes.seen >> lane & 1u) == 0) return false;
    seen = lanes.lanes[lane];
    return true;
  };
  constexpr int halvings = 12;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * seen_at + 0.5 * unseen_at;
    (look(middle) ? seen_at : unseen_at) = middle;
  }
  if (!seen && !look(seen_at)) return std::nullopt;
  NearSplat near{*seen,
                 double{1.0} * seen->x_first - shift_x,
                 double{1.0} * seen->x_last - shift_x,
                 double{1.0} * seen->y_first - shift_y,
                 double{1.0} * seen->y_last - shift_y,
                 set.object->splats.flat};
  near.splat.pixel_x -= static_cast<float>(shift_x);
  near.splat.pixel_y -= static_cast<float>(shift_y);
  const bool on_film = near.x_last >= 0.0 && near.y_last >= 0.0 && near.x_first < grid.film.width &&
                       near.y_first < grid.film.height;
  return on_film ? std::optional(near) : std::nullopt;
}

std::vector<double> near_jumps(const std::vector<NearSplat>& splats, const std::vector<float>& colors,
                               std::size_t columns, int pitch_px, const SplatModel& model, bool linear,
                               const CellGrid& grid) {
  std::vector<double> jumps(grid.size(), 0.0);
  if (splats.empty()) return jumps;
  // Near enough to the curve of sRGB.
  const auto light = [&](float value) { return linear ? value : value * std::abs(value); };
  const auto value = [&](float of_light) {
    return linear ? of_light : std::copysign(std::sqrt(std::abs(of_light)), of_light);
  };
  parallel_for_each_index(grid.size(), [&](std::size_t c) {
    const Cell cell = grid.cell(c);
    double sum = 0.0, looked = 0.0;
    for (int y = cell.y + std::min(look_px, cell.height) / 2; y < cell.y + cell.height; y += look_px)
      for (int x = cell.x + std::min(look_px, cell.width) / 2; x < cell.x + cell.width; x += look_px) {
        looked += 1.0;
        const float* const behind = &colors[3 * (static_cast<std::size_t>(y / pitch_px) * columns +
                                                 static_cast<std::size_t>(x / pitch_px))];
        for (const NearSplat& near : splats) {
          if (x < near.x_first || x > near.x_last || y < near.y_first || y > near.y_last) continue;
          const float alpha = alpha_at(near, static_cast<float>(x), static_cast<float>(y),
                                       static_cast<float>(model.most_alpha));
          if (!(double{alpha} >= model.least_alpha)) continue;
          const float of_splat[3] = {near.splat.red, near.splat.green, near.splat.blue};
          for (int k = 0; k < 3; ++k) {
            const float before = value(behind[k]), after = before + alpha * (of_splat[k] - before);
            sum += std::pow(double{light(after)} - double{behind[k]}, 2);
          }
        }
      }
    if (looked > 0.0) jumps[c] = sum / (3.0 * 4.0 * looked);
  });
  return jumps;
}

}  // namespace swept
