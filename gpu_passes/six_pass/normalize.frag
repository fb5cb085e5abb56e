// Pass 6: normalisation, and the background for the time in which nothing covers it. Source: Heinzle et al. 2010,
// section 5.4; soft coverage as gpu_renderer.h says.

#include "frame.glsl"

uniform sampler2D earliest;
uniform sampler2D latest;
uniform sampler2D color_sum;
uniform sampler2D behind_sum;
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
    vec2 depths = texelFetch(depth_sum, pixel, 0).rg;
    color = alpha * (sum / sum.a);
    depth = vec2(alpha * (depths.x / sum.a), alpha);
    // What the soft edge leaves of the covered time goes to the hidden surfaces first.
    vec4 behind = texelFetch(behind_sum, pixel, 0);
    if (behind.a > 0.0) {
      float alpha_behind = (covered - alpha) * min(1.0, behind.a / (covered * edge_weight));
      color += alpha_behind * (behind / behind.a);
      depth += vec2(alpha_behind * (depths.y / behind.a), alpha_behind);
    }
    color += (1.0 - depth.y) * background;
  }
  frame_color = share * color;
  frame_depth = share * depth;
}
