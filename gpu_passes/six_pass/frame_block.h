// The C++ side of the uniform block in frame.glsl.
#pragma once

#include <cstddef>

#include <glm/glm.hpp>

namespace swept {

/// std140 layout.
struct FrameBlock {
  glm::vec4 background;
  glm::vec2 window_origin;
  glm::vec2 window_size;
  float near_plane;
  float delta;
  float edge_weight;
  float share;
};
static_assert(offsetof(FrameBlock, background) == 0);
static_assert(offsetof(FrameBlock, window_origin) == 16);
static_assert(offsetof(FrameBlock, window_size) == 24);
static_assert(offsetof(FrameBlock, near_plane) == 32);
static_assert(offsetof(FrameBlock, delta) == 36);
static_assert(offsetof(FrameBlock, edge_weight) == 40);
static_assert(offsetof(FrameBlock, share) == 44);
static_assert(sizeof(FrameBlock) == 48);

}  // namespace swept
