// The convex hull of a kernel's two boxes, drawn as a triangle fan. Source: Heinzle et al. 2010, section
// 4.3 and Fig. 5; the geometry shader of the paper is a choice between two corners here.
//
// Around the hull, each corner of the boxes gives two vertices: the box that reaches farther towards the side
// one comes from, then the box that reaches farther towards the side one goes to. Where one box does both,
// they coincide and their triangle is empty. The box of one disc alone is a fan of four vertices.

#include "frame.glsl"

// 0: the disc at open; 1: the disc at close; 2: all of the tube
uniform int geometry;

layout(location = 0) in vec4 in_plane;
layout(location = 1) in vec4 in_line_u;
layout(location = 2) in vec4 in_line_v;
layout(location = 3) in vec4 in_rate_u;
layout(location = 4) in vec4 in_rate_v;
layout(location = 5) in vec4 in_facing;
layout(location = 6) in vec4 in_color;
layout(location = 7) in vec4 in_anchor;
layout(location = 8) in vec4 in_box_open;   // x_min, y_min, x_max, y_max; px from the window's corner
layout(location = 9) in vec4 in_box_close;

flat out vec4 plane, line_u, line_v, rate_u, rate_v, facing, color, anchor;

vec2 corner_of(vec4 box, int corner) {
  return vec2(corner == 1 || corner == 2 ? box.z : box.x, corner >= 2 ? box.w : box.y);
}

void main() {
  plane = in_plane;
  line_u = in_line_u;
  line_v = in_line_v;
  rate_u = in_rate_u;
  rate_v = in_rate_v;
  facing = in_facing;
  color = in_color;
  anchor = in_anchor;

  vec4 first = geometry == 1 ? in_box_close : in_box_open;
  vec4 second = geometry == 0 ? in_box_open : in_box_close;
  int vertex = geometry == 2 ? gl_VertexID : 2 * gl_VertexID;
  int corner = vertex / 2;
  vec2 a = corner_of(first, corner), b = corner_of(second, corner);
  // The corners in turn: low-low, high-low, high-high, low-high.
  vec2 outward = vec2(corner == 1 || corner == 2 ? 1.0 : -1.0, corner >= 2 ? 1.0 : -1.0);
  bool by_x = (corner % 2 == 0) == (vertex % 2 == 0);
  vec2 reach = outward * (b - a);
  vec2 position = (by_x ? reach.x : reach.y) > 0.0 ? b : a;
  gl_Position = vec4(2.0 * position / window_size - 1.0, 0.0, 1.0);
}
