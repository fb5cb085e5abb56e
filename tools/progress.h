// How far a run of several frames is, on stderr.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace swept {

/// A bar on a terminal, with elapsed and remaining time; elsewhere one plain line for each frame. finish()
/// leaves a line that says what was done.
class Progress {
 public:
  explicit Progress(std::size_t frames);
  /// For tests: as on a terminal, or not.
  Progress(std::size_t frames, bool terminal);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin_frame(double frame);
  /// The share of the frame that is done, in [0, 1]; as RenderControl::progress, from any thread.
  void within_frame(double share);
  /// `seconds` it took and what it made.
  void end_frame(double frame, double seconds, const std::string& output);
  void skip_frame(double frame, const std::string& output);
  /// A line of its own, above the bar.
  void note(const std::string& text);
  /// The last line, which stays, with a remark on all frames.
  void finish(const std::string& remark = "");

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] double elapsed() const;
  void draw();
  void clear() const;

  std::mutex mutex_;
  std::size_t frames_, done_ = 0, rendered_ = 0;
  double current_ = 0.0, share_ = 0.0;
  bool terminal_;
  Clock::time_point start_, drawn_;
};

/// "m:ss" or "h:mm:ss".
[[nodiscard]] std::string clock_text(double seconds);

}  // namespace swept
