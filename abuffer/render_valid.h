// What every renderer of a scene does first. For the project's own sources.
#pragma once

#include <algorithm>
#include <new>

#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "splat/overscan.h"
#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// What a render that was stopped returns.
[[nodiscard]] inline Error stopped_error() { return Error{"", "", "the render was stopped"}; }

/// work(), which returns a Result<Rendered>, on as many threads as `control` allows and the machine has: a
/// larger arena gains nothing, and makes oneTBB print a warning. What runs out is memory, and nothing else is
/// thrown.
template <class Work>
[[nodiscard]] Result<Rendered> run_in_arena(const RenderControl& control, const Work& work) {
  try {
    const int available = tbb::info::default_concurrency();
    tbb::task_arena arena(control.threads > 0 ? std::min(control.threads, available) : available);
    return arena.execute(work);
  } catch (const std::bad_alloc&) {
    return Error{"", "", "not enough memory to render the frame"};
  }
}

/// render(scene, options, control) in such an arena, if all are in range.
template <class Options, class Render>
[[nodiscard]] Result<Rendered> render_valid(const Scene& scene, const Options& options,
                                            const RenderControl& control, const Render& render) {
  if (Status status = options.validate(); !status) return status.error();
  if (Status status = control.validate(); !status) return status.error();
  if (Status status = scene.validate(); !status) return status.error();
  return run_in_arena(control, [&]() -> Result<Rendered> {
    return render_overscan(
        scene, [&](const Scene& on_film) -> Result<Rendered> { return render(on_film, options, control); });
  });
}

}  // namespace swept
