#include "tools/console.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>

#include "splat/io/atomic_file.h"

namespace swept {
namespace {

void end_by_signal(int number) {
  remove_temporaries();
  signal(number, SIG_DFL);
  raise(number);
}

}  // namespace

void prepare_console() {
  // Where one of them is closed, the first file that is opened would take its number, and get what is logged.
  // Opened the wrong way round, so that writing to it still fails.
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(descriptor, F_GETFD) < 0 && errno == EBADF)
      if (open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0) break;

  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {
    }, before{};
    action.sa_handler = end_by_signal;
    sigemptyset(&action.sa_mask);
    // What the caller wants ignored, as nohup does, stays ignored.
    if (sigaction(number, nullptr, &before) == 0 && before.sa_handler == SIG_DFL)
      sigaction(number, &action, nullptr);
  }
  // A reader that is gone and a file that grows too large are failed writes, and told as such.
  for (const int number : {SIGPIPE, SIGXFSZ}) signal(number, SIG_IGN);
}

bool finish_console() {
  errno = 0;
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  const int code = errno;
  std::cout.flush();
  if (written && std::cout.good()) return true;
  log("swept: standard output cannot be written{}{}\n", code != 0 ? ": " : "",
      code != 0 ? std::strerror(code) : "");
  return false;
}

}  // namespace swept
