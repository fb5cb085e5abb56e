// A pixel's only fragment over a piece of time: its light in closed form, however long the piece.
#pragma once

#include "abuffer/resolve/members.h"
#include "splat/interval/composite.h"
#include "splat/interval/ticks.h"

namespace swept {

/// Adds what member `i` of `members` gives over [begin, end] where nothing else is there. Its colour is that
/// of its begin, and changes by `color_rate[4]` per unit of τ, if that is given.
///
/// Soft coverage is min(1, ρ/ρ_edge), and ρ = ρ_edge where y = ±√ln(peak/ρ_edge): between them the member
/// covers the pixel, before and after its light is linear in ρ.
void add_lone(const SurfaceModel& model, const MemberSet& members, std::size_t i, Ticks begin, Ticks end,
              PixelSum& pixel, const float* color_rate = nullptr);

}  // namespace swept
