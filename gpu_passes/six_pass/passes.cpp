#include "gpu_passes/six_pass/passes.h"

#include <limits>

#include "gpu_passes/six_pass/gaussian_table.h"

namespace swept {
namespace {

constexpr float no_limit = std::numeric_limits<float>::max();
constexpr PassInput open_limit{"limit_open", Target::limit_open};
constexpr PassInput close_limit{"limit_close", Target::limit_close};
constexpr PassInput same_limit{"limit_close", Target::limit_open};

Pass nearest_depth(const char* name, Geometry end, Target limit) {
  return {.name = name,
          .program = ProgramId::depth,
          .geometry = end,
          .targets = {limit},
          .depth_test = true,
          .clear_to = no_limit};
}

/// Cleared so that, where nothing is drawn, earliest is after latest.
Pass earliest_time(const char* name) {
  return {.name = name,
          .program = ProgramId::earliest,
          .geometry = Geometry::tube,
          .targets = {Target::earliest},
          .blend = Blend::minimum,
          .clear_to = 2.0f,
          .inputs = {open_limit, close_limit}};
}
Pass latest_time(const char* name) {
  return {.name = name,
          .program = ProgramId::latest,
          .geometry = Geometry::tube,
          .targets = {Target::latest},
          .blend = Blend::maximum,
          .clear_to = -1.0f,
          .inputs = {open_limit, close_limit}};
}

/// The same time everywhere.
Pass constant_time(const char* name, Target target, float time) {
  return {.name = name,
          .program = ProgramId::earliest,
          .geometry = Geometry::nothing,
          .targets = {target},
          .clear_to = time};
}

Pass blending(const char* name, PassInput close) {
  return {.name = name,
          .program = ProgramId::blend,
          .geometry = Geometry::tube,
          .targets = {Target::color_sum, Target::behind_sum, Target::depth_sum},
          .blend = Blend::add,
          .inputs = {open_limit, close}};
}

Pass normalization(const char* name) {
  return {.name = name,
          .program = ProgramId::normalize,
          .geometry = Geometry::window,
          .targets = {Target::frame_color, Target::frame_depth},
          .blend = Blend::add,
          .clears = false,
          .inputs = {{"earliest", Target::earliest},
                     {"latest", Target::latest},
                     {"color_sum", Target::color_sum},
                     {"behind_sum", Target::behind_sum},
                     {"depth_sum", Target::depth_sum}}};
}

}  // namespace

std::span<const Pass> six_passes() {
  static const std::vector<Pass> passes{
      nearest_depth("pass 1 depth at open", Geometry::open, Target::limit_open),
      nearest_depth("pass 2 depth at close", Geometry::close, Target::limit_close),
      earliest_time("pass 3 earliest time"),
      latest_time("pass 4 latest time"),
      blending("pass 5 blending", close_limit),
      normalization("pass 6 normalisation"),
  };
  return passes;
}

std::span<const Pass> still_passes() {
  static const std::vector<Pass> passes{
      nearest_depth("depth", Geometry::open, Target::limit_open),
      constant_time("earliest time", Target::earliest, 0.0f),
      constant_time("latest time", Target::latest, 1.0f),
      blending("blending", same_limit),
      normalization("normalisation"),
  };
  return passes;
}

GLenum internal_format(Target target) {
  switch (channels(target)) {
    case 4:
      return GL_RGBA32F;
    case 2:
      return GL_RG32F;
    default:
      return GL_R32F;
  }
}

int channels(Target target) {
  switch (target) {
    case Target::color_sum:
    case Target::behind_sum:
    case Target::frame_color:
      return 4;
    case Target::depth_sum:
    case Target::frame_depth:
      return 2;
    default:
      return 1;
  }
}

ProgramSource program_source(ProgramId program) {
  switch (program) {
    case ProgramId::depth:
      return {"footprint.vert", "depth.frag", {}};
    case ProgramId::earliest:
      return {"footprint.vert", "time.frag", {"EARLIEST"}};
    case ProgramId::latest:
      return {"footprint.vert", "time.frag", {}};
    case ProgramId::blend:
      return {"footprint.vert", "blend.frag", {}};
    case ProgramId::blend_tables:
      return {
          "footprint.vert", "blend.frag", {"LOOKUP_TABLES", "TABLE_RANGE " + std::to_string(table_range)}};
    case ProgramId::normalize:
      break;
  }
  return {"fullscreen.vert", "normalize.frag", {}};
}

}  // namespace swept
