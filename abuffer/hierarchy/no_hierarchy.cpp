// A build without SWEPT_HIERARCHY: nothing comes here, for the option is refused.
#include "abuffer/hierarchy/traverse_hierarchy.h"

namespace swept {

bool hierarchy_available() { return false; }

namespace hierarchy {

class SceneTrees {};

HierarchyTraversal::HierarchyTraversal(const stochastic::Primitives&) {}
HierarchyTraversal::~HierarchyTraversal() = default;
void HierarchyTraversal::run(int, stochastic::Block&) const {}

}  // namespace hierarchy
}  // namespace swept
