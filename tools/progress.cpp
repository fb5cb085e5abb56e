#include "tools/progress.h"

#include <unistd.h>
#include <cmath>

#include <algorithm>

#include "splat/result.h"
#include "tools/console.h"

namespace swept {

std::string clock_text(double seconds) {
  const auto whole = std::llround(seconds);
  if (whole >= 3600) return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

Progress::Progress(std::size_t frames) : Progress(frames, isatty(STDERR_FILENO) == 1) {}

Progress::Progress(std::size_t frames, bool terminal)
    : frames_(frames), terminal_(terminal), start_(Clock::now()), drawn_(start_) {}

Progress::~Progress() { clear(); }

double Progress::elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

void Progress::begin_frame(double frame) {
  const std::lock_guard lock(mutex_);
  current_ = frame;
  share_ = 0.0;
  draw();
}

void Progress::within_frame(double share) {
  const std::lock_guard lock(mutex_);
  share_ = std::clamp(share, share_, 1.0);
  // Often enough to be seen moving, and no more than that: terminals are slow.
  constexpr std::chrono::milliseconds pause(100);
  if (Clock::now() - drawn_ >= pause) draw();
}

void Progress::end_frame(double frame, double seconds, const std::string& output) {
  const std::lock_guard lock(mutex_);
  ++done_;
  ++rendered_;
  share_ = 0.0;
  if (terminal_)
    draw();
  else
    log("frame {}: {} of {}, {:.2f} s, {}\n", frame, done_, frames_, seconds, printable(output));
}

void Progress::skip_frame(double frame, const std::string& output) {
  {
    const std::lock_guard lock(mutex_);
    ++done_;
  }
  note(fmt::format("frame {}: {} of {}, {} exists", frame, done_, frames_, output));
}

void Progress::note(const std::string& text) {
  const std::lock_guard lock(mutex_);
  clear();
  log("{}\n", printable(text));
  draw();
}

void Progress::finish(const std::string& remark) {
  const std::lock_guard lock(mutex_);
  clear();
  const std::size_t skipped = done_ - rendered_;
  log("{} frame{} in {}{}{}\n", rendered_, rendered_ == 1 ? "" : "s", clock_text(elapsed()),
      skipped > 0 ? fmt::format(", {} skipped", skipped) : "", printable(remark));
  terminal_ = false;
}

void Progress::draw() {
  if (!terminal_) return;
  drawn_ = Clock::now();
  constexpr double width = 30.0;
  const double rendered = static_cast<double>(rendered_) + share_;
  const double all = static_cast<double>(frames_);
  const double done = frames_ > 0 ? std::min(1.0, (static_cast<double>(done_) + share_) / all) : 1.0;
  const auto filled = static_cast<std::size_t>(width * done);
  // Skipped frames took no time, and say nothing about the rest.
  const double left = all - static_cast<double>(done_) - share_;
  const std::string remaining = rendered > 0.0 ? clock_text(elapsed() / rendered * left) : "?";
  log("\r\x1b[K[{}{}] {:.0f}%, {} of {}, frame {}, elapsed {}, remaining {}", std::string(filled, '#'),
      std::string(static_cast<std::size_t>(width) - filled, '.'), 100.0 * done, done_, frames_, current_,
      clock_text(elapsed()), remaining);
  std::fflush(stderr);
}

void Progress::clear() const {
  if (terminal_) log("\r\x1b[K");
}

}  // namespace swept
