#include "gpu_passes/passes.h"

#include <limits>

namespace swept {
namespace {

constexpr float no_limit = std::numeric_limits<float>::max();
constexpr PassInput open_limit{"limit_open", Target::limit_open};
constexpr PassInput close_limit{"limit_close", Target::limit_close};
constexpr PassInput same_limit{"limit_close", Target::limit_open};

Pass normalization(const char* name) {
  return {name,
          ProgramId::normalize,
          Geometry::window,
          {Target::frame_color, Target::frame_depth},
          Blend::add,
          false,
          false,
          0.0f,
          {{"earliest", Target::earliest},
           {"latest", Target::latest},
           {"color_sum", Target::color_sum},
           {"behind_sum", Target::behind_sum},
           {"depth_sum", Target::depth_sum}}};
}

Pass blending(const char* name, PassInput close) {
  return {name,
          ProgramId::blend,
          Geometry::tube,
          {Target::color_sum, Target::behind_sum, Target::depth_sum},
          Blend::add,
          false,
          true,
          0.0f,
          {open_limit, close}};
}

}  // namespace

std::span<const Pass> six_passes() {
  static const std::vector<Pass> passes{
      {"pass 1 depth at open",
       ProgramId::depth,
       Geometry::open,
       {Target::limit_open},
       Blend::replace,
       true,
       true,
       no_limit,
       {}},
      {"pass 2 depth at close",
       ProgramId::depth,
       Geometry::close,
       {Target::limit_close},
       Blend::replace,
       true,
       true,
       no_limit,
       {}},
      {"pass 3 earliest time",
       ProgramId::earliest,
       Geometry::tube,
       {Target::earliest},
       Blend::minimum,
       false,
       true,
       2.0f,
       {open_limit, close_limit}},
      {"pass 4 latest time",
       ProgramId::latest,
       Geometry::tube,
       {Target::latest},
       Blend::maximum,
       false,
       true,
       -1.0f,
       {open_limit, close_limit}},
      blending("pass 5 blending", close_limit),
      normalization("pass 6 normalisation"),
  };
  return passes;
}

std::span<const Pass> still_passes() {
  static const std::vector<Pass> passes{
      {"depth",
       ProgramId::depth,
       Geometry::open,
       {Target::limit_open},
       Blend::replace,
       true,
       true,
       no_limit,
       {}},
      {"earliest time",
       ProgramId::earliest,
       Geometry::nothing,
       {Target::earliest},
       Blend::replace,
       false,
       true,
       0.0f,
       {}},
      {"latest time",
       ProgramId::latest,
       Geometry::nothing,
       {Target::latest},
       Blend::replace,
       false,
       true,
       1.0f,
       {}},
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
