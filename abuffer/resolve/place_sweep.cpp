#include "abuffer/resolve/place_sweep.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "splat/without_throwing.h"

namespace swept {

void PlaceSweep::cut(std::span<PlaceInterval> intervals, const std::vector<TriangleStretch>& triangles,
                     const Eigen::Vector3d& ray) {
  pieces_.clear();
  seen_.clear();
  // The order of sources is that of the mesh, whatever the tile.
  std::sort(intervals.begin(), intervals.end(), [](const PlaceInterval& a, const PlaceInterval& b) {
    return std::tie(a.begin, a.source, a.end) < std::tie(b.begin, b.source, b.end);
  });
  events_.clear();
  for (const PlaceInterval& i : intervals) {
    events_.push_back(i.begin);
    events_.push_back(i.end);
  }
  std::sort(events_.begin(), events_.end());
  events_.erase(std::unique(events_.begin(), events_.end()), events_.end());
  active_.clear();
  std::size_t next = 0;
  for (std::size_t e = 0; e + 1 < events_.size(); ++e) {
    const double begin = events_[e], end = events_[e + 1];
    std::erase_if(active_, [&](const PlaceInterval* i) { return i->end <= begin; });
    while (next < intervals.size() && intervals[next].begin <= begin) active_.push_back(&intervals[next++]);
    if (!active_.empty()) piece(begin, end, triangles, ray);
  }
}

void PlaceSweep::piece(double begin, double end, const std::vector<TriangleStretch>& triangles,
                       const Eigen::Vector3d& ray) {
  float hidden_from = std::numeric_limits<float>::infinity();
  for (const PlaceInterval* i : active_)
    if (triangles[i->source].opaque) hidden_from = std::min(hidden_from, i->farthest);
  near_.clear();
  for (const PlaceInterval* i : active_)
    if (i->nearest <= hidden_from) near_.push_back(i);
  // Depths are Na/Da and Nb/Db: they are equal where Na·Db − Nb·Da is 0.
  crossings_.clear();
  for (std::size_t a = 0; a < near_.size(); ++a) {
    throw_if_stopped(stop);
    for (std::size_t b = a + 1; b < near_.size(); ++b) {
      if (near_[a]->farthest < near_[b]->nearest || near_[b]->farthest < near_[a]->nearest) continue;
      // Over all the time that both are there, so that what begins or ends behind them changes no bit.
      const double both_from = std::max(near_[a]->begin, near_[b]->begin),
                   both_to = std::min(near_[a]->end, near_[b]->end);
      const auto depth = [&](std::size_t i) {
        const TriangleStretch& t = triangles[near_[i]->source];
        const double low = std::clamp(t.local(both_from), 0.0, 1.0),
                     high = std::clamp(t.local(both_to), low, 1.0);
        return t.depth(ray, low, high);
      };
      const DepthOverTime of_a = depth(a), of_b = depth(b);
      const Bernstein one = product(of_a.above, of_b.below), other = product(of_b.above, of_a.below);
      const int degree = std::max(one.degree, other.degree);
      const SignChanges changes = sign_changes(difference(one.raised(degree), other.raised(degree)));
      for (int k = 0; k < changes.count; ++k) {
        const double t = both_from + (both_to - both_from) * changes.at[static_cast<std::size_t>(k)];
        if (t > begin && t < end) crossings_.push_back(t);
      }
    }
  }
  if (crossings_.empty()) return ordered(begin, end, triangles, ray);
  counters.crossings += crossings_.size();
  std::sort(crossings_.begin(), crossings_.end());
  crossings_.push_back(end);
  double from = begin;
  for (const double to : crossings_) {
    if (from < to) ordered(from, to, triangles, ray);
    from = to;
  }
}

void PlaceSweep::ordered(double begin, double end, const std::vector<TriangleStretch>& triangles,
                         const Eigen::Vector3d& ray) {
  throw_if_stopped(stop);
  PlacePiece piece{begin, end, static_cast<std::uint32_t>(seen_.size()), 0};
  if (near_.size() == 1) {
    seen_.push_back(near_.front()->source);
  } else {
    const double middle = 0.5 * begin + 0.5 * end;
    order_.clear();
    for (const PlaceInterval* i : near_) order_.push_back({triangles[i->source].look(ray, middle).depth, i});
    // Equal depths: as the mesh has them.
    std::sort(order_.begin(), order_.end(), [](const At& a, const At& b) {
      return std::tie(a.depth, a.interval->source) < std::tie(b.depth, b.interval->source);
    });
    for (const At& at : order_) {
      seen_.push_back(at.interval->source);
      if (triangles[at.interval->source].opaque) break;
    }
  }
  piece.count = static_cast<std::uint32_t>(seen_.size()) - piece.first;
  // What begins or ends behind is no event.
  if (!pieces_.empty() && pieces_.back().end == begin && pieces_.back().count == piece.count &&
      std::equal(seen_.begin() + piece.first, seen_.end(), seen_.begin() + pieces_.back().first)) {
    pieces_.back().end = end;
    seen_.resize(piece.first);
    return;
  }
  ++counters.pieces;
  pieces_.push_back(piece);
}

}  // namespace swept
