#include "abuffer/resolve/mesh_pixel.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "abuffer/resolve/place_depths.h"
#include "abuffer/resolve/texel_cuts.h"
#include "splat/interval/depth_sum.h"
#include "splat/without_throwing.h"

namespace swept {

void MeshPixel::begin(std::span<PlaceInterval> intervals, const std::vector<TriangleStretch>& triangles,
                      const PlaceRays& rays, const LightOverTime& light, PlaceSweep& sweep,
                      DepthSum* by_depth) {
  triangles_ = &triangles;
  rays_ = &rays;
  light_ = &light;
  sweep_ = &sweep;
  by_depth_ = by_depth;
  tracks_.clear();
  view_.clear();
  times_.clear();
  next_time_ = 0;
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
    const std::size_t place = intervals[first].place % pixel_places, known = view_.pieces.size();
    sweep.cut(intervals.subspan(first, last - first), triangles, rays[place], view_);
    tracks_.push_back({mesh, place, known, view_.pieces.size()});
    first = last;
  }
  for (const PlacePiece& piece : view_.pieces) {
    times_.push_back(piece.begin);
    times_.push_back(piece.end);
  }
  plain_ = std::all_of(view_.seen.begin(), view_.seen.end(),
                       [&](std::uint32_t layer) { return triangles[view_.layers[layer].source].plain; });
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
    while (track.next < track.last && view_.pieces[track.next].end <= begin) ++track.next;
    if (track.next < track.last && view_.pieces[track.next].begin <= begin) on_.push_back(t);
  }
  if (on_.empty() && discs_.empty()) return;
  throw_if_stopped(sweep_->stop);
  list_surfaces();
  find_changes(begin, end);
  for (const double change : changes_) {
    if (!(begin < change && change < end)) continue;
    add_smooth(begin, change, sum);
    begin = change;
    ++sweep_->counters.crossings;
  }
  add_smooth(begin, end, sum);
}

/// Finds when surfaces of different owners change places, in order.
void MeshPixel::find_changes(double begin, double end) {
  changes_.clear();
  pairs_.clear();
  const bool several =
      !on_.empty() && (!discs_.empty() || tracks_[on_.front()].mesh != tracks_[on_.back()].mesh);
  if (!several) return;
  float hidden_from = std::numeric_limits<float>::infinity();
  for (const Surface& surface : surfaces_)
    if (surface.opaque) hidden_from = std::min(hidden_from, surface.farthest);
  for (std::size_t a = 0; a < of_meshes_; ++a)
    for (std::size_t b = a + 1; b < surfaces_.size(); ++b)
      if (surfaces_[a].nearest <= std::min(hidden_from, surfaces_[b].farthest) &&
          surfaces_[b].nearest <= std::min(hidden_from, surfaces_[a].farthest))
        pairs_.push_back({a, b, {}, 0.0});
  if (pairs_.empty()) return;
  // Colours that change may bend a mean of depths wherever they do, and more than this makes no difference.
  const int halvings = plain_ && discs_.empty() ? 12 : 6;
  DepthChanges::find(
      begin, end, halvings, pairs_.size(),
      [&](double time, std::size_t place) {
        look(time);
        for (Pair& pair : pairs_) {
          pair.values[place] = surfaces_[pair.a].depth - surfaces_[pair.b].depth;
          pair.depth = std::max(std::abs(surfaces_[pair.a].depth), std::abs(surfaces_[pair.b].depth));
        }
      },
      [&](std::size_t i) {
        DepthChanges::Values values;
        std::copy_n(pairs_[i].values, values.size(), values.begin());
        return values;
      },
      [&](std::size_t i) { return pairs_[i].depth; }, changes_);
  std::sort(changes_.begin(), changes_.end());
}

void MeshPixel::add_smooth(double begin, double end, LightSum& sum) {
  const auto add_by_depth = [&](double first, double last) {
    if (by_depth_ != nullptr && first < last) add_depths(first, last);
  };
  if (plain_ && discs_.empty()) {
    add_plain(begin, end, sum);
    add_by_depth(light_->share(begin), light_->share(end));
    return;
  }
  for (const Part& part : parts_)
    if (const TriangleStretch& triangle = (*triangles_)[view_.layers[part.layer].source];
        triangle.texture != nullptr)
      add_texel_cuts([&](double time) { return triangle.on_texture((*rays_)[part.place], time); }, begin, end,
                     cuts_);
  between_cuts(begin, end, cuts_, [&](double a, double b) {
    add_light(
        light_->share(a), light_->share(b), *light_, [&](double time) { return light_at(time); }, sum,
        add_by_depth);
  });
}

LightSum MeshPixel::light_at(double time) {
  look(time);
  put_in_order();
  LightSum sum;
  double left = 1.0;
  for (const std::size_t i : order_) {
    const Surface& surface = surfaces_[i];
    for (int c = 0; c < 4; ++c) sum.v[c] += left * surface.rgba[c];
    sum.v[4] += left * surface.rgba[3] * surface.depth;
    left *= 1.0 - surface.rgba[3];
    if (left < double{opaque_transmittance}) break;
  }
  return sum;
}

/// Colours do not change, and depths do.
void MeshPixel::add_plain(double begin, double end, LightSum& sum) {
  const double first = light_->share(begin), last = light_->share(end);
  if (!(first < last)) return;
  throw_if_stopped(sweep_->stop);
  const ThreeNodes nodes(*light_, first, last);
  look(nodes.time[1]);
  put_in_order();
  double left = last - first;
  const double least = double{opaque_transmittance} * left;
  for (const std::size_t i : order_) {
    const Surface& surface = surfaces_[i];
    for (int c = 0; c < 4; ++c) sum.v[c] += left * surface.rgba[c];
    sum.v[4] += left * surface.rgba[3] *
                (ThreeNodes::side * (depth_of(surface, nodes.time[0]) + depth_of(surface, nodes.time[2])) +
                 ThreeNodes::middle * surface.depth);
    left *= 1.0 - surface.rgba[3];
    if (left < least) break;
  }
}

/// Of what is seen at the nodes of these shares of light.
void MeshPixel::add_depths(double first, double last) {
  for_each_node(first, last, *light_, [&](double time, double weight, double begin, double end) {
    const auto depths_at = [&](double at, std::vector<double>& depths) {
      look(at);
      depths.clear();
      for (const Surface& surface : surfaces_) depths.push_back(surface.depth);
    };
    depths_at(begin, begins_);
    depths_at(end, ends_);
    look(time);
    put_in_order();
    double left = 1.0;
    for (const std::size_t i : order_) {
      const Surface& surface = surfaces_[i];
      double rgba[4];
      for (int c = 0; c < 4; ++c) rgba[c] = weight * left * surface.rgba[c];
      by_depth_->add(begins_[i], ends_[i], rgba);
      left *= 1.0 - surface.rgba[3];
      if (left < double{opaque_transmittance}) break;
    }
  });
}

/// Discs keep their order among themselves, and a mesh's surface lies before the first of them that is
/// deeper. What follows the depth of others makes the order of meshes indifferent.
void MeshPixel::put_in_order() {
  order_.clear();
  for (std::size_t i = 0; i < of_meshes_; ++i)
    if (surfaces_[i].rgba[3] > 0.0) order_.push_back(i);
  std::sort(order_.begin(), order_.end(), [&](std::size_t i, std::size_t j) {
    const Surface &a = surfaces_[i], &b = surfaces_[j];
    return std::tie(a.depth, a.rgba[3], a.rgba[0], a.rgba[1], a.rgba[2]) <
           std::tie(b.depth, b.rgba[3], b.rgba[0], b.rgba[1], b.rgba[2]);
  });
  if (of_meshes_ == surfaces_.size()) return;
  among_discs_.clear();
  std::size_t next = 0;
  for (std::size_t disc = of_meshes_; disc < surfaces_.size(); ++disc) {
    for (; next < order_.size() && surfaces_[order_[next]].depth < surfaces_[disc].depth; ++next)
      among_discs_.push_back(order_[next]);
    among_discs_.push_back(disc);
  }
  among_discs_.insert(among_discs_.end(), order_.begin() + static_cast<std::ptrdiff_t>(next), order_.end());
  order_.swap(among_discs_);
}

}  // namespace swept
