#include "tools/memory_limit.h"

#include <cerrno>
#include <cstring>
#include <string>

#include <sys/resource.h>

namespace swept {

Status limit_memory(std::uint64_t bytes) {
  rlimit limit{};
  if (getrlimit(RLIMIT_DATA, &limit) == 0) {
    limit.rlim_cur = limit.rlim_max < bytes ? limit.rlim_max : static_cast<rlim_t>(bytes);
    if (setrlimit(RLIMIT_DATA, &limit) == 0) return Done{};
  }
  return Error{"", "--max-memory", std::string("the system refuses: ") + std::strerror(errno),
               ErrorKind::device};
}

}  // namespace swept
