// A pixel's fragments, resolved exactly in time and depth.
//
// Source: model section 4; Carpenter's A-buffer as adapted by Heinzle et al. 2010, section 4.4, and the
// events of Rönnow et al. 2021, Algorithm 1. Heinzle walks the intervals and trims the occluded ones; here
// the walk is over events, so that between two of them the surfaces are made of the same fragments, and
// normalisation is per interval instead of per pixel.
//
// Most fragments are hidden most of the time. A fragment that begins well behind an opaque surface is put
// aside and its events are passed over; every interval then proves that nothing put aside could have been
// part of it, or takes all of them back and is done again. So this costs time when it guesses wrong, never
// accuracy.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "abuffer/resolve/members.h"
#include "abuffer/resolve/surfaces.h"
#include "splat/interval/composite.h"
#include "splat/interval/fragments.h"
#include "splat/interval/ticks.h"

namespace swept {

class PixelSweep {
 public:
  explicit PixelSweep(const SurfaceModel& model, const IntervalMath& math = interval_math_builds().back())
      : surfaces_(model, math) {}

  /// Resolves the `count` fragments `indices` of `fragments`, in any order but one that does not depend on
  /// the order of the scene's points. Adds to `pixel` and `counters`.
  void resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades,
               const std::uint32_t* indices, std::size_t count, PixelSum& pixel, SweepCounters& counters);

 private:
  enum class State : std::uint8_t { waiting, active, hidden, gone };

  /// A fragment in the pixel's own array: what the sweep reads over and over, side by side.
  struct Local {
    Member member;
    Ticks t_end;
    float least_depth;  ///< over all of its time

    [[nodiscard]] Ticks t_begin() const { return std::bit_cast<Ticks>(member[member_t_begin]); }
  };

  void start(const FragmentArrays& fragments, const Shade* shades, const std::uint32_t* indices,
             std::size_t count);
  void sort_events(std::vector<std::uint64_t>& events);
  void activate(std::uint32_t place);
  void deactivate(std::uint32_t place);
  void pass_events(Ticks time);
  Ticks next_event();
  void hide(std::uint32_t place);
  void hide_what_is_behind();
  void reveal(Ticks time);
  [[nodiscard]] bool lies_behind(std::uint32_t place) const;

  Ticks resolve_until(Ticks begin, Ticks end, PixelSum& pixel);

  SurfaceStack surfaces_;

  // One call's input: place in `indices` → fragment.
  std::vector<Local> local_;
  SweepCounters* counters_ = nullptr;

  // Events, and where each place stands.
  std::vector<std::uint64_t> begins_, ends_;  ///< time above, place below; sorted
  std::size_t next_begin_ = 0, next_end_ = 0;
  std::vector<std::uint32_t> buckets_;
  std::vector<std::uint64_t> by_bucket_;
  std::vector<State> state_;
  std::vector<std::uint32_t> slot_;   ///< place → active_, of the active ones
  std::vector<std::uint32_t> place_;  ///< active_ → place
  MemberSet active_;
  std::vector<std::uint32_t> hidden_;
  float hidden_min_z_ = std::numeric_limits<float>::infinity();
  /// Depth beyond which nothing shows: of the last piece, +∞ unless it was opaque.
  float front_limit_ = std::numeric_limits<float>::infinity();
  float front_margin_ = 0.0f;
};

}  // namespace swept
