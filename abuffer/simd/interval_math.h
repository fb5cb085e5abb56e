// The hot arithmetic of the sweep, over plain arrays.
#pragma once

#include <cstddef>
#include <span>

#include "splat/interval/composite.h"
#include "splat/interval/ticks.h"

namespace swept {

/// Floats per vector the arrays are padded to.
inline constexpr std::size_t member_lanes = 8;

enum MemberField : std::size_t {
  /// Ticks, by their bits. ρ(τ) = peak · exp(−(y + rate·(τ − t_begin))²), z(τ) = z + z_rate·(τ − t_begin).
  member_t_begin,
  member_y,
  member_rate,
  member_peak,
  member_z,
  member_z_rate,
  member_tolerance,
  member_red,
  member_green,
  member_blue,
  member_alpha,
  member_fields
};

/// `count` members, in arrays that may be read up to `padded`, a multiple of member_lanes. What lies between
/// is finite and means nothing.
struct Members {
  const float* data;   ///< field by field
  std::size_t stride;  ///< from one field to the next
  std::size_t count, padded;

  [[nodiscard]] const float* field(MemberField which) const { return data + which * stride; }
};

/// Members' depths at the ends of an interval, and their extremes.
struct DepthRange {
  float min_begin, max_begin, min_end, max_end;
  float min_tolerance, max_tolerance;
  float max_rate;
};

struct MemberSum {
  SurfaceSum surface;      ///< each member weighted by the mean of its ρ over the interval
  float variation = 0.0f;  ///< bound of how far Σρ gets below its mean within the interval
  float peaks = 0.0f;      ///< Σ of the members' peaks: Σρ is nowhere more
  float widest = 0.0f;     ///< the farthest a member moves along its line, in units of y
};

/// The arithmetic as built for one instruction set. All builds give the same bits.
struct IntervalMath {
  const char* name;

  /// z_begin and z_end have room for `padded` values. Precondition: count > 0.
  DepthRange (*depths_over)(const Members& members, Ticks begin, Ticks end, float* z_begin, float* z_end);

  /// Sums over [begin, end]; begin == end: at that instant. `mean` has room for `padded` values. A mean is
  /// within 5 ulp; where the piece is short, of the mean about the middle as it comes out in float,
  /// y + rate·(τ − t_begin). That rounding, 2⁻²⁴ (|y| + 3 rate·(τ − t_begin)), is the size of those in
  /// the fragment's own numbers, and costs 2|y| times as much of the mean.
  MemberSum (*sum_over)(const Members& members, Ticks begin, Ticks end, float* mean);
};

/// Those this processor can run: first the plain loops that define what the others compute, last the widest.
[[nodiscard]] std::span<const IntervalMath> interval_math_builds();

}  // namespace swept
