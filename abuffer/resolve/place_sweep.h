// What one place of a pixel sees of a mesh over the exposure: intervals in (time, depth), cut wherever what
// is seen changes. Source: Rönnow et al. 2021, section 4.2; Gribel et al. 2013, section 5.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "abuffer/sources/triangle_stretch.h"

namespace swept {

/// Light over time for the rows of a film: shutter time as triangles have it, evenly over the exposure of all
/// rows, and the share of the light of a row that is in.
class LightOverTime {
 public:
  LightOverTime(const Exposure& all, const Exposure& row)
      : even_(!row.curve && row.open == all.open && row.close == all.close), all_(all), row_(row) {
    if (even_) return;
    from_ = (row.open - all.open) / (all.close - all.open);
    to_ = (row.close - all.open) / (all.close - all.open);
  }
  /// When the row is exposed.
  [[nodiscard]] double from() const { return from_; }
  [[nodiscard]] double to() const { return to_; }
  [[nodiscard]] double share(double time) const {
    if (even_) return time;
    return std::clamp(row_.share_at(all_.open + time * (all_.close - all_.open)), 0.0, 1.0);
  }
  [[nodiscard]] double time(double share) const {
    if (even_) return share;
    return (row_.at(share) - all_.open) / (all_.close - all_.open);
  }

 private:
  bool even_;
  Exposure all_, row_;
  double from_ = 0.0, to_ = 1.0;
};

/// A stretch of time in which one place sees the same triangles in the same order.
struct PlacePiece {
  double begin, end;
  std::uint32_t first, count;  ///< of PlaceSweep::seen(), from the nearest on
};

struct PlaceCounters {
  std::uint64_t pieces = 0, crossings = 0;
  void add(const PlaceCounters& o) { pieces += o.pieces, crossings += o.crossings; }
};

/// A thread's.
class PlaceSweep {
 public:
  /// Of the intervals of one mesh at one place, which it puts in order. Where nothing is seen there is no
  /// piece. What lies behind an opaque triangle is left out.
  void cut(std::span<PlaceInterval> intervals, const std::vector<TriangleStretch>& triangles,
           const Eigen::Vector3d& ray);

  [[nodiscard]] const std::vector<PlacePiece>& pieces() const { return pieces_; }
  /// Indices of `triangles`.
  [[nodiscard]] const std::vector<std::uint32_t>& seen() const { return seen_; }

  PlaceCounters counters;
  /// A pixel may take seconds: what finds surfaces of it throws Stopped once this asks for it.
  std::stop_token stop;

 private:
  struct At {
    double depth;
    const PlaceInterval* interval;
  };
  void piece(double begin, double end, const std::vector<TriangleStretch>& triangles,
             const Eigen::Vector3d& ray);
  void ordered(double begin, double end, const std::vector<TriangleStretch>& triangles,
               const Eigen::Vector3d& ray);

  std::vector<PlacePiece> pieces_;
  std::vector<std::uint32_t> seen_;
  std::vector<double> events_, crossings_;
  std::vector<const PlaceInterval*> active_, near_;
  std::vector<At> order_;
};

}  // namespace swept
