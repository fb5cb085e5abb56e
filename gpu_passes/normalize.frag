// Pass 6: normalisation, and the background for the time in which nothing covers it. Source: Heinzle et al. 2010,
// section 5.4; soft coverage as gpu_renderer.h says.

#include "frame.glsl"

uniform sampler2D earliest;
uniform sampler2D latest;
uniform sampler2D color_sum;
uniform sampler2D depth_sum;

layout(location = 0) out vec4 frame_color;
layout(location = 1) out vec2 frame_depth;  // weighted by alpha, and alpha

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 sum = texelFetch(color_sum, pixel, 0);
  float covered = texelFetch(latest, pixel, 0).r - texelFetch(earliest, pixel, 0).r;
  vec4 color = background;
  vec2 depth = vec2(0.0);
  if (sum.a > 0.0 && covered > 0.0) {
    float alpha = edge_weight > 0.0 ? min(covered, sum.a / edge_weight) : covered;
    color = alpha * (sum / sum.a) + (1.0 - alpha) * background;
    depth = vec2(alpha * (texelFetch(depth_sum, pixel, 0).r / sum.a), alpha);
  }
  frame_color = share * color;
  frame_depth = share * depth;
}
