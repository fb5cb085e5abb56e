// How far a run of several frames is, on stderr.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace swept {

/// A bar on a terminal, with elapsed and remaining time; elsewhere one plain line for each frame.
class Progress {
 public:
  explicit Progress(std::size_t frames);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin_frame(double frame);
  /// `seconds` it took and what it made.
  void end_frame(double frame, double seconds, const std::string& output);
  void skip_frame(double frame, const std::string& output);
  /// A line of its own, above the bar.
  void note(const std::string& text);

 private:
  void draw();
  void clear();

  std::size_t frames_, done_ = 0, rendered_ = 0;
  double current_ = 0.0;
  bool terminal_;
  std::chrono::steady_clock::time_point start_;
};

/// "m:ss" or "h:mm:ss".
[[nodiscard]] std::string clock_text(double seconds);

}  // namespace swept
