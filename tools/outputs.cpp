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

/// The same for all names and links that lead to one file.
std::string target_of(const std::string& path) {
  std::error_code code;
  const fs::path target = fs::weakly_canonical(path, code);
  return code ? path : target.string();
}

bool has_content(const std::string& path) {
  std::error_code code;
  return exists(path) && fs::file_size(path, code) > 0;
}

/// Whether the file at `path` is the picture that it would be replaced by.
Status check_origin(const std::string& path, const ExrOrigin& expected) {
  const Result<ExrOrigin> found = read_exr_origin(path);
  const auto refuse = [&](const std::string& what) {
    return Error{path, "", "exists, but " + what + "; --overwrite replaces it"};
  };
  if (!found) return refuse("is no whole image: " + found.error().reason);
  if (found->scene_hash.empty()) return refuse("does not say which scene it shows");
  if (found->scene_hash != expected.scene_hash)
    return refuse("shows another frame, or another scene: its hash is " + found->scene_hash +
                  ", and this one's " + expected.scene_hash);
  if (found->method != expected.method)
    return refuse("was rendered by " + found->method + ", and not by " + expected.method);
  return Done{};
}

Result<std::string> name_output(const std::string& option, const std::string& pattern, double frame,
                                bool several) {
  if (!several && !is_sequence_pattern(pattern)) return pattern;
  if (frame != std::floor(frame) || std::abs(frame) > 1e9)
    return Error{"", option, fmt::format("frame {} has no whole number to put into {}", frame, pattern)};
  const Result<std::string> path = sequence_path(pattern, static_cast<int>(frame));
  if (path) return *path;
  return Error{"", option, fmt::format("{}: {}", pattern, path.error().reason), path.error().kind};
}

/// Finds out by trying, which also covers read-only file systems; for new files once for each folder.
Status check_writable(const std::string& path, std::set<std::string>& writable_folders) {
  std::error_code code;
  if (fs::is_directory(path, code)) return Error{path, "", "is a folder"};
  const bool known = !writable_folders.insert(fs::path(path).parent_path().string()).second;
  if (known && !fs::exists(fs::symlink_status(path, code))) return Done{};
  const Result<AtomicFile> trial = AtomicFile::create(path);
  if (!trial) return trial.error();
  return Done{};
}

}  // namespace

Result<std::vector<FrameOutput>> name_outputs(const std::vector<double>& frames, const std::string& image,
                                              const std::string& preview, const std::string& deep) {
  const bool several = frames.size() > 1;
  std::vector<FrameOutput> outputs;
  std::set<std::string> names;
  for (const double frame : frames) {
    FrameOutput output;
    output.frame = frame;
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
    if (!deep.empty()) {
      Result<std::string> path = name_output("--deep", deep, frame, several);
      if (!path) return path.error();
      output.deep = *path;
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

Status check_outputs(std::vector<FrameOutput>& outputs, Existing existing, const OriginOf& origin_of) {
  std::set<std::string> folders, targets;
  for (FrameOutput& output : outputs) {
    if (existing == Existing::skip && has_content(output.image)) {
      const Result<ExrOrigin> expected = origin_of(output);
      if (!expected) return expected.error();
      if (Status same = check_origin(output.image, *expected); !same) return same;
      output.skip = output.preview.empty() || has_content(output.preview);
      if (!output.deep.empty() && has_content(output.deep)) {
        if (Status same = check_origin(output.deep, *expected); !same) return same;
      } else if (!output.deep.empty()) {
        output.skip = false;
      }
      if (output.skip) continue;
    }
    for (const auto& [path, if_exists] : {std::pair{&output.image, &output.image_exists},
                                          {&output.preview, &output.preview_exists},
                                          {&output.deep, &output.deep_exists}}) {
      if (path->empty()) continue;
      if (existing == Existing::refuse && exists(*path))
        return Error{*path, "", "exists; --overwrite replaces it, --skip-existing keeps it"};
      if (existing == Existing::overwrite || exists(*path)) *if_exists = IfExists::replace;
      if (Status writable = check_writable(*path, folders); !writable) return writable;
      if (!targets.insert(target_of(*path)).second)
        return Error{*path, "", "two outputs would be written to one file, " + target_of(*path)};
    }
  }
  return Done{};
}

}  // namespace swept
