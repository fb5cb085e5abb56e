// A pixel's fragments, resolved exactly in time and depth.
//
// Source: model section 4; Carpenter's A-buffer as adapted by Heinzle et al. 2010, section 4.4, and the
// events of Rönnow et al. 2021, Algorithm 1. Heinzle walks the intervals and trims the occluded ones; here
// the walk is over pieces of the exposure, so that within one the surfaces are made of the same fragments,
// and normalisation is per piece instead of per pixel.
//
// Three kinds of piece, the cheapest that holds:
//
//   lone    a single fragment: closed form, however long
//   front   one surface that covers the pixel, or is too thin to cover it anywhere: fragments may begin and
//   end
//           within, for each is integrated over the time that it is there, and what each adds or takes is
//           little
//   stack   surfaces behind surfaces, or one that begins to cover: over events too where these change little
//           (merged_stack.h), else from event to event
//
// Most fragments are hidden most of the time. A fragment that begins behind an opaque surface is put aside
// and its events are passed over; every piece then proves that nothing put aside could have been part of it,
// or takes all of them back and is done again. So this costs time when it guesses wrong, never accuracy.
//
// So where a surface is dense its cost is that of its fragments and not that of their events times those that
// are there at each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "abuffer/resolve/merged_stack.h"
#include "abuffer/resolve/surfaces.h"
#include "splat/interval/composite.h"
#include "splat/interval/fragments.h"
#include "splat/interval/ticks.h"

namespace swept {

/// How the shades of fragments change, and by how much shutter time later than the kernels' own the pixel's
/// row is exposed. None: all keep their colours.
struct ChangingShades {
  const ShadeChange* of = nullptr;
  double later = 0.0;
  bool tolerances = false;  ///< some change their depth tolerance
};

class PixelSweep {
 public:
  explicit PixelSweep(const SurfaceModel& model, const IntervalMath& math = interval_math_builds().back())
      : model_(model), math_(math), surfaces_(model, math), merged_(model, math) {}

  /// Resolves the `count` fragments `indices` of `fragments`, in any order, provided it does not depend on
  /// the order of the scene's points. Adds to `pixel` and `counters`.
  void resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades,
               const std::uint32_t* indices, std::size_t count, PixelSum& pixel, SweepCounters& counters,
               const ChangingShades& changes = {});
  /// The same, but hands `sink` what it finds.
  void resolve_into(PieceSink& sink, const FragmentArrays& fragments, const std::vector<Shade>& shades,
                    const std::uint32_t* indices, std::size_t count, SweepCounters& counters,
                    const ChangingShades& changes = {});

 private:
  void start(const FragmentArrays& fragments, const Shade* shades, const std::uint32_t* indices,
             std::size_t count);
  void sort_begins();
  void activate(std::uint32_t place, std::uint32_t fragment);
  void admit(Ticks before);
  void withdraw(Ticks from);
  void let_go(Ticks time);
  [[nodiscard]] Ticks next_begin() const;
  Ticks next_event();
  [[nodiscard]] bool lies_behind(std::uint32_t place) const;
  void hide(std::uint32_t place);
  void hide_what_is_behind(float limit, Ticks time);
  void reveal(Ticks time);
  void forget_hidden();

  /// What a piece's front is.
  enum class Front {
    covers,      ///< all that is seen, and everywhere at least the edge weight
    thin,        ///< all that is there, and nowhere more than it
    too_long,    ///< for its fastest kernel
    unsettled,   ///< it loses or gains members in a way that sums cannot tell
    too_varied,  ///< a shorter piece may do
    other        ///< surfaces behind it are seen
  };
  [[nodiscard]] static DepthSpan span_of(const FrontSum& front);
  [[nodiscard]] Front kind_of(FrontSum& front, Ticks end) const;
  void add_front(const FrontSum& front, Front kind, Ticks begin, Ticks end, PixelSum& pixel) const;
  Ticks advance(Ticks begin, PixelSum& pixel);
  Ticks resolve_stack(Ticks begin, Ticks end, PixelSum& pixel);
  std::optional<Ticks> resolve_merged(Ticks begin, Ticks event, PixelSum& pixel);
  [[nodiscard]] Ticks longest_step(float rate, float range);

  SurfaceModel model_;
  IntervalMath math_;
  SurfaceStack surfaces_;
  MergedStack merged_;
  Ticks merged_step_ = 0;       ///< how long a merged stack may be, by the one before; 0: not known
  int pause_ = 0, pauses_ = 0;  ///< for how many stacks none is tried, and for how many it was the last time

  // One call's input: place in `indices` → fragment.
  const FragmentArrays* fragments_ = nullptr;
  const Shade* shades_ = nullptr;
  const std::uint32_t* indices_ = nullptr;
  SweepCounters* counters_ = nullptr;
  ChangingShades changes_;
  PieceSink* sink_ = nullptr;  ///< who takes surfaces instead of the pixel, or nobody

  std::vector<std::uint64_t> begins_, by_bucket_;  ///< time above, place below; sorted
  std::vector<std::uint32_t> buckets_;
  /// Of a fragment, what is asked for again and again: together, for fragments lie far apart.
  struct Reach {
    float least_depth;
    Ticks end;
  };
  std::vector<Reach> reach_;  ///< by place
  std::size_t next_ = 0;      ///< of begins_: the first that is not active yet
  ActiveSet active_;
  std::vector<std::uint32_t> hidden_;    ///< places
  std::vector<std::uint8_t> is_hidden_;  ///< by place
  float hidden_min_z_ = 0.0f;            ///< no more than the depth of anything hidden
  Ticks hidden_last_end_ = 0;            ///< when the last of it ends
  /// Depth beyond which nothing shows: of the last piece, +∞ unless it was opaque.
  float front_limit_ = 0.0f;
  float step_rate_ = -1.0f;  ///< of the last call of longest_step(), and what it gave
  const LikeMembers* step_like_ = nullptr;
  Ticks longest_step_ = 0;
  Ticks step_ = 0;  ///< how long the next piece may be if the last one was a front; 0 if it was not
};

}  // namespace swept
