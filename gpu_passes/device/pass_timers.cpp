#include "gpu_passes/device/pass_timers.h"

#include <utility>

namespace swept {

bool PassTimers::available() {
  GLint bits = 0;
  glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &bits);
  return bits > 0;
}

void PassTimers::start(PassSeconds frame) {
  frame_ = std::move(frame);
  while (queries_.size() < frame_->size()) queries_.push_back(GlQuery::make());
}

void PassTimers::time(std::size_t pass, const std::function<void()>& work) {
  if (pass >= frame_->size()) return work();
  glBeginQuery(GL_TIME_ELAPSED, queries_[pass].name());
  work();
  glEndQuery(GL_TIME_ELAPSED);
}

void PassTimers::collect() {
  if (!frame_) return;
  for (std::size_t pass = 0; pass < frame_->size(); ++pass) {
    GLuint64 nanoseconds = 0;
    glGetQueryObjectui64v(queries_[pass].name(), GL_QUERY_RESULT, &nanoseconds);
    (*frame_)[pass] += 1e-9 * static_cast<double>(nanoseconds);
  }
  frame_.reset();
}

}  // namespace swept
