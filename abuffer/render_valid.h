// What every renderer of a scene does first. For the project's own sources.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <stop_token>
#include <string>

#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include "splat/overscan.h"
#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"
#include "splat/without_throwing.h"

namespace swept {

/// work(), which returns a Result, on as many threads as `control` allows and the machine has: a larger arena
/// gains nothing, and makes oneTBB print a warning. What is thrown becomes an error, that there is not enough
/// memory `for_what` among them.
template <class Work>
[[nodiscard]] auto run_in_arena(const RenderControl& control, const Work& work,
                                const char* for_what = "to render the frame") noexcept -> decltype(work()) {
  return without_throwing(for_what, [&] {
    const int available = tbb::info::default_concurrency();
    tbb::task_arena arena(control.threads > 0 ? std::min(control.threads, available) : available);
    return arena.execute([&]() -> decltype(work()) {
      // All loops within are of this context: a stop ends them, whatever they do.
      tbb::task_group_context context(tbb::task_group_context::isolated);
      tbb::task_group group(context);
      const std::stop_callback on_stop(control.stop, [&context] { context.cancel_group_execution(); });
      std::optional<decltype(work())> result;
      group.run_and_wait([&] { result.emplace(work()); });
      if (!result) throw Stopped();
      return std::move(*result);
    });
  });
}

/// Whether what takes `bytes` is within RenderControl::max_bytes.
[[nodiscard]] inline Status check_bytes(std::size_t bytes, const RenderControl& control, const char* what) {
  if (control.max_bytes == 0 || bytes <= control.max_bytes) return Done{};
  return Error{"", "max_bytes", std::string(what) + " alone take " + std::to_string(bytes) + " bytes",
               ErrorKind::out_of_memory};
}

/// render(scene, options, control) in such an arena, if all are in range.
template <class Options, class Render>
[[nodiscard]] Result<Rendered> render_valid(const Scene& scene, const Options& options,
                                            const RenderControl& control, const Render& render) noexcept {
  return without_throwing("to render the frame", [&]() -> Result<Rendered> {
    if (Status status = options.validate(); !status) return status.error();
    if (Status status = control.validate(); !status) return status.error();
    if (Status status = scene.validate(); !status) return status.error();
    Result<Rendered> rendered = run_in_arena(control, [&]() -> Result<Rendered> {
      return render_overscan(
          scene, [&](const Scene& on_film) -> Result<Rendered> { return render(on_film, options, control); });
    });
    if (rendered && control.log)
      for (const std::string& effect : rendered->statistics.effects) call_back(control.log, effect);
    return rendered;
  });
}

}  // namespace swept
