// Passes 1 and 2: the nearest disc at one end of the sub-frame. Source: Heinzle et al. 2010, section 5.1.
#include "kernel.glsl"

uniform float time;  // from the middle of the sub-frame: -0.5 or 0.5

layout(location = 0) out float limit;

void main() {
  vec3 offset = ray_offset();
  if (!faces(offset)) discard;
  Line line = line_along(offset);
  float u = line.u + time * line.du, v = line.v + time * line.dv, z = line.z + time * line.dz;
  if (!(u * u + v * v <= 1.0) || !(z >= near_plane)) discard;
  // Compilers may fuse the sums of this pass and of later ones differently: 2^-22 of the depth keeps a disc from
  // hiding itself.
  limit = z + max(rate_u.w, 2.4e-7 * z);
  // Reversed: a float keeps its relative precision at all depths.
  gl_FragDepth = near_plane / z;
}
