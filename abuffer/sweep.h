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

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "abuffer/composite.h"
#include "abuffer/fragments.h"
#include "abuffer/members.h"

namespace swept {

struct SweepCounters {
  std::uint64_t intervals = 0;    ///< pieces of time resolved
  std::uint64_t crossings = 0;    ///< shortenings of a piece because a surface's members change within
  std::uint64_t subdivided = 0;   ///< and because weights or coverage change too much within
  std::uint64_t evaluations = 0;  ///< fragments integrated, summed over pieces and surfaces
  std::uint64_t hidden = 0;       ///< fragments put aside
  std::uint64_t revealed = 0;     ///< times they had to be taken back
};

class PixelSweep {
 public:
  explicit PixelSweep(const SurfaceModel& model) : model_(model) {}

  /// Resolves the `count` fragments `indices` of `fragments`, in any order but one that does not depend on
  /// the order of the scene's points. Adds to `pixel` and `counters`.
  void resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades,
               const std::uint32_t* indices, std::size_t count, PixelSum& pixel, SweepCounters& counters);

 private:
  enum class State : std::uint8_t { waiting, active, hidden, gone };
  struct Surface {
    Members members;
    MemberSum sum;
  };
  /// A surface whose members are not all of active_.
  struct Part {
    MemberSet members;
    std::size_t last;  ///< of order_
  };

  void start(std::size_t count);
  void activate(std::uint32_t place);
  void deactivate(std::uint32_t place);
  void pass_events(float time);
  float next_event(float after);
  void hide(std::uint32_t place);
  void hide_what_is_behind();
  void reveal(float time);
  [[nodiscard]] bool lies_behind(std::uint32_t place) const;

  float resolve_until(float begin, float end, PixelSum& pixel);
  float build_surfaces(float begin, float end);
  std::size_t gather_nearest(std::size_t first, float begin, float& end);
  float measure(Surface& surface, float begin, float end);
  float shorten(float begin, float end, float fraction);
  void composite(float begin, float end, PixelSum& pixel);

  SurfaceModel model_;

  // One call's input.
  const FragmentArrays* fragments_ = nullptr;
  const Shade* shades_ = nullptr;
  const std::uint32_t* indices_ = nullptr;
  SweepCounters* counters_ = nullptr;

  // Events, and where each place of `indices` stands.
  std::vector<std::uint64_t> begins_, ends_;  ///< time's bits above, place below; sorted
  std::size_t next_begin_ = 0, next_end_ = 0;
  std::vector<State> state_;
  std::vector<std::uint32_t> slot_;   ///< place → active_, of the active ones
  std::vector<std::uint32_t> place_;  ///< active_ → place
  MemberSet active_;
  std::vector<std::uint32_t> hidden_;
  float hidden_min_z_ = std::numeric_limits<float>::infinity();
  /// Depth beyond which nothing shows: of the last piece, +∞ unless it was opaque.
  float front_limit_ = std::numeric_limits<float>::infinity();
  float front_margin_ = 0.0f;

  // One piece of time.
  std::vector<std::uint32_t> order_;
  std::vector<Surface> surfaces_;
  std::vector<Part> parts_;
  std::size_t used_ = 0;  ///< members in surfaces_; the rest of order_ lies behind
  float piece_limit_ = 0.0f, piece_margin_ = 0.0f, transmittance_ = 1.0f;
  std::vector<float> mean_, z_begin_, z_end_;
};

}  // namespace swept
