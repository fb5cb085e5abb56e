#include "tools/progress.h"

#include <unistd.h>

#include <cstdio>

#include <fmt/core.h>

namespace swept {

std::string clock_text(double seconds) {
  const auto whole = static_cast<long long>(seconds + 0.5);
  if (whole >= 3600) return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

Progress::Progress(std::size_t frames)
    : frames_(frames), terminal_(isatty(STDERR_FILENO) == 1), start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() { clear(); }

void Progress::begin_frame(double frame) {
  current_ = frame;
  draw();
}

void Progress::end_frame(double frame, double seconds, const std::string& output) {
  ++done_;
  ++rendered_;
  if (terminal_)
    draw();
  else
    fmt::print(stderr, "frame {}: {} of {}, {:.2f} s, {}\n", frame, done_, frames_, seconds, output);
}

void Progress::skip_frame(double frame, const std::string& output) {
  ++done_;
  note(fmt::format("frame {}: {} of {}, {} exists", frame, done_, frames_, output));
}

void Progress::note(const std::string& text) {
  clear();
  fmt::print(stderr, "{}\n", text);
  draw();
}

void Progress::draw() {
  if (!terminal_) return;
  constexpr std::size_t width = 30;
  const std::size_t filled = frames_ > 0 ? width * done_ / frames_ : width;
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  // Skipped frames took no time, and say nothing about the rest.
  const std::string remaining =
      rendered_ > 0
          ? clock_text(elapsed / static_cast<double>(rendered_) * static_cast<double>(frames_ - done_))
          : "?";
  fmt::print(stderr, "\r\x1b[K[{}{}] {}/{}, frame {}, elapsed {}, remaining {}", std::string(filled, '#'),
             std::string(width - filled, '.'), done_, frames_, current_, clock_text(elapsed), remaining);
  std::fflush(stderr);
}

void Progress::clear() {
  if (terminal_) fmt::print(stderr, "\r\x1b[K");
}

}  // namespace swept
