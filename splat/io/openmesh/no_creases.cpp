// A build without SWEPT_OPENMESH.
#include "splat/io/mesh_creases.h"

namespace swept::io {

bool creases_available() { return false; }

Result<CreasedMesh> crease(const std::vector<Eigen::Vector3d>&, const std::vector<Triangle>&, double,
                           const std::vector<std::uint8_t>&, const std::vector<CornerNormals>&) {
  return Error{"", "crease_angle",
               "this build was made without OpenMesh (SWEPT_OPENMESH), which finds creases",
               ErrorKind::unsupported};
}

}  // namespace swept::io
