#include "abuffer/splats/film_motion.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <tuple>

#include "abuffer/parallel.h"
#include "abuffer/splats/placed_lanes.h"
#include "abuffer/splats/posed_packet.h"
#include "abuffer/tiles/path_frames.h"

namespace swept {
namespace {

/// Packets that one thread follows before it takes more.
constexpr std::size_t packets_a_run = 128;

/// Side of a film on which splats are followed beyond the real one's edges.
constexpr int wide_film_px = 65536;

double center_x(const PlacedSplat& s) { return double{s.pixel_x} + 0.5 - double{s.center_x}; }
double center_y(const PlacedSplat& s) { return double{s.pixel_y} + 0.5 - double{s.center_y}; }

struct Box {
  double x_first, x_last, y_first, y_last;

  explicit Box(const PlacedSplat& s)
      : x_first(s.x_first), x_last(s.x_last), y_first(s.y_first), y_last(s.y_last) {}
  void join(const Box& other) {
    x_first = std::min(x_first, other.x_first), x_last = std::max(x_last, other.x_last);
    y_first = std::min(y_first, other.y_first), y_last = std::max(y_last, other.y_last);
  }
  /// How far the middle one of three lies from half-way between the others.
  static double bend(const Box& a, const Box& m, const Box& b) {
    const auto off = [](double first, double middle, double last) {
      return std::abs(middle - 0.5 * (first + last));
    };
    return std::max(std::max(off(a.x_first, m.x_first, b.x_first), off(a.x_last, m.x_last, b.x_last)),
                    std::max(off(a.y_first, m.y_first, b.y_first), off(a.y_last, m.y_last, b.y_last)));
  }
};

/// Training time that passes during the exposure.
double clip_time(const SplatPackets& set, const Exposure& exposure) {
  const auto& motion = set.object->splats.motion;
  return motion ? (exposure.close - exposure.open) / motion->frames : 0.0;
}

/// The exposure in standard deviations of how a splat comes and goes, of those that move by themselves.
double fade_of(const SplatPackets& set, std::size_t packet, std::size_t lane, const Exposure& exposure) {
  constexpr double most = 1e6;
  const float duration =
      set.motions[(own_numbers * packet + own_duration) * static_cast<std::size_t>(packet_size) + lane];
  return std::min(most, std::sqrt(2.0) * clip_time(set, exposure) / double{duration});
}

/// Whether it is there at any time of the exposure.
bool comes(const SplatPackets& set, std::size_t packet, std::size_t lane, double open, double close,
           double least_alpha) {
  constexpr auto lanes = static_cast<std::size_t>(packet_size);
  const auto number = [&](std::size_t which) {
    return double{set.motions[(own_numbers * packet + which) * lanes + lane]};
  };
  if ((set.lanes[packet] >> lane & 1u) == 0) return false;
  const double nearest = std::clamp(number(own_center), open, close) - number(own_center),
               share = nearest / number(own_duration);
  return double{set.opacities[packet * lanes + lane]} * std::exp(-share * share) >= least_alpha;
}

/// Frames at which splats that move by themselves are looked at besides: their paths are cubic, and what
/// fades is nowhere at the exposure's ends.
std::vector<double> frames_of_clip(const SplatPackets& set, const Exposure& exposure) {
  const double time = clip_time(set, exposure);
  if (time == 0.0) return {exposure.open, exposure.close};
  constexpr double a_clip = 64.0, least = 4.0, most = 32.0;
  const int steps = static_cast<int>(std::clamp(std::ceil(a_clip * time), least, most));
  std::vector<double> frames;
  for (int i = 0; i <= steps; ++i) frames.push_back(exposure.at(static_cast<double>(i) / steps));
  return frames;
}

void largest(std::atomic<float>& most, float value) {
  float seen = most.load(std::memory_order_relaxed);
  while (seen < value && !most.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
  }
}

}  // namespace

FilmMotion::FilmMotion(const Scene& scene, const Exposure& exposure, const std::vector<SplatPackets>& sets,
                       const SplatMath& math, const CellGrid& grid)
    : touched_(grid.size(), 0), spread_(grid.size(), 0.0f) {
  of_sets_.resize(sets.size());
  for (std::size_t i = 0; i < sets.size(); ++i)
    if (sets[i].moves) follow(scene, exposure, sets[i], math, grid, of_sets_[i]);
  // Threads found them in an order of their own, and what is summed up must not depend on it.
  std::sort(near_splats_.begin(), near_splats_.end(), [](const NearSplat& a, const NearSplat& b) {
    const auto key = [](const NearSplat& near) {
      const PlacedSplat& s = near.splat;
      return std::tie(s.depth, s.pixel_x, s.pixel_y, s.center_x, s.center_y, s.opacity, s.red, s.green,
                      s.blue, s.ux, s.uy, s.vy);
    };
    return key(a) < key(b);
  });
}

void FilmMotion::follow(const Scene& scene, const Exposure& exposure, const SplatPackets& set,
                        const SplatMath& math, const CellGrid& grid, Paths& paths) {
  std::vector<double> frames = path_frames(scene, *set.object, frames_of_clip(set, exposure), exposure);
  // What turns too fast to be followed may be anywhere, and so may all where the camera moves; what fades may
  // be seen between two looks alone.
  const bool own = !set.motions.empty();
  const bool anywhere = frames.empty() || own || !scene.camera.constant_over(exposure.open, exposure.close);
  if (frames.empty()) frames = {exposure.open, exposure.close};
  // Where all cells are taken for touched, a path need not be followed that closely.
  constexpr std::size_t enough = 33;
  if (anywhere && frames.size() > enough) {
    frames.clear();
    for (std::size_t i = 0; i < enough; ++i)
      frames.push_back(exposure.at(static_cast<double>(i) / (enough - 1)));
  }
  std::vector<double> looks;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i > 0) looks.push_back(0.5 * frames[i - 1] + 0.5 * frames[i]);
    looks.push_back(frames[i]);
  }
  std::vector<SplatPose> poses;
  poses.reserve(looks.size());
  for (const double frame : looks) poses.emplace_back(scene, set, frame);
  const int shift_x = (wide_film_px - grid.film.width) / 2, shift_y = (wide_film_px - grid.film.height) / 2;
  for (SplatPose& pose : poses) pose.view.film_width = pose.view.film_height = wide_film_px;

  paths.assign(set.count * static_cast<std::size_t>(packet_size), Path{});
  std::vector<std::atomic<char>> touched(grid.size());
  std::atomic<bool> lost{anywhere};
  std::mutex near_mutex;
  std::atomic<float> fastest{fastest_px_}, widest{fastest_spread_}, briefest{briefest_};
  const double clip_open = poses.front().clip_time, clip_close = poses.back().clip_time;
  parallel_for_each_index((set.count + packets_a_run - 1) / packets_a_run, [&](std::size_t r) {
    std::vector<PlacedLanes> at(poses.size());
    std::vector<PosedPacket> posed(poses.size());
    for (std::size_t p = r * packets_a_run; p < std::min((r + 1) * packets_a_run, set.count); ++p) {
      for (std::size_t k = 0; k < poses.size(); ++k) {
        SplatOrigin origin = poses[k].origin(set, p);
        origin.pixel_x += shift_x, origin.pixel_y += shift_y;
        at[k] = placed_lanes(math, fields_at(set, p, poses[k], posed[k]), poses[k].view, origin);
      }
      for (std::size_t lane = 0; lane < static_cast<std::size_t>(packet_size); ++lane) {
        const auto seen = [&](std::size_t k) { return (at[k].seen >> lane & 1u) != 0; };
        const auto faded = [&](std::size_t k) { return own && posed[k].opacity[lane] == 0.0f; };
        double length = 0.0, spread = 0.0, way_x = 0.0, way_y = 0.0;
        for (std::size_t k = 0; k + 1 < at.size(); ++k) {
          if (!seen(k) || !seen(k + 1)) {
            // Through the near plane, or from far away; who fades does neither.
            if (seen(k) != seen(k + 1) && !faded(k) && !faded(k + 1)) {
              lost.store(true, std::memory_order_relaxed);
              const std::optional<NearSplat> near = at_near_plane(
                  scene, set, p, lane, looks[seen(k) ? k : k + 1], looks[seen(k) ? k + 1 : k], math, grid);
              if (near) {
                const std::lock_guard lock(near_mutex);
                near_splats_.push_back(*near);
              }
            }
            continue;
          }
          const PlacedSplat &a = at[k].lanes[lane], &b = at[k + 1].lanes[lane];
          const double dx = center_x(b) - center_x(a), dy = center_y(b) - center_y(a);
          length += std::hypot(dx, dy);
          way_x += dx, way_y += dy;
          spread += 0.5 * (in_deviations(a, dx, dy) + in_deviations(b, dx, dy));
        }
        largest(fastest, static_cast<float>(length));
        largest(widest, static_cast<float>(spread));
        const double straight = std::hypot(way_x, way_y),
                     longer = straight > 1e-6 * length ? length / straight : 0.0;
        Path& path = paths[p * static_cast<std::size_t>(packet_size) + lane];
        path.way = {static_cast<float>(longer * way_x), static_cast<float>(longer * way_y),
                    static_cast<float>(spread)};
        if (own) {
          path.fade = static_cast<float>(fade_of(set, p, lane, exposure));
          if (comes(set, p, lane, clip_open, clip_close, scene.splats.least_alpha))
            largest(briefest, path.fade);
        }
        if (seen(0)) path.first_depth = at.front().lanes[lane].depth;
        if (seen(at.size() - 1)) path.last_depth = at.back().lanes[lane].depth;
        if (anywhere) continue;
        for (std::size_t k = 0; k + 2 < at.size(); k += 2) {
          if (!seen(k) || !seen(k + 1) || !seen(k + 2)) continue;
          const Box first(at[k].lanes[lane]), middle(at[k + 1].lanes[lane]), last(at[k + 2].lanes[lane]);
          Box box = first;
          box.join(middle);
          box.join(last);
          // A smooth path is nowhere farther from its chord than about where the middle is.
          const double padding = 1.0 + 2.0 * Box::bend(first, middle, last);
          const double left = box.x_first - shift_x - padding, right = box.x_last - shift_x + padding;
          const double top = box.y_first - shift_y - padding, bottom = box.y_last - shift_y + padding;
          if (right < 0.0 || bottom < 0.0 || left >= grid.film.width || top >= grid.film.height) continue;
          const auto cell = [](double px, std::size_t count) {
            return static_cast<std::size_t>(
                std::clamp(std::floor(px / cell_px), 0.0, static_cast<double>(count - 1)));
          };
          for (std::size_t y = cell(top, grid.rows); y <= cell(bottom, grid.rows); ++y)
            for (std::size_t x = cell(left, grid.columns); x <= cell(right, grid.columns); ++x)
              touched[y * grid.columns + x].store(1, std::memory_order_relaxed);
        }
      }
    }
  });
  fastest_px_ = fastest, fastest_spread_ = widest, briefest_ = briefest;
  for (std::size_t cell = 0; cell < grid.size(); ++cell)
    if (lost || touched[cell] != 0) touched_[cell] = 1;
}

int first_splat_instants(float spread, double max_error_db) {
  // The error falls as a bell's spectrum does: its logarithm with the square of N.
  const double scale = std::sqrt(std::max(0.1, (max_error_db - 17.0) / 43.0));
  const double wanted = std::max(2.0, (1.0 + 0.5 * double{spread}) * scale);
  int count = 2;
  while (count < wanted && count < (1 << 14))
    count = (count & (count - 1)) == 0 ? count + count / 2 : count / 3 * 4;
  return count;
}

}  // namespace swept
