// What a sub-frame's passes share. Mirrored in frame_block.h.
layout(std140) uniform Frame {
  vec4 background;     // linear, premultiplied
  vec2 window_origin;  // px
  vec2 window_size;    // px
  float near_plane;
  float delta;        // of exp(-delta r^2)
  float edge_weight;  // sum of kernels at which soft coverage is full; 0: hard coverage
  float share;        // of this sub-frame in the exposure
};
