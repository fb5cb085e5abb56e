#include "tools/frame_memory.h"

#include <charconv>
#include <fstream>
#include <string_view>

#include <fmt/core.h>

namespace swept {
namespace {

/// The number that a file of a control group has; none: there is no such file, or it says "max".
std::optional<std::uint64_t> number_in(const char* path) {
  std::ifstream file(path);
  std::string word;
  if (!(file >> word)) return std::nullopt;
  std::uint64_t value = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (code != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// What could be had without swapping out others, and free swap.
std::optional<std::uint64_t> available() {
  std::ifstream file("/proc/meminfo");
  std::uint64_t bytes = 0;
  bool known = false;
  for (std::string line; std::getline(file, line);) {
    for (const std::string_view key : {"MemAvailable:", "SwapFree:"}) {
      if (!line.starts_with(key)) continue;
      std::size_t at = line.find_first_of("0123456789");
      std::uint64_t kibibytes = 0;
      if (at == std::string::npos) continue;
      std::from_chars(line.data() + at, line.data() + line.size(), kibibytes);
      bytes += 1024 * kibibytes;
      known = known || key.starts_with("Mem");
    }
  }
  return known ? std::optional(bytes) : std::nullopt;
}

std::string size_text(std::uint64_t bytes) {
  const double mebibytes = static_cast<double>(bytes) / (1 << 20);
  return mebibytes < 1024.0 ? fmt::format("{:.0f} MiB", mebibytes)
                            : fmt::format("{:.1f} GiB", mebibytes / 1024.0);
}

}  // namespace

std::optional<MemoryLeft> memory_left(std::uint64_t most) {
  std::optional<MemoryLeft> left;
  const auto bound = [&](const std::optional<std::uint64_t>& bytes, const char* whose) {
    if (bytes && (!left || *bytes < left->bytes)) left = MemoryLeft{*bytes, whose};
  };
  bound(available(), "the machine has");
  bound(number_in("/sys/fs/cgroup/memory.max"), "the control group allows");
  bound(number_in("/sys/fs/cgroup/memory/memory.limit_in_bytes"), "the control group allows");
  if (most > 0) bound(most, "--max-memory allows");
  return left;
}

std::uint64_t least_frame_bytes(const Film& film, const LayerOptions& layers) {
  const std::uint64_t channels = 5 + (layers.choice.normal ? 3 : 0) + (layers.choice.motion ? 4 : 0) +
                                 (layers.choice.coverage ? 1 : 0) + (layers.samples ? 1 : 0) +
                                 (layers.error ? 1 : 0);
  return channels * sizeof(float) * static_cast<std::uint64_t>(film.window_width()) *
         static_cast<std::uint64_t>(film.window_height());
}

Status check_frame_memory(const Film& film, const LayerOptions& layers,
                          const std::optional<MemoryLeft>& left) {
  const std::uint64_t bytes = least_frame_bytes(film, layers);
  if (!left || bytes <= left->bytes) return Done{};
  return Error{
      "", "/film",
      fmt::format("a frame of {} x {} px takes {} at least, and {} {}; --part I/N renders it in strips",
                  film.window_width(), film.window_height(), size_text(bytes), left->whose,
                  size_text(left->bytes)),
      ErrorKind::out_of_memory};
}

}  // namespace swept
