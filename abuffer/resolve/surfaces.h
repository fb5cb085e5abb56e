// The surfaces of a pixel over a piece of time in which they keep their members.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "abuffer/resolve/members.h"
#include "abuffer/simd/interval_math.h"
#include "splat/interval/composite.h"
#include "splat/interval/ticks.h"

namespace swept {

struct SweepCounters {
  std::uint64_t intervals = 0;    ///< pieces of time resolved
  std::uint64_t crossings = 0;    ///< shortenings of a piece because a surface's members change within
  std::uint64_t subdivided = 0;   ///< and because weights or coverage change too much within
  std::uint64_t shortest = 0;     ///< of both, those that would have had to come sooner than a piece may be
  std::uint64_t evaluations = 0;  ///< fragments integrated, summed over pieces and surfaces
  std::uint64_t hidden = 0;       ///< fragments put aside
  std::uint64_t revealed = 0;     ///< times they had to be taken back
};

/// Takes a set of fragments apart into surfaces, front to back, as deep as light gets (model sections 1.2
/// to 1.5).
class SurfaceStack {
 public:
  SurfaceStack(const SurfaceModel& model, const IntervalMath& math) : model_(model), math_(math) {}

  [[nodiscard]] const SurfaceModel& model() const { return model_; }

  /// Finds the surfaces of `active` from `begin` on, until `end` or the sooner time it returns: until then
  /// each keeps its members, and composite() can integrate its light. `active` must not be empty,
  /// and must outlive what follows unchanged.
  [[nodiscard]] Ticks build(MemberSet& active, Ticks begin, Ticks end, SweepCounters& counters);

  /// Adds what was built over [begin, end], the end being the one that build() returned.
  void composite(Ticks begin, Ticks end, PixelSum& pixel, SweepCounters& counters);

  /// Whether the surfaces let no light through.
  [[nodiscard]] bool opaque() const { return transmittance_ <= opaque_transmittance; }
  /// Nothing that stays deeper than this can be a member of the surfaces.
  [[nodiscard]] float limit() const { return limit_; }
  /// The largest depth tolerance of any active fragment.
  [[nodiscard]] float margin() const { return margin_; }
  /// How many of the active fragments are in the surfaces; the rest lies behind.
  [[nodiscard]] std::size_t used() const { return used_; }

 private:
  struct Surface {
    Members members;
    MemberSum sum = {};
    bool linear = false;  ///< its coverage is nowhere clamped, so that its sums are its light
  };

  Ticks attempt(Ticks begin, Ticks end);
  std::size_t gather_nearest(std::size_t first, Ticks begin, Ticks& end);
  Ticks measure(Surface& surface, Ticks begin, Ticks end);
  Ticks shorten(Ticks begin, Ticks end, float fraction);
  [[nodiscard]] float depth_shift(const Members& members, Ticks begin, Ticks end) const;

  SurfaceModel model_;
  IntervalMath math_;
  MemberSet* active_ = nullptr;
  SweepCounters* counters_ = nullptr;
  std::vector<std::uint32_t>
      order_;  ///< of active_: the members of the first surface, of the second, … and the rest
  std::vector<Surface> surfaces_;
  std::vector<MemberSet> parts_;  ///< members of the surfaces that are not all of active_
  std::size_t used_ = 0;
  int points_ = 1;  ///< at which the piece is looked at; 1: its integrals stand for it
  float limit_ = 0.0f, margin_ = 0.0f, transmittance_ = 1.0f;
  std::vector<float> mean_, at_ends_, z_begin_, z_end_;
};

}  // namespace swept
