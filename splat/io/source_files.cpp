#include "splat/io/source_files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "splat/io/sequence.h"

namespace swept::io {
namespace {

constexpr std::size_t max_files_per_shutter = 10'000;

/// The numbers of a sequence's files: evenly from first to last, or those listed.
class Numbers {
 public:
  Numbers(int first, int last, int step)
      : first_(first), step_(step), count_((static_cast<long long>(last) - first) / step + 1) {}
  /// Precondition: increasing, and not empty.
  Numbers(std::vector<int> listed, int step)
      : listed_(std::move(listed)), step_(step), count_(static_cast<long long>(listed_.size())) {}

  [[nodiscard]] long long count() const { return count_; }
  [[nodiscard]] int number(long long i) const {
    return listed_.empty() ? static_cast<int>(first_ + i * step_) : listed_[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] double at(long long i) const { return number(i); }
  /// The last that is at or before `number`; the first if none is.
  [[nodiscard]] long long index_of(double number) const {
    if (listed_.empty()) {
      const double index = std::floor((number - at(0)) / static_cast<double>(step_));
      return static_cast<long long>(std::clamp(index, 0.0, static_cast<double>(count_ - 1)));
    }
    const auto after = std::upper_bound(listed_.begin(), listed_.end(), number,
                                        [](double a, int b) { return a < static_cast<double>(b); });
    return std::max<long long>(0, after - listed_.begin() - 1);
  }
  /// From the first to the first again.
  [[nodiscard]] double period() const { return at(count_ - 1) - at(0) + static_cast<double>(step_); }

 private:
  std::vector<int> listed_;
  long long first_ = 0, step_ = 1, count_ = 0;
};

/// What is on disk of the files that may be missing.
Result<std::vector<int>> look_up(const SequenceSource& sequence) {
  const Result<std::vector<NumberedFile>> files = list_sequence(sequence.pattern);
  if (!files) return Error{"", "sequence", files.error().reason, files.error().kind};
  std::vector<int> numbers;
  for (const NumberedFile& file : *files) {
    const int n = file.number;
    if (sequence.first && (n < *sequence.first || n > *sequence.last ||
                           (static_cast<long long>(n) - *sequence.first) % sequence.step != 0))
      continue;
    if (!sequence.numbers.empty() && !std::binary_search(sequence.numbers.begin(), sequence.numbers.end(), n))
      continue;
    numbers.push_back(n);
  }
  if (numbers.empty()) return Error{"", "sequence", "none of its files is there", ErrorKind::not_found};
  return numbers;
}

/// The smallest step between two of them.
int step_of(const std::vector<int>& numbers) {
  long long step = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    const long long next = static_cast<long long>(numbers[i]) - numbers[i - 1];
    step = step == 0 ? next : std::min(step, next);
  }
  return static_cast<int>(std::clamp<long long>(step, 1, 1'000'000'000));
}

Result<SourceFiles> sequence_files(const SequenceSource& sequence, double first, double last, KeyPath shape) {
  SourceFiles found;
  std::optional<Numbers> numbers;
  if (sequence.gaps || (!sequence.first && sequence.numbers.empty())) {
    Result<std::vector<int>> listed = look_up(sequence);
    if (!listed) return listed.error();
    found.note = "its files are " + frame_ranges_text(*listed);
    const int step = sequence.first ? sequence.step : step_of(*listed);
    numbers.emplace(std::move(*listed), step);
  } else if (sequence.first) {
    numbers.emplace(*sequence.first, *sequence.last, sequence.step);
  } else {
    numbers.emplace(sequence.numbers, step_of(sequence.numbers));
  }

  const double period = numbers->period(), begin = numbers->at(0) + sequence.offset;
  const double end = numbers->at(numbers->count() - 1) + sequence.offset;
  if (!sequence.cycle) {
    if (last < begin || first > end) {
      if (!found.note.empty()) found.note += ", and ";
      found.note += last < begin ? "frames before the first file, " + shortest_text(begin)
                                 : "frames after the last file, " + shortest_text(end);
      found.note += ", show its points, which stand still or move on along their velocities";
    }
    first = std::clamp(first, begin, end);
    last = std::clamp(last, begin, end);
  }
  // Whole periods before the one that `first` lies in, exactly: frames are no larger than 1e9.
  double cycles = sequence.cycle ? std::floor((first - begin) / period) : 0.0;
  long long i = numbers->index_of(first - sequence.offset - cycles * period);
  // A spline depends on the keys beside those that it runs between.
  int beyond = shape == KeyPath::spline ? 1 : 0;
  if (beyond > 0 && (i > 0 || sequence.cycle)) {
    if (--i < 0) {
      i = numbers->count() - 1;
      cycles -= 1.0;
    }
  }
  for (double frame = -HUGE_VAL; frame < last || beyond-- > 0;) {
    if (found.files.size() >= max_files_per_shutter)
      return Error{"", "sequence", "the shutter is open over more than 10000 files"};
    frame = numbers->at(i) + sequence.offset + cycles * period;
    Result<std::string> path = find_in_sequence(sequence.pattern, numbers->number(i));
    if (!path) return Error{"", "sequence", path.error().reason, path.error().kind};
    found.files.push_back({frame, std::move(*path)});
    if (++i < numbers->count()) continue;
    if (!sequence.cycle) break;
    i = 0;
    cycles += 1.0;
  }
  return found;
}

Status require_files(const std::vector<KeyFile>& files, const std::string& member) {
  std::error_code code;
  for (const KeyFile& key : files)
    if (!std::filesystem::exists(key.path, code))
      return Error{"", member, "there is no file " + key.path, ErrorKind::not_found};
  return Done{};
}

}  // namespace

Result<SourceFiles> source_files(const ObjectSource& source, const Scene& scene) {
  const Exposure all = scene.exposure().of_all_rows(scene.film.height);
  const double first = all.open, last = all.close;
  SourceFiles found;
  std::string member = "file";
  if (const auto* file = std::get_if<FileSource>(&source.points)) {
    found.files.push_back({file->frame, file->path});
    if (!file->end_path.empty()) {
      found.files.push_back({file->end_frame, file->end_path});
      member = "";
    }
  } else if (const auto* sequence = std::get_if<SequenceSource>(&source.points)) {
    Result<SourceFiles> around = sequence_files(*sequence, first, last, scene.motion.path);
    if (!around) return around;
    found = std::move(*around);
    member = "sequence";
  }
  if (const Status status = require_files(found.files, member); !status) return status.error();
  return found;
}

}  // namespace swept::io
