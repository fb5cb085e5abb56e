// The six-pass mode: an approximation of the exact image, drawn by a GPU without a display.
//
// Source: Heinzle et al. 2010, section 5; model section 8. Per sub-frame of the exposure:
//
//   1  depth at open        the nearest discs at its start, and at its end; with their depth tolerance
//   2  depth at close
//   3  earliest time        that a kernel visible in 1 or 2 covers the pixel, and the latest
//   4  latest time
//   5  blending             of the visible kernels, each weighted by its integral over the sub-frame
//   6  normalisation        Σ I w / Σ I, and the background for the time outside [earliest, latest]
//
// Sub-frames are averaged. Against the exact image this gives up three things: a surface seen at neither end
// of a sub-frame is lost, the time between the earliest and the latest counts as covered throughout, and
// colours of surfaces that replace each other are mixed by their weights, not by their times. All three fade
// with more sub-frames.
//
// Soft coverage (model section 1.4) is a function of an instant, min(1, Σρ/ρ_edge), but the passes know only
// sums over time. With T = latest − earliest, alpha = T · min(1, (ΣI/T) / ρ_edge): the coverage of the mean
// kernel sum. It is exact where nothing moves. What a soft edge leaves of T shows the hidden kernels, all of
// them mixed into one surface with a coverage of the same form, and then the background. That is exact where
// nothing moves and one surface lies behind. Hard coverage leaves nothing of T; it is the paper's.
//
// With soft coverage, the depth of a kernel is that where its weight lies, so that a kernel which is clamped
// nowhere has the depth of the exact image. With hard coverage it is the depth in the middle of its interval.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "splat/export.h"
#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

struct GpuDevice {
  std::string id;  ///< index of an EGL device, or "surfaceless"
  std::string vendor, renderer, version;
  std::string problem;  ///< why it cannot be used; empty: it can
};

/// All devices that could be tried. Error: there is no EGL or OpenGL library.
[[nodiscard]] Result<std::vector<GpuDevice>> list_gpus();

struct GpuOptions {
  /// An id of list_gpus(). Empty: the value of the environment variable SWEPT_GPU; if that is unset too, the
  /// first device that works, with software renderers on the CPU tried last.
  std::string device;
  std::size_t batch_kernels = 1u << 17;  ///< kernels in one buffer; [1, 2²²]. Changes no bit
  /// Frames that may be submitted before the first of them is collected; [1, 16]. With two, one is read back
  /// while the next is drawn. Each takes 24 bytes per pixel of the device's memory.
  std::size_t frames_in_flight = 2;

  [[nodiscard]] Status validate() const;
};

enum class GpuMethod {
  six_pass,  ///< sub-frames of motion
  still,     ///< still frames at the middle of each sub-frame: temporal supersampling, the paper's baseline
};

struct GpuRenderOptions {
  GpuMethod method = GpuMethod::six_pass;
  /// Equal parts of the exposure; [0, 65536]. 0: as many as keep every disc on the film from moving more than
  /// 8 px in a sub-frame, or 1 px between still frames; at most 256.
  int subframes = 1;
  bool lookup_tables = false;  ///< exp and erf from textures, as in the paper, instead of computed
  bool clamp_motion = false;  ///< six passes: bend the motion as the paper's matrix needs it (clamp_motion.h)

  [[nodiscard]] Status validate() const;
};

/// Whether the GPU modes can render the scene; the error names what they cannot do. Sub-frames take the place
/// of motion segments, so Object::segments is not used.
[[nodiscard]] Status check_gpu_scene(const Scene& scene);

/// Renders scenes one after the other. One thread at a time may use it; which one does not matter.
///
/// render() is for one frame. For several, submit() the next frame before collect() of the last: then the
/// device draws the one while the other is read back, converted and written. The images are the same.
class GpuRenderer {
 public:
  [[nodiscard]] static Result<GpuRenderer> create(const GpuOptions& options = {});
  GpuRenderer(GpuRenderer&&) noexcept;
  GpuRenderer& operator=(GpuRenderer&&) noexcept;
  ~GpuRenderer();

  [[nodiscard]] const GpuDevice& device() const;

  /// The film window of the scene, drawn and collected. Errors: as submit() and collect(); frames that are
  /// still to be collected. The renderer stays usable after an error.
  [[nodiscard]] Result<Rendered> render(const Scene& scene, const GpuRenderOptions& options = {},
                                        const RenderControl& control = {});

  /// Lets the device draw the scene and returns before it is drawn; the scene is not needed any more. With
  /// many sub-frames it waits until all but the last two are drawn. Of `control` it uses only stop and
  /// progress, between sub-frames; a frame that was stopped is not pending. Errors: options or scene out of
  /// range, opacity below 1, a film larger than the device's limit, not enough memory on either side,
  /// GpuOptions::frames_in_flight frames that are to be collected first. Frames that were submitted before
  /// can still be collected.
  [[nodiscard]] Status submit(const Scene& scene, const GpuRenderOptions& options = {},
                              const RenderControl& control = {});

  /// Waits for the frame that was submitted first of those not collected, and returns it. Statistics time
  /// each pass by the GPU's own clock where it has one, summed over sub-frames. Errors: nothing is pending,
  /// not enough memory, a device that is lost. After an error this frame is gone; the others are not.
  [[nodiscard]] Result<Rendered> collect();

  /// The number of frames submitted and not collected.
  [[nodiscard]] std::size_t pending() const;
  /// GpuOptions::frames_in_flight.
  [[nodiscard]] std::size_t most_pending() const;

 private:
  class Implementation;
  explicit GpuRenderer(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace swept
