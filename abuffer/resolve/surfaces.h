// The surfaces of a pixel over a piece of time in which nothing begins or ends.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "abuffer/resolve/alone.h"
#include "abuffer/resolve/members.h"
#include "abuffer/resolve/moving_surface.h"
#include "abuffer/simd/interval_math.h"
#include "splat/interval/composite.h"
#include "splat/interval/side.h"
#include "splat/interval/ticks.h"

namespace swept {

struct SweepCounters {
  std::uint64_t intervals = 0;    ///< pieces of time resolved
  std::uint64_t merged = 0;       ///< and those of them in which fragments begin or end
  std::uint64_t retried = 0;      ///< pieces tried for too long a time to be merged
  std::uint64_t crossings = 0;    ///< shortenings of a piece because a surface's members change within
  std::uint64_t subdivided = 0;   ///< and because weights or coverage change too much within
  std::uint64_t shortest = 0;     ///< of both, those that would have had to come sooner than a piece may be
  std::uint64_t evaluations = 0;  ///< fragments integrated, summed over pieces
  std::uint64_t hidden = 0;       ///< fragments put aside
  std::uint64_t revealed = 0;     ///< times they had to be taken back
};

/// The shortest piece of the shutter that a change of surfaces or a subdivision may cut off. What happens
/// within it is worth at most as much of the image.
inline constexpr Ticks shortest_interval = shutter_close >> 20;

/// The fragments that are there, each with its place in the pixel's own, fixed order.
struct ActiveSet {
  MemberSet members;
  std::vector<std::uint32_t> place_of_slot;  ///< member → place
  std::vector<std::array<float, 4>> colors;  ///< of the members once more, side by side
  /// How these change per unit of τ; they are those of where each member begins. Empty if none changes.
  std::vector<std::array<float, 4>> rates;
  /// How the members' depth tolerances change. Empty if none does.
  struct Tolerance {
    float at_zero, rate;  ///< as the exposure begins, and per unit of τ
  };
  std::vector<Tolerance> tolerances;
  std::vector<std::uint32_t> slot_of_place;  ///< place → member, or no_slot
  std::uint32_t of_side[3] = {0, 0, 0};      ///< how many members show each Side
  static constexpr std::uint32_t no_slot = ~0u;

  [[nodiscard]] bool shows_both_sides() const {
    return of_side[static_cast<int>(Side::front)] > 0 && of_side[static_cast<int>(Side::back)] > 0;
  }
  [[nodiscard]] Side side(std::size_t slot) const {
    return std::bit_cast<Side>(members.field(member_side)[slot]);
  }

  void start(std::size_t places) {
    members.clear();
    place_of_slot.clear();
    colors.clear();
    rates.clear();
    tolerances.clear();
    for (std::uint32_t& count : of_side) count = 0;
    slot_of_place.assign(places, no_slot);
  }
  void push(std::uint32_t place, const Member& member, const float (&color_rate)[4]) {
    rates.push_back({color_rate[0], color_rate[1], color_rate[2], color_rate[3]});
    push(place, member);
  }
  void push(std::uint32_t place, const Member& member) {
    slot_of_place[place] = static_cast<std::uint32_t>(members.size());
    place_of_slot.push_back(place);
    colors.push_back({member[member_red], member[member_green], member[member_blue], member[member_alpha]});
    members.push(member);
    ++of_side[std::bit_cast<std::uint32_t>(member[member_side])];
  }
  void pop() {
    --of_side[static_cast<std::uint32_t>(side(members.size() - 1))];
    slot_of_place[place_of_slot.back()] = no_slot;
    place_of_slot.pop_back();
    colors.pop_back();
    if (!rates.empty()) rates.pop_back();
    if (!tolerances.empty()) tolerances.pop_back();
    members.pop();
  }
  /// Until when, from `begin` on, tolerances of one instant will do for all of it, or `end`.
  [[nodiscard]] Ticks tolerances_last(Ticks begin, Ticks end) const;
  /// Gives each member the tolerance that it has in the middle of [begin, end].
  void set_tolerances(Ticks begin, Ticks end);
  /// The last member takes the place of member `slot`.
  void remove(std::size_t slot) {
    slot_of_place[place_of_slot[slot]] = no_slot;
    --of_side[static_cast<std::uint32_t>(side(slot))];
    members.remove(slot);
    const std::uint32_t moved = place_of_slot.back();
    place_of_slot.pop_back();
    colors[slot] = colors.back();
    colors.pop_back();
    if (!rates.empty()) {
      rates[slot] = rates.back();
      rates.pop_back();
    }
    if (!tolerances.empty()) {
      tolerances[slot] = tolerances.back();
      tolerances.pop_back();
    }
    if (slot == members.size()) return;
    place_of_slot[slot] = moved;
    slot_of_place[moved] = static_cast<std::uint32_t>(slot);
  }
};

/// What a stack shows at an instant, and of how much light.
struct StackLook {
  double color[3] = {0.0, 0.0, 0.0};  ///< as of PixelSum, by normalisation
  double alpha = 0.0;
  double depth = 0.0;    ///< weighted by alpha
  double opacity = 0.0;  ///< Normalisation::pixel alone
};

/// A member in an order by depth (ranking.h).
struct RankedMember {
  float z;
  std::uint32_t place, slot;
};

/// Takes a set of fragments apart into surfaces, front to back, as deep as light gets (model sections 1.2
/// to 1.5).
class SurfaceStack {
 public:
  SurfaceStack(const SurfaceModel& model, const IntervalMath& math) : model_(model), math_(math) {}

  [[nodiscard]] const SurfaceModel& model() const { return model_; }

  /// Before a pixel's first piece. `apart`: its surfaces are handed over, not composited.
  void start(std::size_t places, bool apart = false);

  /// Finds the surfaces of `active` from `begin` on, until `end` or the sooner time it returns: until then
  /// each keeps its members, and composite() can integrate its light. All of `active` must be there from
  /// `begin` to `end`; it must not be empty.
  [[nodiscard]] Ticks build(const ActiveSet& active, Ticks begin, Ticks end, SweepCounters& counters);

  /// Whether the surfaces let no light through.
  [[nodiscard]] bool opaque() const { return transmittance_ <= opaque_transmittance; }
  /// Nothing that stays deeper than this can be a member of the surfaces.
  [[nodiscard]] float limit() const { return limit_; }
  /// Twice the largest depth tolerance: what is that much deeper may be put aside without being asked for
  /// again at once.
  [[nodiscard]] float margin() const { return margin_; }
  /// Whether the first surface covers the pixel all the time.
  [[nodiscard]] bool one_covers() const { return !surfaces_.empty() && surfaces_.front().covers; }

  /// Adds what was built over [begin, end], the end being the one that build() returned.
  void composite(Ticks begin, Ticks end, PixelSum& pixel, SweepCounters& counters);
  /// The same at Gauss's two points, if it was started `apart`.
  void look(StackLook (&looks)[2]) const;
  /// Hands over the same.
  void hand_over(Ticks begin, Ticks end, PieceSink& sink, SweepCounters& counters);

 private:
  /// order_[first, last).
  struct Surface {
    std::size_t first = 0, last = 0;
    SurfaceSum mean, swing;  ///< as in FrontSum
    float variation = 0.0f, peaks = 0.0f, widest = 0.0f;
    bool covers = false;  ///< all along
    bool linear = false;  ///< its coverage is nowhere clamped, so that its sums are its light
  };

  Ticks attempt(Ticks begin, Ticks end);
  bool stand_alone(Ticks begin, Ticks end);
  Surface& next_surface(std::size_t first, std::size_t last);
  void take_light();
  void rank();
  void weigh(Ticks begin, Ticks end);
  void add_up(Surface& surface, Ticks begin, Ticks end) const;
  template <bool per_pixel, bool by_depth>
  void add_both_points(double duration, PixelSum& pixel) const;
  [[nodiscard]] DepthSpan span_of(const Surface& surface) const;
  std::size_t gather_nearest(std::size_t first, Ticks begin, Ticks& end);
  [[nodiscard]] bool both_among(std::size_t first, std::size_t last) const;
  [[nodiscard]] bool alike(std::size_t first, std::size_t last) const;
  std::size_t part_sides(std::size_t first, std::size_t last);
  [[nodiscard]] double wait_for_change(std::size_t first, std::size_t last, std::size_t reached,
                                       double duration) const;
  /// Of a member over a piece: its premultiplied colour in the middle, and from there to Gauss's later point.
  struct LightOver {
    std::array<float, 4> mean, swing;
  };
  [[nodiscard]] LightOver light_over(std::size_t slot, Ticks begin, Ticks end) const;
  Ticks measure(Surface& surface, Ticks begin, Ticks end);
  Ticks shorten(Ticks begin, Ticks end, float fraction);

  SurfaceModel model_;
  IntervalMath math_;
  const ActiveSet* active_ = nullptr;
  SweepCounters* counters_ = nullptr;
  std::vector<RankedMember> ranking_;  ///< by depth as a piece begins, that before
  std::vector<std::uint8_t> ranked_;   ///< by place: whether it is in ranking_
  bool apart_ = false;                 ///< surfaces are handed over
  bool in_order_ = false;              ///< order_ is by depth at this piece's begin
  std::vector<std::uint32_t> order_;   ///< slots: the members of the first surface, of the second, …
  std::vector<Surface> surfaces_;
  AloneStack alone_;  ///< instead of surfaces_ where these are empty
  float limit_ = 0.0f, margin_ = 0.0f, transmittance_ = 1.0f;
  float slowest_ = 0.0f;                              ///< the least rate of depth
  std::vector<float> z_begin_, z_end_;                ///< by slot
  std::vector<float> from_, to_, slope_, tolerance_;  ///< in the order of order_: z_begin_, z_end_ and so on
  std::vector<float> behind_to_;                      ///< the least to_ of [i, …)
  struct Placed {
    std::uint32_t slot;
    float from, to, slope, tolerance;
  };
  std::vector<Placed> others_;  ///< of part_sides()
  std::vector<float> mean_, swing_, variation_, depth_, depth_swing_;
  std::vector<float> at_begin_, at_end_;
  bool instants_known_ = false;
  std::vector<MovingSurface> handed_;
  std::vector<SurfaceMember> handed_members_;
};

}  // namespace swept
