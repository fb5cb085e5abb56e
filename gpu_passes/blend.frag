// Pass 5: visible kernels, weighted by their integrals over the sub-frame. Source: Heinzle et al. 2010,
// section 5.3.
#include "kernel.glsl"
#include "gaussian.glsl"

layout(location = 0) out vec4 color_sum;
layout(location = 1) out float depth_sum;

void main() {
  vec3 offset = ray_offset();
  if (!faces(offset)) discard;
  Fragment fragment;
  if (!intersect(line_along(offset), fragment) || !visible(fragment)) discard;
  float integral = fragment.peak * fragment.duration * mean_gaussian(fragment.y_begin, fragment.y_end);
  color_sum = integral * vec4(color.rgb, 1.0);
  depth_sum = integral * 0.5 * (fragment.z_begin + fragment.z_end);
}
