// What the files of one object were last read as, for an owner that reads them again frame by frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "splat/result.h"

namespace swept::io {

/// By path, for as long as a file's size and time of change are what they were. Of what a round of reading
/// did not ask for the next one knows nothing, so that pictures of a sequence are not all held.
template <class Content>
class KeptFiles {
 public:
  /// Before the files of a frame are asked for.
  void begin_round() {
    last_ = std::move(now_);
    now_.clear();
  }

  /// What was read of `path`, or else read(path) returns; errors are not kept.
  template <class Read>
  [[nodiscard]] Result<std::shared_ptr<const Content>> get(const std::string& path, const Read& read) {
    if (const auto known = now_.find(path); known != now_.end()) return known->second.content;
    // Before it is read: what changes meanwhile is read again.
    std::error_code no_size, no_time;
    Kept kept;
    kept.size = std::filesystem::file_size(path, no_size);
    kept.changed = std::filesystem::last_write_time(path, no_time);
    if (const auto before = last_.find(path); before != last_.end() && !no_size && !no_time &&
                                              before->second.size == kept.size &&
                                              before->second.changed == kept.changed) {
      kept.content = before->second.content;
    } else {
      last_.erase(path);  // so that two never share the memory
      Result<Content> content = read(path);
      if (!content) return content.error();
      kept.content = std::make_shared<const Content>(*std::move(content));
    }
    return now_.emplace(path, std::move(kept)).first->second.content;
  }

 private:
  struct Kept {
    std::uintmax_t size = 0;
    std::filesystem::file_time_type changed;
    std::shared_ptr<const Content> content;
  };
  std::map<std::string, Kept> now_, last_;
};

}  // namespace swept::io
