// What every renderer of a scene does first. For the project's own sources.
#pragma once

#include <new>

#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// render(scene, options), if both are in range and memory suffices; nothing else is thrown.
template <class Options>
[[nodiscard]] Result<Rendered> render_valid(const Scene& scene, const Options& options,
                                            Result<Rendered> (*render)(const Scene&, const Options&)) {
  if (Status status = options.validate(); !status) return status.error();
  if (Status status = scene.validate(); !status) return status.error();
  try {
    return render(scene, options);
  } catch (const std::bad_alloc&) {
    return Error{"", "", "not enough memory to render the frame"};
  }
}

}  // namespace swept
