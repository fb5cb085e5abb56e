// Passes 3 and 4: when visible kernels cover the pixel, first and last. Source: Heinzle et al. 2010, section 5.2.
// Which of the two it is, the blend equation says.
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
