#include "abuffer/resolve/place_sweep.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <tuple>

#include "splat/interval/composite.h"
#include "splat/without_throwing.h"

namespace swept {

void PlaceSweep::cut(std::span<PlaceInterval> intervals, const std::vector<TriangleStretch>& triangles,
                     const Eigen::Vector3d& ray, PlaceView& view) {
  triangles_ = &triangles;
  ray_ = &ray;
  view_ = &view;
  first_piece_ = view.pieces.size();
  // The order of sources is that of the mesh, whatever the tile.
  std::sort(intervals.begin(), intervals.end(), [](const PlaceInterval& a, const PlaceInterval& b) {
    return std::tie(a.begin, a.source, a.end) < std::tie(b.begin, b.source, b.end);
  });
  const auto first = static_cast<std::uint32_t>(view.layers.size());
  for (const PlaceInterval& i : intervals) {
    const TriangleStretch& t = triangles[i.source];
    view.layers.push_back(
        {i.begin, i.end, i.nearest, i.farthest, i.source, PlaceLayer::none, t.least_alpha, t.opaque, false});
  }
  active_.clear();
  near_.clear();
  crossings_.clear();
  const auto last = static_cast<std::uint32_t>(view.layers.size());
  std::uint32_t next = first;
  for (double begin = 0.0; next < last || !active_.empty();) {
    throw_if_stopped(stop);
    if (active_.empty()) begin = view.layers[next].begin;
    while (next < last && view.layers[next].begin <= begin) active_.push_back(next++);
    find_near(begin);
    find_crossings(begin);
    double end = next < last ? view.layers[next].begin : std::numeric_limits<double>::infinity();
    for (const std::uint32_t i : active_) end = std::min(end, view.layers[i].end);
    bool crossed = false;
    for (; !crossings_.empty() && crossings_.front() <= begin; crossings_.pop_back(), crossed = true)
      std::pop_heap(crossings_.begin(), crossings_.end(), std::greater<>());
    if (!crossings_.empty()) end = std::min(end, crossings_.front());
    order(0.5 * begin + 0.5 * end, crossed);
    see(begin, end);
    begin = end;
    std::erase_if(active_, [&](std::uint32_t i) { return view.layers[i].end <= begin; });
  }
}

/// Leaves in near_ what is still there and may be seen, and puts into new_ what comes to be.
void PlaceSweep::find_near(double begin) {
  std::vector<PlaceLayer>& layers = view_->layers;
  float hidden_from = std::numeric_limits<float>::infinity();
  for (const std::uint32_t i : active_)
    if (layers[i].opaque) hidden_from = std::min(hidden_from, layers[i].farthest);
  std::erase_if(near_, [&](std::uint32_t i) {
    layers[i].near = layers[i].end > begin && layers[i].nearest <= hidden_from;
    return !layers[i].near;
  });
  new_.clear();
  for (const std::uint32_t i : active_)
    if (!layers[i].near && layers[i].nearest <= hidden_from) new_.push_back(i);
}

/// Of what is new and all others that are near: each pair once, over all the time that both are there, so
/// that what begins or ends behind them changes no bit.
void PlaceSweep::find_crossings(double begin) {
  std::vector<PlaceLayer>& layers = view_->layers;
  const std::size_t known = crossings_.size();
  const auto meet = [&](std::uint32_t one, std::uint32_t other) {
    const PlaceLayer &a = layers[one], &b = layers[other];
    if (a.farthest < b.nearest || b.farthest < a.nearest) return;
    // In one order, whichever came first.
    const std::uint32_t low = a.source < b.source ? one : other, high = low == one ? other : one;
    (void)depth(low);
    const PlaceDepth& of_high = depth(high);
    PlaceDepth::add_crossings(depth(low), of_high, std::max(a.begin, b.begin), std::min(a.end, b.end),
                              crossings_);
  };
  for (std::size_t i = 0; i < new_.size(); ++i) {
    throw_if_stopped(stop);
    layers[new_[i]].near = true;
    for (const std::uint32_t other : near_) meet(new_[i], other);
    for (std::size_t k = 0; k < i; ++k) meet(new_[i], new_[k]);
  }
  const auto found = crossings_.begin() + static_cast<std::ptrdiff_t>(known);
  crossings_.erase(std::remove_if(found, crossings_.end(), [&](double t) { return !(t > begin); }),
                   crossings_.end());
  counters.crossings += crossings_.size() - known;
  for (std::size_t i = known; i < crossings_.size(); ++i)
    std::push_heap(crossings_.begin(), crossings_.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                   std::greater<>());
}

/// Puts near_ and new_ into near_, by depth at that time; equal depths as the mesh has them.
void PlaceSweep::order(double time, bool crossed) {
  const auto before = [&](std::uint32_t one, std::uint32_t other) {
    const PlaceLayer &a = view_->layers[one], &b = view_->layers[other];
    if (a.farthest < b.nearest) return true;
    if (b.farthest < a.nearest) return false;
    (void)depth(one);
    const double of_other = depth(other).at(time), of_one = depth(one).at(time);
    return of_one != of_other ? of_one < of_other : a.source < b.source;
  };
  // What was there before keeps its order, unless some have passed through each other.
  if (crossed) {
    new_.insert(new_.end(), near_.begin(), near_.end());
    near_.clear();
    std::sort(new_.begin(), new_.end(), before);
    near_.swap(new_);
    return;
  }
  for (const std::uint32_t i : new_)
    near_.insert(std::partition_point(near_.begin(), near_.end(),
                                      [&](std::uint32_t other) { return before(other, i); }),
                 i);
}

void PlaceSweep::see(double begin, double end) {
  PlacePiece piece{begin, end, static_cast<std::uint32_t>(view_->seen.size()), 0};
  float left = 1.0f;
  for (const std::uint32_t i : near_) {
    view_->seen.push_back(i);
    const PlaceLayer& layer = view_->layers[i];
    left *= 1.0f - layer.least_alpha;
    if (layer.opaque || left < opaque_transmittance) break;
  }
  const std::vector<std::uint32_t>& seen = view_->seen;
  piece.count = static_cast<std::uint32_t>(seen.size()) - piece.first;
  // What begins or ends behind is no event.
  if (view_->pieces.size() > first_piece_) {
    PlacePiece& before = view_->pieces.back();
    if (before.end == begin && before.count == piece.count &&
        std::equal(seen.begin() + piece.first, seen.end(), seen.begin() + before.first)) {
      before.end = end;
      view_->seen.resize(piece.first);
      return;
    }
  }
  ++counters.pieces;
  view_->pieces.push_back(piece);
}

}  // namespace swept
