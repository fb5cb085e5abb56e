// Pass 5: visible kernels, weighted by their integrals over the sub-frame. Source: Heinzle et al. 2010,
// section 5.3. For soft coverage hidden kernels too, apart from them: a soft edge lets some of them through.
#include "kernel.glsl"
#include "gaussian.glsl"

layout(location = 0) out vec4 color_sum;
layout(location = 1) out vec4 behind_sum;
layout(location = 2) out vec2 depth_sum;  // of the two

void main() {
  vec3 offset = ray_offset();
  if (!faces(offset)) discard;
  Fragment fragment;
  if (!intersect(line_along(offset), fragment)) discard;
  bool front = visible(fragment);
  if (!front && edge_weight == 0.0) discard;
  float mean = mean_gaussian(fragment.y_begin, fragment.y_end);
  float integral = fragment.peak * fragment.duration * mean;
  vec4 value = integral * vec4(color.rgb, 1.0);
  // Soft coverage is where the weight is, hard coverage the same at all times.
  float place = edge_weight > 0.0 ? gaussian_centroid(fragment.y_begin, fragment.y_end, mean) : 0.0;
  float depth = integral * mix(fragment.z_begin, fragment.z_end, 0.5 + place);
  color_sum = front ? value : vec4(0.0);
  behind_sum = front ? vec4(0.0) : value;
  depth_sum = front ? vec2(depth, 0.0) : vec2(0.0, depth);
}
