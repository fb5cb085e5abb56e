#include "abuffer/resolve/mesh_pixel.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "abuffer/resolve/place_depths.h"
#include "abuffer/resolve/texel_cuts.h"
#include "splat/without_throwing.h"

namespace swept {

void MeshPixel::mesh_surfaces(std::size_t first, std::size_t last, double time) {
  const auto pieces_of = [&](std::size_t i) -> const PlacePiece& {
    const Track& track = tracks_[on_[i]];
    return track.pieces[track.next];
  };
  std::uint32_t most = 0;
  for (std::size_t i = first; i < last; ++i) most = std::max(most, pieces_of(i).count);
  double light[pixel_places];
  std::fill(light, light + pixel_places, 1.0);
  for (std::uint32_t layer = 0; layer < most; ++layer) {
    double before = 0.0;
    for (const double l : light) before += l / pixel_places;
    if (!(before > double{opaque_transmittance})) return;
    Surface surface{0.0, {0.0, 0.0, 0.0, 0.0}, tracks_[on_[first]].mesh, layer};
    for (std::size_t i = first; i < last; ++i) {
      const PlacePiece& piece = pieces_of(i);
      if (piece.count <= layer) continue;
      const Track& track = tracks_[on_[i]];
      const TriangleStretch::Look seen =
          (*triangles_)[track.seen[piece.first + layer]].look((*rays_)[track.place], time);
      double& left = light[track.place];
      const double share = left / pixel_places;
      for (int c = 0; c < 4; ++c) surface.rgba[c] += share * seen.rgba[c];
      surface.depth += share * seen.rgba[3] * seen.depth;
      left *= 1.0 - seen.rgba[3];
    }
    if (!(surface.rgba[3] > 0.0)) continue;
    surface.depth /= surface.rgba[3];
    for (double& v : surface.rgba) v /= before;
    surfaces_.push_back(surface);
  }
}

void MeshPixel::look(double time) {
  throw_if_stopped(sweep_->stop);
  surfaces_.clear();
  for (std::size_t first = 0; first < on_.size();) {
    std::size_t last = first + 1;
    while (last < on_.size() && tracks_[on_[last]].mesh == tracks_[on_[first]].mesh) ++last;
    mesh_surfaces(first, last, time);
    first = last;
  }
  // What follows the depth makes the order of meshes indifferent.
  std::sort(surfaces_.begin(), surfaces_.end(), [](const Surface& a, const Surface& b) {
    return std::tie(a.depth, a.rgba[3], a.rgba[0], a.rgba[1], a.rgba[2]) <
           std::tie(b.depth, b.rgba[3], b.rgba[0], b.rgba[1], b.rgba[2]);
  });
  if (!discs_.empty()) merge_discs(time);
}

/// Discs keep their order among themselves, and a mesh's surface lies before the first of them that is
/// deeper.
void MeshPixel::merge_discs(double time) {
  const double share = light_->share(time);
  const double at = last_share_ > first_share_ ? (share - first_share_) / (last_share_ - first_share_) : 0.5;
  merged_.clear();
  std::size_t next = 0;
  for (std::uint32_t i = 0; i < discs_.size(); ++i) {
    const MovingSurface::Look look = discs_[i].at(*model_, share - first_share_, at);
    Surface disc{look.depth, {look.rgba[0], look.rgba[1], look.rgba[2], look.rgba[3]}, of_discs, i};
    for (; next < surfaces_.size() && surfaces_[next].depth < disc.depth; ++next)
      merged_.push_back(surfaces_[next]);
    merged_.push_back(disc);
  }
  merged_.insert(merged_.end(), surfaces_.begin() + static_cast<std::ptrdiff_t>(next), surfaces_.end());
  surfaces_.swap(merged_);
}

LightSum MeshPixel::light_at(double time) {
  look(time);
  LightSum sum;
  double left = 1.0;
  for (const Surface& surface : surfaces_) {
    for (int c = 0; c < 4; ++c) sum.v[c] += left * surface.rgba[c];
    sum.v[4] += left * surface.rgba[3] * surface.depth;
    left *= 1.0 - surface.rgba[3];
    if (left < double{opaque_transmittance}) break;
  }
  return sum;
}

/// Of what light_at() saw at the nodes of these shares of light.
void MeshPixel::add_depths(double first, double last) {
  for_each_node(first, last, *light_, [&](double time, double weight, double begin, double end) {
    look(begin);
    as_begins_ = surfaces_;
    look(end);
    as_ends_ = surfaces_;
    look(time);
    const auto depth = [](const std::vector<Surface>& of, const Surface& surface) {
      for (const Surface& s : of)
        if (s.mesh == surface.mesh && s.layer == surface.layer) return s.depth;
      return surface.depth;
    };
    double left = 1.0;
    for (const Surface& surface : surfaces_) {
      double rgba[4];
      for (int c = 0; c < 4; ++c) rgba[c] = weight * left * surface.rgba[c];
      by_depth_->add(depth(as_begins_, surface), depth(as_ends_, surface), rgba);
      left *= 1.0 - surface.rgba[3];
      if (left < double{opaque_transmittance}) break;
    }
  });
}

MeshPixel::Order MeshPixel::order_at(double time) {
  look(time);
  Order order;
  double left = 1.0;
  for (const Surface& surface : surfaces_) {
    order.emplace_back(surface.mesh, surface.layer);
    // What changes places behind an opaque disc is not seen.
    left *= 1.0 - surface.rgba[3];
    if (!discs_.empty() && left < double{opaque_transmittance}) break;
  }
  return order;
}

void MeshPixel::begin(std::span<PlaceInterval> intervals, const std::vector<TriangleStretch>& triangles,
                      const PlaceRays& rays, const LightOverTime& light, PlaceSweep& sweep,
                      DepthSum* by_depth) {
  triangles_ = &triangles;
  rays_ = &rays;
  light_ = &light;
  sweep_ = &sweep;
  by_depth_ = by_depth;
  tracks_.clear();
  times_.clear();
  next_time_ = 0;
  plain_ = true;
  discs_ = {};
  std::stable_sort(intervals.begin(), intervals.end(), [](const PlaceInterval& a, const PlaceInterval& b) {
    return std::tie(a.place, a.source) < std::tie(b.place, b.source);
  });
  nearest_ = std::numeric_limits<float>::infinity();
  for (const PlaceInterval& i : intervals) nearest_ = std::min(nearest_, i.nearest);
  for (std::size_t first = 0; first < intervals.size();) {
    const auto mesh_of = [&](std::size_t i) { return triangles[intervals[i].source].mesh; };
    std::size_t last = first + 1;
    while (last < intervals.size() && intervals[last].place == intervals[first].place &&
           mesh_of(last) == mesh_of(first))
      ++last;
    const std::uint32_t mesh = mesh_of(first);
    const std::size_t place = intervals[first].place % pixel_places;
    sweep.cut(intervals.subspan(first, last - first), triangles, rays[place]);
    tracks_.push_back({mesh, place, sweep.pieces(), sweep.seen()});
    for (const PlacePiece& piece : sweep.pieces()) {
      times_.push_back(piece.begin);
      times_.push_back(piece.end);
    }
    for (const std::uint32_t t : sweep.seen()) plain_ = plain_ && triangles[t].plain;
    first = last;
  }
  std::stable_sort(tracks_.begin(), tracks_.end(),
                   [](const Track& a, const Track& b) { return a.mesh < b.mesh; });
  std::sort(times_.begin(), times_.end());
  times_.erase(std::unique(times_.begin(), times_.end()), times_.end());
}

void MeshPixel::add(double from, double to, LightSum& sum) {
  for (double begin = from; begin < to;) {
    while (next_time_ < times_.size() && times_[next_time_] <= begin) ++next_time_;
    const double end = next_time_ < times_.size() ? std::min(to, times_[next_time_]) : to;
    add_between_events(begin, end, sum);
    begin = end;
  }
}

void MeshPixel::add(double from, double to, std::span<const MovingSurface> discs, const SurfaceModel& model,
                    LightSum& sum) {
  model_ = &model;
  discs_ = discs;
  first_share_ = light_->share(from);
  last_share_ = light_->share(to);
  add(from, to, sum);
  discs_ = {};
}

void MeshPixel::add_between_events(double begin, double end, LightSum& sum) {
  on_.clear();
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    Track& track = tracks_[t];
    while (track.next < track.pieces.size() && track.pieces[track.next].end <= begin) ++track.next;
    if (track.next < track.pieces.size() && track.pieces[track.next].begin <= begin) on_.push_back(t);
  }
  if (on_.empty() && discs_.empty()) return;
  const bool even = plain_ && discs_.empty();
  const auto add_smooth = [&](double from, double to) {
    for (const std::size_t t : on_) {
      const Track& track = tracks_[t];
      const PlacePiece& piece = track.pieces[track.next];
      for (std::uint32_t i = piece.first; i < piece.first + piece.count; ++i)
        if (const TriangleStretch& triangle = (*triangles_)[track.seen[i]]; triangle.texture != nullptr)
          add_texel_cuts(triangle, (*rays_)[track.place], from, to, cuts_);
    }
    between_cuts(from, to, cuts_, [&](double a, double b) {
      add_light(
          light_->share(a), light_->share(b), even, *light_, [&](double time) { return light_at(time); }, sum,
          [&](double first, double last) {
            if (by_depth_ != nullptr) add_depths(first, last);
          });
    });
  };
  const bool may_cross =
      !on_.empty() && (!discs_.empty() || tracks_[on_.front()].mesh != tracks_[on_.back()].mesh);
  // They change places where the depths of their surfaces do.
  for (int changes = 0; may_cross && changes < 64; ++changes) {
    const double hair = 0x1p-40 * (end - begin);
    if (!(begin + hair < end - hair)) break;
    const Order first = order_at(begin + hair);
    double same = begin + hair, other = end - hair;
    if (order_at(other) == first) {
      other = 0.5 * begin + 0.5 * end;
      if (order_at(other) == first) break;
    }
    while (other - same > 0x1p-44) {
      const double half = 0.5 * same + 0.5 * other;
      if (!(same < half && half < other)) break;
      (order_at(half) == first ? same : other) = half;
    }
    add_smooth(begin, other);
    begin = other;
    ++sweep_->counters.crossings;
  }
  add_smooth(begin, end);
}

}  // namespace swept
