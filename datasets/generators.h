// Generated geometry: surfaces sampled as surfels, and particles. The project ships no data of its own.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "splat/export.h"
#include "splat/result.h"
#include "splat/surfel.h"

namespace SWEPT_API swept {

/// One number a generator takes.
struct GeneratorParameter {
  std::string name;
  double fallback = 0.0;         ///< the value if it is not given
  double low = 0.0, high = 1.0;  ///< accepted range, both ends included
  bool whole = false;            ///< only whole numbers
  std::string meaning;           ///< a phrase, with the unit
};

/// Largest `points` that generate() accepts.
inline constexpr std::size_t kMaxGeneratedPoints = 10'000'000;

/// The shapes, in alphabetical order.
[[nodiscard]] std::vector<std::string> generator_names();

/// What `shape` takes, including the parameters that all shapes share. Errors: an unknown shape, with the
/// field "generator".
[[nodiscard]] Result<std::vector<GeneratorParameter>> generator_parameters(const std::string& shape);

/// A cloud of exactly `points` surfels, one key at frame 0, object space: y up, shapes about two units
/// large around the origin. The same arguments give the same bits.
///
/// Surfaces are sampled evenly and their discs overlap without holes, whatever the count: radii go with
/// 1/√points. a₁ × a₂ is the outward normal. Colours are linear, with a Lambert term baked in (parameters
/// `light_*` and `ambient`). Only particles have velocities; they are per frame, as everywhere.
///
/// Errors: field "generator" for an unknown shape, "points" for a count outside
/// [1, kMaxGeneratedPoints], else the parameter's name.
[[nodiscard]] Result<SurfelCloud> generate(const std::string& shape, std::size_t points,
                                           const std::map<std::string, double>& parameters);

}  // namespace swept
