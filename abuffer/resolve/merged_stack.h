// Surfaces behind surfaces over a piece of time in which fragments begin and end.
//
// From event to event a stack costs all that is there, for what one fragment among hundreds changes. Here ρ
// of each member is the straight line over the piece that has its mean and first moment, as in a front
// (abuffer/simd/interval_math.h), so that a piece may hold many events. What has to hold then is that
// surfaces keep their members for as long as these are there. The members, in the order of depth, are taken
// apart where there is a gap that no surface reaches across; between two gaps
//
//   all surfaces keep their leaders   each is one sum over the piece, begin and end what may
//   or what is there is little        it is resolved from event to event by itself, and what it lets through
//                                     and shows is a line over the piece again
//   else                              the piece ends there
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "abuffer/resolve/surfaces.h"
#include "abuffer/simd/interval_math.h"
#include "splat/interval/composite.h"
#include "splat/interval/ticks.h"

namespace swept {

class MergedStack {
 public:
  MergedStack(const SurfaceModel& model, const IntervalMath& math)
      : model_(model), math_(math), part_stack_(model, math) {}

  /// Before a pixel's first piece.
  void start(std::size_t places);

  /// Resolves `active` over [begin, end], of members that may begin and end within but are all there at some
  /// time of it; there must be some. Returns `end`; or else the sooner time for which it may be tried again,
  /// `begin` at the soonest, and then nothing else here means anything. Soft coverage only, and no member's
  /// colour changes. `by_depth`: add_to() will be asked for samples by depth.
  [[nodiscard]] Ticks build(const ActiveSet& active, Ticks begin, Ticks end, bool by_depth,
                            SweepCounters& counters);

  void add_to(PixelSum& pixel) const;

  /// As of SurfaceStack.
  [[nodiscard]] bool opaque() const {
    return light_.left[0] <= opaque_transmittance && light_.left[1] <= opaque_transmittance;
  }
  [[nodiscard]] float limit() const { return light_.limit; }
  [[nodiscard]] float margin() const { return margin_; }
  [[nodiscard]] bool one_covers() const { return one_covers_; }
  /// How long a piece of the members that were there the last time may be.
  [[nodiscard]] Ticks longest() const { return static_cast<Ticks>(double{longest_} * shutter_close); }

 private:
  /// Gathered so far, front to back, at Gauss's two points.
  struct Light {
    double color[2][3] = {}, depth[2] = {}, opacity[2] = {}, left[2] = {1.0, 1.0};
    double jumps = 0.0;  ///< Σ of the coverage by which surfaces jump
    float limit = 0.0f;  ///< nothing that stays deeper can be a member
    std::size_t samples = 0;
  };

  void rank();
  [[nodiscard]] Ticks from(std::uint32_t slot) const;
  [[nodiscard]] Ticks to(std::uint32_t slot) const;
  Ticks resolve_together(std::size_t first, std::size_t last);
  Ticks split(std::uint32_t leader, Ticks until);
  bool add_surface();
  bool settled(float weight, float variation, float peaks, float jumps);
  void resolve_apart(std::size_t first, std::size_t last);
  void look_behind(const StackLook (&looks)[2], Ticks begin, Ticks end);

  SurfaceModel model_;
  IntervalMath math_;
  const ActiveSet* active_ = nullptr;
  SweepCounters* counters_ = nullptr;
  Ticks begin_ = 0, end_ = 0;
  bool by_depth_ = false, one_covers_ = false;
  float margin_ = 0.0f;
  float rate_ = -1.0f, longest_ = 0.0f;  ///< of the last call of longest_piece()
  Light light_;

  std::vector<float> mean_, swing_, variation_, jump_, depth_, depth_swing_, z_from_, z_to_;  ///< by slot
  std::vector<float> at_begin_, at_end_;
  bool instants_known_ = false;
  std::vector<RankedMember> ranking_;  ///< by nearest depth over the piece, as of the piece before
  std::vector<std::uint8_t> ranked_;   ///< by place: whether it is in ranking_
  std::vector<std::uint32_t> rest_, behind_, surface_;  ///< slots

  ActiveSet part_;
  SurfaceStack part_stack_;
  std::vector<Ticks> events_;
  std::vector<std::uint32_t> to_come_;
  StackLook mean_look_, swing_look_;

  struct Sample {
    DepthSpan span;
    double rgba[4];
  };
  std::vector<Sample> samples_;
};

}  // namespace swept
