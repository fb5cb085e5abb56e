#include "splat/io/source_files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "splat/io/sequence.h"

namespace swept::io {
namespace {

constexpr double max_files_per_shutter = 10'000.0;

Result<std::vector<KeyFile>> sequence_files(const SequenceSource& sequence, double first, double last) {
  double low = std::floor(first), high = std::ceil(last);
  if (!sequence.cycle) {
    low = std::clamp<double>(low, sequence.first, sequence.last);
    high = std::clamp<double>(high, sequence.first, sequence.last);
  }
  if (high - low >= max_files_per_shutter)
    return Error{"", "sequence", "the shutter is open over more than 10000 files"};
  const double period = 1.0 + sequence.last - sequence.first;
  std::vector<KeyFile> files;
  for (double frame = low; frame <= high; frame += 1.0) {
    const double phase = std::fmod(frame - sequence.first, period);
    const int number = sequence.first + static_cast<int>(phase < 0.0 ? phase + period : phase);
    Result<std::string> path = sequence_path(sequence.pattern, number);
    if (!path) return Error{"", "sequence", path.error().reason};
    files.push_back({frame, std::move(*path)});
  }
  return files;
}

Status require_files(const std::vector<KeyFile>& files, const std::string& member) {
  std::error_code code;
  for (const KeyFile& key : files)
    if (!std::filesystem::exists(key.path, code)) return Error{"", member, "there is no file " + key.path};
  return Done{};
}

}  // namespace

Result<std::vector<KeyFile>> source_files(const ObjectSource& source, double first, double last) {
  std::vector<KeyFile> files;
  std::string member = "file";
  if (const auto* file = std::get_if<FileSource>(&source.points)) {
    files.push_back({file->frame, file->path});
    if (!file->end_path.empty()) {
      files.push_back({file->end_frame, file->end_path});
      member = "";
    }
  } else if (const auto* sequence = std::get_if<SequenceSource>(&source.points)) {
    Result<std::vector<KeyFile>> around = sequence_files(*sequence, first, last);
    if (!around) return around;
    files = std::move(*around);
    member = "sequence";
  }
  if (const Status status = require_files(files, member); !status) return status.error();
  return files;
}

}  // namespace swept::io
