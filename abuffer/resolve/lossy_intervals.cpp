#include "abuffer/resolve/lossy_intervals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace swept {
namespace {

/// How many of the next ones an interval may be merged with: those of a surface behind lie between.
constexpr std::size_t looked_ahead = 4;
/// What naming another triangle costs where it looks the same; as a share of what a wrong colour costs.
constexpr double name_cost = 0.05;

double length(const PlaceInterval& i) { return i.end - i.begin; }
double depth(const PlaceInterval& i) { return 0.5 * double{i.nearest} + 0.5 * double{i.farthest}; }

/// From 0, where two triangles look alike and lie at one depth.
double unlike(const PlaceInterval& a, const PlaceInterval& b, const std::vector<TriangleStretch>& triangles) {
  const TriangleStretch &of_a = triangles[a.source], &of_b = triangles[b.source];
  double color = 0.0;
  for (int c = 0; c < 4; ++c) {
    double difference = 0.0;
    for (int i = 0; i < 3; ++i) difference += double{of_a.rgba[i][c]} - double{of_b.rgba[i][c]};
    color = std::max(color, std::abs(difference) / 3.0);
  }
  const double nearer = std::min(depth(a), depth(b));
  const double apart = nearer > 0.0 ? std::abs(depth(a) - depth(b)) / nearer : 0.0;
  return color + std::min(1.0, 4.0 * apart) + name_cost;
}

/// What it costs to show `kept` from where the first of both begins to where the last ends.
double cost(const PlaceInterval& kept, const PlaceInterval& lost,
            const std::vector<TriangleStretch>& triangles) {
  const double overlap = std::min(kept.end, lost.end) - std::max(kept.begin, lost.begin);
  double wrong = length(lost);
  if (overlap > 0.0 && triangles[kept.source].opaque && kept.farthest <= lost.nearest) wrong -= overlap;
  return wrong * unlike(kept, lost, triangles) + std::max(0.0, -overlap);
}

}  // namespace

void LossyIntervals::merge_to_most(const std::vector<TriangleStretch>& triangles) {
  std::sort(held_.begin(), held_.end(), [](const PlaceInterval& a, const PlaceInterval& b) {
    // What they are, before where they come from: triangles may be renumbered in between.
    return std::tie(a.begin, a.end, a.nearest, a.farthest, a.source) <
           std::tie(b.begin, b.end, b.nearest, b.farthest, b.source);
  });
  // What opaque intervals in front leave no time of costs nothing.
  std::size_t seen = 0;
  for (std::size_t i = 0; i < held_.size(); ++i) {
    double from = held_[i].begin;
    for (const PlaceInterval& a : held_)
      if (a.begin <= from && a.end > from && a.farthest < held_[i].nearest && triangles[a.source].opaque)
        from = a.end;
    if (from < held_[i].end) continue;
    // Marked, as it may be what hides others: whatever hides it does so, too.
    held_[i].end = held_[i].begin - 1.0;
  }
  for (const PlaceInterval& i : held_)
    if (i.begin < i.end) held_[seen++] = i;
  held_.resize(seen);
  while (held_.size() > most_) {
    double least = std::numeric_limits<double>::infinity();
    std::size_t kept = 0, lost = 1;
    for (std::size_t i = 0; i < held_.size(); ++i)
      for (std::size_t j = i + 1; j < std::min(held_.size(), i + 1 + looked_ahead); ++j) {
        // The longer one stays.
        const bool first = length(held_[i]) >= length(held_[j]);
        const std::size_t a = first ? i : j, b = first ? j : i;
        const double costs = cost(held_[a], held_[b], triangles);
        if (costs < least) least = costs, kept = a, lost = b;
      }
    // Not a number anywhere: the first goes.
    if (!(least < std::numeric_limits<double>::infinity())) kept = 1, lost = 0;
    PlaceInterval merged = held_[kept];
    merged.begin = std::min(merged.begin, held_[lost].begin);
    merged.end = std::max(merged.end, held_[lost].end);
    merged.nearest = std::min(merged.nearest, held_[lost].nearest);
    merged.farthest = std::max(merged.farthest, held_[lost].farthest);
    held_[std::min(kept, lost)] = merged;
    held_.erase(held_.begin() + static_cast<std::ptrdiff_t>(std::max(kept, lost)));
  }
}

std::size_t LossyIntervals::shorten(std::span<PlaceInterval> intervals,
                                    const std::vector<TriangleStretch>& triangles) {
  if (most_ == 0 || intervals.size() < 2 * most_) return intervals.size();
  held_.clear();
  for (const PlaceInterval& i : intervals) {
    held_.push_back(i);
    if (held_.size() == 2 * most_) merge_to_most(triangles);
  }
  std::copy(held_.begin(), held_.end(), intervals.begin());
  return held_.size();
}

std::size_t LossyIntervals::finish(std::span<PlaceInterval> intervals,
                                   const std::vector<TriangleStretch>& triangles) {
  const std::size_t left = shorten(intervals, triangles);
  if (most_ == 0 || left <= most_) return left;
  held_.assign(intervals.begin(), intervals.begin() + static_cast<std::ptrdiff_t>(left));
  merge_to_most(triangles);
  std::copy(held_.begin(), held_.end(), intervals.begin());
  return held_.size();
}

}  // namespace swept
