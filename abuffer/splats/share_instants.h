// Which cells look at the same instants, because splats have to be placed at each of them.
#pragma once

#include <cstddef>
#include <vector>

#include "abuffer/splats/cell_work.h"

namespace swept {

/// Raises numbers of instants to those of other cells where that costs less than placing `splats` at instants
/// of their own. Of cells whose number is chosen.
void share_instants(std::vector<CellWork>& cells, std::size_t splats);

}  // namespace swept
