// The passes as data: what each draws, with which program, into what, and how it is blended.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <epoxy/gl.h>

namespace swept {

/// What passes write and later ones read: a texture the size of the window each.
enum class Target {
  limit_open,   ///< depth of the nearest disc at open plus its tolerance; huge where there is none
  limit_close,  ///< the same at close
  earliest,     ///< share of the sub-frame; above `latest` where nothing covers the pixel
  latest,
  color_sum,    ///< Σ I w, Σ I
  behind_sum,   ///< the same of hidden kernels; 0 for hard coverage
  depth_sum,    ///< Σ I z, and of hidden kernels
  frame_color,  ///< of all sub-frames: linear, premultiplied RGBA
  frame_depth,  ///< Σ alpha z, Σ alpha
};
inline constexpr int target_count = 9;
[[nodiscard]] GLenum internal_format(Target target);
[[nodiscard]] int channels(Target target);

enum class ProgramId { depth, earliest, latest, blend, blend_tables, normalize };
inline constexpr int program_count = 6;

/// Files and #define words of a program.
struct ProgramSource {
  const char *vertex, *fragment;
  std::vector<std::string> defines;
};
[[nodiscard]] ProgramSource program_source(ProgramId program);

/// The numbers of the first three are those of footprint.vert.
enum class Geometry { open = 0, close = 1, tube = 2, window = 3, nothing = 4 };
enum class Blend { replace, minimum, maximum, add };

/// A sampler of the program, and the target behind it.
struct PassInput {
  const char* sampler;
  Target target;
};

struct Pass {
  const char* name;
  ProgramId program;
  Geometry geometry;
  std::vector<Target> targets;  ///< in the order of the shader's outputs
  Blend blend = Blend::replace;
  bool depth_test = false;  ///< nearest first, against a depth buffer cleared for this pass
  bool clears = true;       ///< to `clear_to`, all channels; else adds to what is there
  float clear_to = 0.0f;
  std::vector<PassInput> inputs = {};
};

/// The passes of a sub-frame of motion.
[[nodiscard]] std::span<const Pass> six_passes();
/// Those of a still frame: what is seen at open is seen all the time.
[[nodiscard]] std::span<const Pass> still_passes();

}  // namespace swept
