// Passes 3 and 4: when visible kernels cover the pixel, first and last. Source: Heinzle et al. 2010, section 5.2.
// Which of the two it is, the blend equation says.
//
// That hidden kernels are left out, as in the paper, changes no time: what is hidden at both ends is hidden by discs
// that cover the pixel at both ends, and so from 0 to 1.
#include "kernel.glsl"

layout(location = 0) out float time;

void main() {
  vec3 offset = ray_offset();
  if (!faces(offset)) discard;
  Fragment fragment;
  if (!intersect(line_along(offset), fragment) || !visible(fragment)) discard;
#ifdef EARLIEST
  time = fragment.begin;
#else
  time = fragment.end;
#endif
}
