// A moving kernel along one viewing ray. Source: model sections 2 and 3; Heinzle et al. 2010, Eq. 15 to 21. The
// same as splat/kernel/ray_kernel.h, in single precision. What float needs and double does not:
//
//   pixels   positions are taken relative to the kernel's anchor, near its projected centre, whole pixels and
//            the fraction apart, so that no digits go into where on the film it is;
//   times    the stretch of a fast kernel is measured along its line, not as a difference of two times.

#include "frame.glsl"

// Affine in the offset from the anchor: value = x + y * offset.x + z * offset.y. All of the line's six numbers
// are such a value divided by that of `plane`.
flat in vec4 plane;    // d.n; w: n.c, over which the depth
flat in vec4 line_u;   // d.(a2 x c); w: n.m, over which the depth's rate
flat in vec4 line_v;   // d.(c x a1); w: weight of the filtered disc
flat in vec4 rate_u;   // d.(a2 x m); w: depth tolerance
flat in vec4 rate_v;   // d.(m x a1)
flat in vec4 facing;   // seen where it is below 0; w: 0 for a disc seen from both sides
flat in vec4 color;    // linear
flat in vec4 anchor;   // px: whole pixel, and the offset of the anchor from that pixel's centre

struct Line {
  float u, v, z, du, dv, dz;  // at the middle of the sub-frame, and their rates
};

// The kernel in its interval of visibility. Times are shares of the sub-frame.
struct Fragment {
  float begin, end, duration;
  float y_begin, y_end;  // the kernel is peak * exp(-y*y), y linear in time
  float peak;
  float z_begin, z_end;
};

vec3 ray_offset() {
  vec2 whole = floor(gl_FragCoord.xy) + window_origin - anchor.xy;
  return vec3(1.0, whole - anchor.zw);
}

bool faces(vec3 offset) { return facing.w == 0.0 || !(dot(facing.xyz, offset) >= 0.0); }

Line line_along(vec3 offset) {
  float inverse = 1.0 / dot(plane.xyz, offset);
  return Line(dot(line_u.xyz, offset) * inverse, dot(line_v.xyz, offset) * inverse, plane.w * inverse,
              dot(rate_u.xyz, offset) * inverse, dot(rate_v.xyz, offset) * inverse, line_u.w * inverse);
}

// Tube, sub-frame and what lies beyond the near plane. False where that is empty.
bool intersect(Line line, out Fragment fragment) {
  float begin = 0.0, end = 1.0, along = 0.0, nearest_squared;
  float position_begin = 0.0, position_end = 0.0;  // along the line, from the point nearest the disc's centre
  bool cut = false;
  float speed = length(vec2(line.du, line.dv));
  if (speed > 0.0) {
    vec2 direction = vec2(line.du, line.dv) / speed;
    float across = line.u * direction.y - line.v * direction.x;
    if (!(abs(across) <= 1.0)) return false;
    nearest_squared = across * across;
    along = line.u * direction.x + line.v * direction.y;
    float half_chord = sqrt((1.0 - across) * (1.0 + across));
    position_begin = along - 0.5 * speed;
    position_end = along + 0.5 * speed;
    if (position_begin < -half_chord) {
      position_begin = -half_chord;
      begin = 0.5 + (-half_chord - along) / speed;
      cut = true;
    }
    if (position_end > half_chord) {
      position_end = half_chord;
      end = 0.5 + (half_chord - along) / speed;
      cut = true;
    }
  } else {
    nearest_squared = line.u * line.u + line.v * line.v;
    if (!(nearest_squared <= 1.0)) return false;
  }
  bool cut_near = false;
  if (line.dz != 0.0) {
    float crossing = 0.5 + (near_plane - line.z) / line.dz;
    if (line.dz < 0.0 && crossing < end) {
      end = crossing;
      position_end = along + speed * (crossing - 0.5);
      cut_near = true;
    }
    if (line.dz > 0.0 && crossing > begin) {
      begin = crossing;
      position_begin = along + speed * (crossing - 0.5);
      cut_near = true;
    }
  } else if (!(line.z >= near_plane)) {
    return false;
  }
  fragment.duration = 1.0;
  if (cut || cut_near) {
    bool fast = speed > 1.0 && !cut_near;
    fragment.duration = fast ? (position_end - position_begin) / speed : end - begin;
    if (!(fragment.duration > 0.0)) return false;
  }
  float root_delta = sqrt(delta);
  fragment.begin = begin;
  fragment.end = end;
  fragment.y_begin = root_delta * position_begin;
  fragment.y_end = root_delta * position_end;
  fragment.peak = line_v.w * exp(-delta * nearest_squared);
  fragment.z_begin = line.z + line.dz * (begin - 0.5);
  fragment.z_end = line.z + line.dz * (end - 0.5);
  return true;
}

// Depth limits of the surfaces seen at open and at close: depth of the nearest disc, and its tolerance beyond.
uniform sampler2D limit_open;
uniform sampler2D limit_close;

bool visible(Fragment fragment) {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float nearest = min(fragment.z_begin, fragment.z_end);
  return nearest <= texelFetch(limit_open, pixel, 0).r || nearest <= texelFetch(limit_close, pixel, 0).r;
}
