#include "tools/study/machine.h"

#include <fstream>
#include <thread>

#include <sys/utsname.h>
#include <unistd.h>

namespace swept {
namespace {

/// What follows `name` and `separator` in a file of such lines, without quotes.
std::string entry_of(const char* path, const std::string& name, char separator) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(name)) continue;
    const std::size_t at = line.find(separator);
    if (at == std::string::npos) continue;
    const std::size_t first = line.find_first_not_of(" \t\"", at + 1), last = line.find_last_not_of(" \t\"");
    if (first != std::string::npos) return line.substr(first, last - first + 1);
  }
  return "unknown";
}

}  // namespace

Machine this_machine() {
  Machine machine;
  machine.cpu = entry_of("/proc/cpuinfo", "model name", ':');
  machine.os = entry_of("/etc/os-release", "PRETTY_NAME", '=');
  utsname name{};
  if (uname(&name) == 0)
    machine.os += std::string(", ") + name.sysname + " " + name.release + " " + name.machine;
#if defined(__clang__)
  machine.compiler = "Clang " __clang_version__;
#elif defined(__GNUC__)
  machine.compiler = "GCC " __VERSION__;
#else
  machine.compiler = "unknown";
#endif
  machine.threads = std::thread::hardware_concurrency();
  machine.memory_bytes =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return machine;
}

}  // namespace swept
