// A command line run to its end.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"

namespace swept::test {

struct Outcome {
  int exit_code = -1;  ///< −1: ended by a signal
  std::string out, err;
};

/// By the shell, with nothing on its stdin.
inline Outcome run_command(const std::string& line) {
  const TemporaryFolder streams;
  const int status =
      std::system((line + " >'" + (streams / "out") + "' 2>'" + (streams / "err") + "' </dev/null").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content_of(streams / "out"),
          content_of(streams / "err")};
}

/// A program and its arguments, none of which may hold a quote.
inline Outcome run_command(const std::string& program, const std::vector<std::string>& arguments) {
  std::string line = program;
  for (const std::string& argument : arguments) line += " '" + argument + "'";
  return run_command(line);
}

}  // namespace swept::test
