// Runs the cells of a study one after the other, keeps what they gave on disk, and says how far it is.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "splat/image.h"
#include "splat/result.h"
#include "tools/study/cell.h"
#include "tools/study/methods.h"
#include "tools/study/variant.h"

namespace swept {

struct RunnerOptions {
  std::string folder;  ///< of the study
  int repeats = 3;     ///< timed renders of each cell
  int reference_samples = 1024;
  MethodOptions method;
  double limit_seconds = 900.0;  ///< for one render; the reference has ten times as long
};

/// One scene with the settings to be run on it.
struct Task {
  Variant variant;
  VariantFacts facts;
  std::vector<Setting> settings;
  bool pictures = false;  ///< keep images and make previews
};

class Runner {
 public:
  explicit Runner(RunnerOptions options) : options_(std::move(options)) {}

  /// Announces what is going to be run, for the time remaining.
  void plan(const Task& task);

  /// Runs what of the task is not on disk already: the reference, then all settings, in rounds, each round in
  /// the opposite order of the last, so that a drift of the machine falls on all alike. A cell that fails is
  /// kept as failed, and tried again by the next study. The error is of the folder, not of a cell.
  [[nodiscard]] Status run(const Task& task) { return run(task, options_.repeats); }
  [[nodiscard]] Status run(const Task& task, int repeats);

  [[nodiscard]] const Cell& reference(const Task& task) const;
  [[nodiscard]] const Cell& cell(const Task& task, const Setting& setting) const;
  /// Paths relative to the folder.
  [[nodiscard]] static std::string picture(const Task& task, const Setting& setting);
  [[nodiscard]] static std::string difference(const Task& task, const Setting& setting);
  [[nodiscard]] Setting reference_of() const { return reference_setting(options_.reference_samples); }

 private:
  using Place = std::pair<std::string, std::string>;  ///< ids of variant and setting

  [[nodiscard]] bool files_are_there(const Task& task, const Setting& setting) const;
  Cell& load(const Task& task, const Setting& setting);
  void render(const Task& task, Cell& cell);
  [[nodiscard]] Status measure(const Task& task, Cell& cell);
  [[nodiscard]] Status finish(const Task& task, Cell& cell);
  void report(const Task& task, const Cell& cell);
  [[nodiscard]] double seconds_left() const;
  [[nodiscard]] std::string path(const char* kind, const Task& task, const Setting& setting,
                                 const char* extension) const;

  RunnerOptions options_;
  std::map<Place, Cell> cells_;
  std::map<Place, int> left_;  ///< renders planned and not done
  int renders_ = 0, planned_ = 0;
  double rendered_seconds_ = 0.0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::string reference_id_;  ///< of the variant whose reference is held
  Image reference_image_;
};

}  // namespace swept
