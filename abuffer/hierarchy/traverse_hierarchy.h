// The hierarchy as one more traversal of the stochastic method: a tile's frustum finds when to look at all
// and the node from where to look, and rays walk down from there. Source: US 8791945.
#pragma once

#include <memory>

#include "abuffer/stochastic/primitives.h"
#include "abuffer/stochastic/traverse.h"

namespace swept::hierarchy {

class SceneTrees;

class HierarchyTraversal {
 public:
  /// Builds, in parallel. `primitives` must outlive it.
  explicit HierarchyTraversal(const stochastic::Primitives& primitives);
  ~HierarchyTraversal();

  /// Tests the samples of the block. Counts boxes as bounds.
  void run(int tile_px, stochastic::Block& block) const;

 private:
  std::unique_ptr<SceneTrees> trees_;
};

}  // namespace swept::hierarchy
