// Stands in for raycast.cpp in a build without Embree.
#include "tools/study/raycast.h"

namespace swept {

bool raycast_available() { return false; }

Result<Rendered> render_raycast(const Scene&, const RaycastOptions&) {
  return Error{"", "", "ray casting needs Embree 3 (libembree-dev), which this build was made without"};
}

}  // namespace swept
