// The swept command. Exit codes: 0 done, 1 a render failed, 2 bad arguments.
#include <exception>
#include <new>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "tools/compare_command.h"
#include "tools/info_command.h"
#include "tools/render_command.h"
#include "tools/study/study_command.h"
#include "tools/study/worker.h"

int main(int argc, char** argv) {
  CLI::App app("Exact motion blur for point clouds", "swept");
  app.set_version_flag("--version", "swept " SWEPT_VERSION);
  app.require_subcommand(1);
  int exit_code = 0;
  try {
    swept::add_render_command(app, exit_code);
    swept::add_info_command(app, exit_code);
    swept::add_compare_command(app, exit_code);
    swept::add_study_command(app, exit_code);
    swept::add_study_worker_command(app, exit_code);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // Help and version are "errors" with code 0.
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "swept: not enough memory\n");
    return 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "swept: {}\n", error.what());
    return 1;
  }
  return exit_code;
}
