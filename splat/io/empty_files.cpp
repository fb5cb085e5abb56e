#include "splat/io/empty_files.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace swept::io {
namespace {

constexpr double forever = std::numeric_limits<double>::infinity();

/// Files next to each other, and when their points exist.
struct Part {
  CloudSource source;
  Lifetime life{-forever, forever};

  [[nodiscard]] bool seen(double first, double last) const {
    return !source.files.empty() && (life.born <= first ? first < life.gone : life.born < last);
  }
};

/// The files before or after the empty one.
Part part_of(const CloudSource& source, std::size_t begin, std::size_t end, double empty_frame) {
  Part part{source, {-forever, forever}};
  part.source.files.assign(source.files.begin() + static_cast<std::ptrdiff_t>(begin),
                           source.files.begin() + static_cast<std::ptrdiff_t>(end));
  if (part.source.files.empty()) return part;
  const double nearest = begin == 0 ? part.source.files.back().frame : part.source.files.front().frame;
  (begin == 0 ? part.life.gone : part.life.born) = 0.5 * nearest + 0.5 * empty_frame;
  return part;
}

void confine(const Lifetime& life, double first, double last, SurfelCloud& cloud) {
  if (!(life.born > first) && !(life.gone <= last)) return;
  if (cloud.lifetime.empty()) cloud.lifetime.assign(cloud.size(), {-forever, forever});
  for (Lifetime& own : cloud.lifetime) own = {std::max(own.born, life.born), std::min(own.gone, life.gone)};
}

}  // namespace

std::string empty_note(const std::string& path) { return path + " has no points"; }

Result<LoadedCloud> read_beside_empty(const CloudSource& source, double first, double last,
                                      const ReadSource& read) {
  Result<LoadedCloud> all = read(source, first, last);
  if (all || all.error().kind != ErrorKind::empty) return all;
  const auto empty = std::find_if(source.files.begin(), source.files.end(),
                                  [&](const KeyFile& file) { return file.path == all.error().file; });
  if (empty == source.files.end()) return all;
  const auto at = static_cast<std::size_t>(empty - source.files.begin());
  const std::string note = empty_note(empty->path);
  Part before = part_of(source, 0, at, empty->frame),
       after = part_of(source, at + 1, source.files.size(), empty->frame);
  const double middle = first + 0.5 * (last - first);
  const bool earlier = before.seen(first, last) && (middle < before.life.gone || !after.seen(first, last));
  if (!earlier && !after.seen(first, last)) {
    LoadedCloud none;
    none.report.assumed.push_back(note + ": there is nothing to draw of it");
    return none;
  }
  const Part& part = earlier ? before : after;
  Result<LoadedCloud> loaded = read_beside_empty(part.source, first, last, read);
  if (!loaded || loaded->cloud.size() == 0) return loaded;
  confine(part.life, first, last, loaded->cloud);
  const bool both = before.seen(first, last) && after.seen(first, last);
  loaded->report.assumed.push_back(
      note + ": those of the files " + (earlier ? "before it exist until" : "after it exist from") +
      " halfway to it" + (both ? ", and the others, which the exposure would show too, are left out" : ""));
  return loaded;
}

}  // namespace swept::io
