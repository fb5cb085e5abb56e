// Progress told by whichever thread comes first, once at a time and never backwards. For the project's own
// sources.
#pragma once

#include <cstddef>
#include <mutex>

#include "splat/render_control.h"
#include "splat/without_throwing.h"

namespace swept {

class ProgressOf {
 public:
  /// `control` must outlive it.
  ProgressOf(const RenderControl& control, std::size_t steps) : control_(control), steps_(steps) {}

  void one_more() {
    if (!control_.progress) return;
    const std::lock_guard lock(mutex_);
    tell(static_cast<double>(++done_) / static_cast<double>(steps_));
  }
  void reached(double share) {
    if (!control_.progress) return;
    const std::lock_guard lock(mutex_);
    tell(share);
  }

 private:
  void tell(double share) {
    if (share > told_) call_back(control_.progress, told_ = share);
  }

  const RenderControl& control_;
  std::size_t steps_, done_ = 0;
  double told_ = 0.0;
  std::mutex mutex_;
};

}  // namespace swept
