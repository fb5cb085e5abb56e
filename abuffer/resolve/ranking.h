// What stacks of surfaces keep of their members from one piece of time to the next: an order by depth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "abuffer/resolve/surfaces.h"

namespace swept {

/// Takes out of `ranking` who is no longer active, and puts those behind it who are new; `ranked` says by
/// place who is in. Depths become those of depth(slot). Returns how many were kept, in the order they had.
template <class Depth>
std::size_t renew(const ActiveSet& active, const Depth& depth, std::vector<RankedMember>& ranking,
                  std::vector<std::uint8_t>& ranked) {
  const std::vector<std::uint32_t>& slot_of = active.slot_of_place;
  std::size_t kept = 0;
  // Field by field: a whole that is read back from parts just written has to wait for them.
  for (std::size_t i = 0; i < ranking.size(); ++i) {
    const std::uint32_t place = ranking[i].place, slot = slot_of[place];
    if (slot == ActiveSet::no_slot) {
      ranked[place] = 0;
      continue;
    }
    RankedMember& member = ranking[kept++];
    member.z = depth(slot);
    member.place = place;
    member.slot = slot;
  }
  ranking.resize(kept);
  const std::vector<std::uint32_t>& places = active.place_of_slot;
  for (std::uint32_t slot = 0; slot < places.size(); ++slot) {
    if (ranked[places[slot]]) continue;
    ranked[places[slot]] = 1;
    ranking.push_back({depth(slot), places[slot], slot});
  }
  return kept;
}

}  // namespace swept
