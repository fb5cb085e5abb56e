#include "tools/outputs.h"

#include <cmath>
#include <filesystem>
#include <set>
#include <system_error>

#include <fmt/core.h>

#include "splat/io/atomic_file.h"
#include "splat/io/sequence.h"

namespace swept {
namespace {

namespace fs = std::filesystem;

bool exists(const std::string& path) {
  std::error_code code;
  return fs::exists(path, code);
}

Result<std::string> name_output(const std::string& option, const std::string& pattern, double frame,
                                bool several) {
  if (!several && pattern.find_first_of("%#") == std::string::npos) return pattern;
  if (frame != std::floor(frame) || std::abs(frame) > 1e9)
    return Error{"", option, fmt::format("frame {} has no whole number to put into {}", frame, pattern)};
  const Result<std::string> path = sequence_path(pattern, static_cast<int>(frame));
  if (path) return *path;
  return Error{"", option, fmt::format("{}: {}", pattern, path.error().reason)};
}

/// Finds out by trying, which also covers read-only file systems; once for each folder.
Status check_writable(const std::string& path, std::set<std::string>& writable_folders) {
  std::error_code code;
  if (fs::is_directory(path, code)) return Error{path, "", "is a folder"};
  if (!writable_folders.insert(fs::path(path).parent_path().string()).second) return Done{};
  const Result<AtomicFile> trial = AtomicFile::create(path);
  if (!trial) return trial.error();
  return Done{};
}

}  // namespace

Result<std::vector<FrameOutput>> name_outputs(const std::vector<double>& frames, const std::string& image,
                                              const std::string& preview) {
  const bool several = frames.size() > 1;
  std::vector<FrameOutput> outputs;
  std::set<std::string> names;
  for (const double frame : frames) {
    FrameOutput output{frame, {}, {}, false};
    if (!image.empty()) {
      Result<std::string> path = name_output("--output", image, frame, several);
      if (!path) return path.error();
      output.image = *path;
      if (!names.insert(output.image).second)
        return Error{"", "--output", "two frames would be written to " + output.image};
    }
    if (!preview.empty()) {
      Result<std::string> path = name_output("--preview", preview, frame, several);
      if (!path) return path.error();
      output.preview = *path;
    }
    outputs.push_back(std::move(output));
  }
  return outputs;
}

Status check_output_file(const std::string& path, Existing existing) {
  if (existing == Existing::refuse && exists(path)) return Error{path, "", "exists; --overwrite replaces it"};
  std::set<std::string> folders;
  return check_writable(path, folders);
}

Status check_outputs(std::vector<FrameOutput>& outputs, Existing existing) {
  std::set<std::string> folders;
  for (FrameOutput& output : outputs) {
    if (existing == Existing::skip && exists(output.image) &&
        (output.preview.empty() || exists(output.preview))) {
      output.skip = true;
      continue;
    }
    for (const std::string& path : {output.image, output.preview}) {
      if (path.empty()) continue;
      if (existing == Existing::refuse && exists(path))
        return Error{path, "", "exists; --overwrite replaces it, --skip-existing keeps it"};
      if (Status writable = check_writable(path, folders); !writable) return writable;
    }
  }
  return Done{};
}

}  // namespace swept
