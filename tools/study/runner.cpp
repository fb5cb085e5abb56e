#include "tools/study/runner.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include <fmt/core.h>

#include "splat/io/image_file.h"
#include "tools/console.h"
#include "tools/progress.h"
#include "tools/study/difference_map.h"
#include "tools/study/worker.h"

namespace swept {
namespace {

/// Changes with every build: figures of two builds are never shown side by side.
std::string build_id() {
  std::error_code code;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", code);
  const auto size = std::filesystem::file_size(program, code);
  const auto written = std::filesystem::last_write_time(program, code).time_since_epoch().count();
  return fmt::format("{}-{}-{}", SWEPT_VERSION, size, written);
}

}  // namespace

std::string Runner::path(const char* kind, const Task& task, const Setting& setting,
                         const char* extension) const {
  return fmt::format("{}/{}/{}/{}{}", options_.folder, kind, task.variant.id, setting_id(setting), extension);
}

std::string Runner::picture(const Task& task, const Setting& setting) {
  return fmt::format("images/{}/{}.png", task.variant.id, setting_id(setting));
}

std::string Runner::difference(const Task& task, const Setting& setting) {
  return fmt::format("images/{}/{}.difference.png", task.variant.id, setting_id(setting));
}

const Cell& Runner::cell(const Task& task, const Setting& setting) const {
  return cells_.at({task.variant.id, setting_id(setting)});
}

const Cell& Runner::reference(const Task& task) const { return cell(task, reference_of()); }

/// What a later run needs of an earlier one.
bool Runner::files_are_there(const Task& task, const Setting& setting) const {
  const auto is_there = [](const std::string& file) {
    std::error_code code;
    return std::filesystem::exists(file, code);
  };
  if (setting == reference_of() && !is_there(path("images", task, setting, ".exr"))) return false;
  if (!task.pictures) return true;
  return is_there(options_.folder + '/' + picture(task, setting)) &&
         (setting == reference_of() || is_there(options_.folder + '/' + difference(task, setting)));
}

Cell& Runner::load(const Task& task, const Setting& setting) {
  static const std::string build = build_id();
  const Place place{task.variant.id, setting_id(setting)};
  if (const auto found = cells_.find(place); found != cells_.end()) return found->second;
  Cell cell;
  cell.setting = setting;
  cell.key = fmt::format("{} {} {} reference {} threads {} gpu {} pictures {}", build, task.facts.hash,
                         setting_id(setting), options_.reference_samples, options_.method.threads,
                         options_.method.gpu, task.pictures ? 1 : 0);
  const auto known = load_cell(path("data", task, setting, ".json"), cell.key);
  if (known && files_are_there(task, setting)) cell = *known;
  return cells_.emplace(place, std::move(cell)).first->second;
}

void Runner::plan(const Task& task) {
  const auto add = [&](const Setting& setting, int repeats) {
    const int missing = std::max(0, repeats - static_cast<int>(load(task, setting).seconds.size()));
    left_[{task.variant.id, setting_id(setting)}] = missing;
    planned_ += missing;
  };
  add(reference_of(), 1);
  for (const Setting& setting : task.settings) add(setting, options_.repeats);
}

double Runner::seconds_left() const {
  const double typical = renders_ > 0 ? rendered_seconds_ / renders_ : 1.0;
  double seconds = 0.0;
  for (const auto& [place, renders] : left_) {
    const Cell& cell = cells_.at(place);
    seconds += renders * (cell.seconds.empty() ? typical : spread_of(cell.seconds).median);
  }
  return seconds;
}

void Runner::report(const Task& task, const Cell& cell) {
  const StudyMethod* method = find_study_method(cell.setting.method);
  const std::string number = setting_text(cell.setting);
  const std::string name = method != nullptr ? method->name + (number.empty() ? "" : ", " + number)
                                             : fmt::format("reference, {} stills", cell.setting.value);
  std::string what =
      cell.error.empty() ? fmt::format("{:.3g} s", cell.seconds.back()) : "FAILED: " + cell.error;
  if (cell.error.empty() && cell.accuracy) what += fmt::format(", {:.1f} dB", cell.accuracy->psnr_db);
  const double gone = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  // What searches for equal quality need is not known beforehand.
  const bool known = renders_ <= planned_;
  const std::string place = known ? fmt::format("{}/{}", renders_, planned_) : std::to_string(renders_);
  const std::string left = known ? fmt::format(", about {} left", clock_text(seconds_left())) : "";
  log("{}  {}: {}: {}  ({} gone{})\n", place, task.variant.id, name, what, clock_text(gone), left);
}

/// One more repeat; the first one that is measured writes the image.
void Runner::render(const Task& task, Cell& cell) {
  const bool is_reference = cell.setting == reference_of();
  WorkOrder order{task.variant, cell.setting, options_.method, "", !is_reference};
  if (cell.seconds.empty()) order.image = path("images", task, cell.setting, ".exr");
  const auto before = std::chrono::steady_clock::now();
  const Result<WorkDone> done = run_in_child(order, options_.limit_seconds * (is_reference ? 10.0 : 1.0));
  rendered_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  ++renders_;
  int& left = left_[{task.variant.id, setting_id(cell.setting)}];
  if (!done) {
    cell.error = done.error().message();
    left = 0;
    return;
  }
  left = std::max(0, left - 1);
  cell.seconds.push_back(done->seconds);
  cell.fragments = done->fragments;
  cell.events = done->events;
  cell.rays = done->rays;
  cell.peak_memory_bytes = std::max(cell.peak_memory_bytes, done->peak_memory_bytes);
  cell.device = done->device;
  cell.reference_rmse = done->error_rmse;
  cell.reference_psnr_db = done->error_psnr_db;
}

/// Judges the image of the cell's first render, and makes the pictures of it.
Status Runner::measure(const Task& task, Cell& cell) {
  const std::string exr = path("images", task, cell.setting, ".exr");
  const Result<Image> image = read_exr(exr);
  if (!image) return image.error();
  const bool is_reference = cell.setting == reference_of();
  if (!is_reference) {
    if (reference_id_ != task.variant.id) {
      Result<Image> reference = read_exr(path("images", task, reference_of(), ".exr"));
      if (!reference) return reference.error();
      reference_image_ = std::move(*reference);
      reference_id_ = task.variant.id;
    }
    const Result<Accuracy> accuracy = accuracy_of(*image, reference_image_);
    if (!accuracy) {
      cell.error = accuracy.error().message();
      return Done{};
    }
    cell.accuracy = *accuracy;
  }
  if (!task.pictures) {
    std::error_code code;
    if (!is_reference) std::filesystem::remove(exr, code);
    return Done{};
  }
  if (const Status written = write_png(options_.folder + '/' + picture(task, cell.setting), *image); !written)
    return written;
  if (is_reference) return Done{};
  return write_png(options_.folder + '/' + difference(task, cell.setting),
                   difference_map(*image, reference_image_));
}

Status Runner::finish(const Task& task, Cell& cell) {
  if (cell.error.empty() && cell.seconds.size() == 1)
    if (const Status measured = measure(task, cell); !measured) return measured;
  report(task, cell);
  if (!cell.error.empty()) return Done{};
  return save_cell(path("data", task, cell.setting, ".json"), cell);
}

Status Runner::run(const Task& task, int repeats) {
  for (const char* kind : {"data", "images"}) {
    const std::string folder = fmt::format("{}/{}/{}", options_.folder, kind, task.variant.id);
    std::error_code code;
    std::filesystem::create_directories(folder, code);
    if (code) return Error{folder, "", code.message()};
  }
  Cell& reference = load(task, reference_of());
  if (!reference.done(1)) {
    render(task, reference);
    if (const Status finished = finish(task, reference); !finished) return finished;
  }
  std::vector<Setting> order = task.settings;
  for (int round = 0; round < repeats; ++round) {
    for (const Setting& setting : order) {
      Cell& cell = load(task, setting);
      if (!reference.error.empty()) cell.error = "there is no reference: " + reference.error;
      if (!cell.error.empty() || cell.done(static_cast<std::size_t>(round) + 1)) continue;
      render(task, cell);
      if (const Status finished = finish(task, cell); !finished) return finished;
    }
    std::reverse(order.begin(), order.end());
  }
  return Done{};
}

}  // namespace swept
