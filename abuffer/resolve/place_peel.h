// What one place of a pixel sees of triangles that all let light through: layer by layer from the nearest on,
// instead of event by event.
//
// Intervals that do not pass through each other can be put in one order that holds at all times: of any that
// overlap in time, the nearer one first. (Overlaps of intervals of a line have no ring without a chord, and
// three that overlap pairwise have an instant in common, at which depths order them; so there is no ring.)
// One that passes through another is cut there. Then each meets the light that those before it have left over
// its time, and takes its share. Where a surface goes on from triangle to triangle with one opacity, what it
// leaves is the same throughout: what begins and ends costs nothing but itself. Where opacities change over a
// triangle, what it leaves is a smooth function from event to event, and from texel to texel.
// Source: model section 15; the intervals are those of Gribel et al. 2013 and Rönnow et al. 2021.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "abuffer/resolve/light_left.h"
#include "abuffer/resolve/place_light.h"
#include "abuffer/resolve/place_look.h"
#include "abuffer/resolve/texel_way.h"
#include "abuffer/simd/edge_math.h"

namespace swept {

/// A thread's.
class PlacePeel {
 public:
  /// Whether add() is for them: none is opaque. What opaque ones hide is left out tile by tile, which may
  /// change no bit; place_sweep.h sees to that.
  [[nodiscard]] static bool is_for(std::span<const PlaceInterval> intervals,
                                   const std::vector<TriangleStretch>& triangles);

  /// Adds the light of a place's intervals, which it puts in order. Throws Stopped once `stop` asks for it.
  void add(std::span<PlaceInterval> intervals, const std::vector<TriangleStretch>& triangles,
           const Eigen::Vector3d& ray, const LightOverTime& light, const std::stop_token& stop,
           PlaceCounters& counters, LightSum& sum);

 private:
  static constexpr std::uint32_t none = ~0u;
  enum class Side { before, behind };
  struct Layer {
    double begin, end;
    float nearest, farthest;
    std::uint32_t source;
    std::uint32_t depth;                         ///< of depths_, once it is needed
    std::uint32_t previous = none, next = none;  ///< in front of it, and behind
    /// Before any was cut off, and 1 over how long that is.
    double since, until, per_time;
    /// The depth as that begins, half-way and as it ends; u of the way it is off the straight line between
    /// the ends by u (1 − u) `bow` at most.
    double z_begin, z_middle, z_end, bow;
    /// Which it has passed through just where it begins, to that side of it, and does so no more.
    std::uint32_t passed = none;
    Side passed_to = Side::before;

    [[nodiscard]] double line(double time) const {
      return z_begin + (time - since) * per_time * (z_end - z_begin);
    }
    /// Whether the parabola through both ends and the middle, z_begin + u (slope() + u bend()), is as good:
    /// it is off its chord by less than 2⁻¹² of the depth, and then off the depth by less than 10⁻⁷ on the
    /// mean, as the fourth power of a quotient's bend is to its square.
    [[nodiscard]] bool is_parabola() const { return bow <= 0x1p-10 * z_middle; }
    [[nodiscard]] double slope() const { return 4.0 * z_middle - 3.0 * z_begin - z_end; }
    [[nodiscard]] double bend() const { return 2.0 * (z_begin + z_end) - 4.0 * z_middle; }
  };
  void make_layers(std::span<const PlaceInterval> intervals);
  void make_layer(const PlaceInterval& interval);
  void put_layer(const PlaceInterval& interval, double per_time, double z_begin, double z_middle,
                 double z_end, double bow);
  void insert(std::uint32_t layer);
  /// Where `one`, from its begin on, is of `other`, up to `until`, which may become sooner: there it passes
  /// through.
  [[nodiscard]] Side side(std::uint32_t one, std::uint32_t other, double& until);
  [[nodiscard]] const PlaceDepth& depth(std::uint32_t layer);
  [[nodiscard]] double depth_over(std::uint32_t layer, double first, double last);
  [[nodiscard]] double depth_at(std::uint32_t layer, double time);
  [[nodiscard]] bool take(std::uint32_t layer, LightSum& sum);
  void make_look(const Layer& layer);
  [[nodiscard]] bool smooth_enough(const SmoothPart& values, double span, double most) const;
  void take_uneven(std::uint32_t layer, const LightLeft::Part& part, int halvings, LightSum& sum);
  void add_colors(const LightLeft::Part& part, int halvings, LightSum& sum) const;
  void add_depths(std::uint32_t layer, const LightLeft::Part& part, int halvings, LightSum& sum);
  template <class Take>
  void between_texels(const LightLeft::Part& part, const Take& take);

  const std::vector<TriangleStretch>* triangles_ = nullptr;
  const Eigen::Vector3d* ray_ = nullptr;
  const LightOverTime* light_ = nullptr;
  PlaceCounters* counters_ = nullptr;
  const EdgeMath& math_ = edge_maths().fastest();
  DepthChords chords_{};
  std::vector<Layer> layers_;  ///< of intervals, in their order, and then of what was cut off
  std::vector<PlaceDepth> depths_;
  std::vector<std::uint32_t> active_;   ///< that are there as the last one begins, from the nearest on
  std::vector<std::uint32_t> cut_off_;  ///< to be inserted, a heap, the soonest first
  std::uint32_t first_ = none, last_ = none;
  std::vector<double> crossings_;
  int times_passed_ = 0;      ///< as side() has last found
  Side then_ = Side::before;  ///< after the only time
  LightLeft left_;
  // Of the layer that takes of it, once there is a need.
  bool looked_ = false;
  bool on_way_ = false;  ///< colours are those of way_ alone
  TexelWay way_;
  PlaceLook look_;
  std::vector<double> texel_cuts_;  ///< shares of light, increasing
};

}  // namespace swept
