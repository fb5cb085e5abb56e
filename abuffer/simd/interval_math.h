// The hot arithmetic of the sweep, over plain arrays.
#pragma once

#include <cstddef>
#include <limits>
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
  member_t_end,  ///< Ticks, by their bits
  member_jump,   ///< a bound of ρ where the fragment begins and where it ends
  member_side,   ///< Side, by its bits
  member_fields
};

/// `count` members, in arrays that may be read up to `padded`, a multiple of member_lanes. What lies between
/// is finite and means nothing.
struct Members {
  const float* data;   ///< field by field
  std::size_t stride;  ///< from one field to the next
  std::size_t count, padded;
  float enough = 0.0f;  ///< for front_over(): what FrontSum::low has to reach, if it can be shown to

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

/// Weighted by each member's ρ over a piece of time in which members may begin and end.
///
/// ρ over the piece is replaced by the straight line that has its mean and its first moment: `mean` ± `swing`
/// are that line's values at Gauss's two points. So sums are exact, and products of two are to fourth order.
struct FrontSum {
  SurfaceSum mean;
  float low = 0.0f;    ///< Σρ of the front is nowhere less
  float jumps = 0.0f;  ///< Σ of the ρ by which fragments of the front begin and end within the piece
  SurfaceSum swing;
  float peaks = 0.0f;    ///< Σρ of the front is nowhere more
  float fastest = 0.0f;  ///< the largest rate in the front
  float limit = 0.0f;    ///< nothing that stays deeper than this is part of it
  float margin = 0.0f;   ///< twice the largest tolerance
  bool opaque = false;   ///< for the caller to find out
  bool behind = false;   ///< something lies behind the front
  bool mixed = false;    ///< its members show both sides, so that it is not one surface
  /// The widest range of any channel among the front's members, or of their depths as a share of the front's
  /// if that is more.
  float range = std::numeric_limits<float>::infinity();
  Ticks changes_at = 0;     ///< until then one member stays the nearest
  Ticks settled_until = 0;  ///< the sums hold if this is the end of the piece; else a shorter one that may do
};

/// Of its weight, what a front may gain and lose by fragments that begin and end within a piece, whatever
/// their colours.
inline constexpr float few_jumps = 0.2f;

/// What a front shows is a mean of its members, so that what a mean's weights are off by is in the picture
/// times the range of what they weigh. The first term that sums leave out grows with the tenth power of how
/// far members move: so far more they may, the more alike they are.
struct LikeMembers {
  float range;  ///< FrontSum::range up to which
  float reach;  ///< members may move so many times as far along their lines; reach¹⁰ · range ≤ 1
};
inline constexpr LikeMembers like_members[] = {
    {0x1p-10f, 2.0f}, {0x1p-6f, 1.5f}, {0x1p-4f, 1.25f}, {std::numeric_limits<float>::infinity(), 1.0f}};
[[nodiscard]] inline const LikeMembers& like_members_of(float range) {
  const LikeMembers* like = like_members;
  while (range > like->range) ++like;
  return *like;
}

/// By member, over a piece in which all are there: what swings_over() reads, and what it writes.
struct Swings {
  const float *z_begin, *z_end;  ///< as depths_over() gives them
  float* swing;                  ///< of ρ, as in FrontSum
  float* variation;              ///< a bound of how far ρ gets below its mean
  float *depth, *depth_swing;    ///< of ρz
};

/// By member, over a piece in which members may begin and end: what presences_over() writes. Each array has
/// room for `padded` values.
struct Presences {
  float *mean, *swing;  ///< of ρ, zero where the member is not there; as in FrontSum
  float* variation;     ///< a bound of how far ρ gets below its mean, and half of how far above it
  float* jump;          ///< a bound of the ρ by which the member begins and ends within the piece; else 0
  float *depth, *depth_swing;  ///< of ρz
  float *z_from, *z_to;        ///< depth where the member is first there within the piece, and last
};

/// Of all members.
struct PresenceRange {
  float max_rate, max_tolerance;
  float reach;  ///< the sums hold if this is at most 1
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

  /// How each member's ρ and ρz run over [begin, end], given its `mean` there. All arrays have room for
  /// `padded` values. Where a piece is too long for a series, a swing is the most that it may be.
  void (*swings_over)(const Members& members, Ticks begin, Ticks end, const float* mean, const Swings& out);

  /// The nearest surface over [begin, end], of members that may begin and end within: at every instant those
  /// within the nearest one's tolerance of it. Precondition: begin < end.
  FrontSum (*front_over)(const Members& members, Ticks begin, Ticks end);

  /// Each member by itself over [begin, end], of members that may begin and end within, but are all there at
  /// some time of it. Precondition: begin < end.
  PresenceRange (*presences_over)(const Members& members, Ticks begin, Ticks end, const Presences& out);
};

/// Those this processor can run: first the plain loops that define what the others compute, last the widest.
[[nodiscard]] std::span<const IntervalMath> interval_math_builds();

}  // namespace swept
