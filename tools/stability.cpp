// How far the library's formulas are from exact results, in every hard case of model section 10, beside the
// formulas one first writes. Markdown on standard output; the same as JSON in a file. Exit codes: 0 all
// within their bounds, 1 not, or a file could not be written, 2 bad arguments.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <iterator>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "splat/io/atomic_file.h"
#include "tools/stability_rows.h"

namespace {

using Part =
    std::pair<const char*, void (*)(std::size_t, std::uint64_t, std::vector<swept::stability::Job>&)>;
constexpr Part parts[] = {
    {"integral", swept::stability::add_integral_jobs}, {"coordinates", swept::stability::add_coordinate_jobs},
    {"tube", swept::stability::add_tube_jobs},         {"fragment", swept::stability::add_fragment_jobs},
    {"crossing", swept::stability::add_crossing_jobs}, {"filter", swept::stability::add_filter_jobs},
    {"edges", swept::stability::add_edge_jobs}};

/// Their rows in order, made by as many threads as there are cores.
std::vector<swept::stability::Row> rows_of(const std::vector<swept::stability::Job>& jobs) {
  std::vector<std::vector<swept::stability::Row>> done(jobs.size());
  std::atomic<std::size_t> next{0};
  {
    std::vector<std::jthread> threads;
    for (unsigned t = std::max(1u, std::thread::hardware_concurrency()); t-- > 0;)
      threads.emplace_back([&] {
        for (std::size_t i; (i = next++) < jobs.size();) done[i] = jobs[i]();
      });
  }
  std::vector<swept::stability::Row> rows;
  for (std::vector<swept::stability::Row>& some : done)
    rows.insert(rows.end(), std::make_move_iterator(some.begin()), std::make_move_iterator(some.end()));
  return rows;
}

int run(const std::string& part, std::size_t points, std::uint64_t seed, const std::string& json_path) {
  using namespace swept::stability;
  std::vector<Job> jobs;
  for (const auto& [name, add_jobs] : parts)
    if (part.empty() || part == name) add_jobs(points, seed, jobs);
  const std::vector<Row> rows = rows_of(jobs);
  fmt::print("{}", to_markdown(rows));
  int exit_code = 0;
  for (const Row& row : rows) {
    if (row.ours.not_finite == 0 && !(row.has_bound && row.ours.worst_share > 1.0)) continue;
    fmt::print(stderr, "swept_stability: {}, {}, {}: beyond the stated bound, or not finite\n", row.formula,
               row.hard_case, row.number);
    exit_code = 1;
  }
  if (json_path.empty()) return exit_code;
  const swept::Status written = swept::write_file(json_path, to_json(rows, points, seed));
  if (written) return exit_code;
  fmt::print(stderr, "swept_stability: {}: {}\n", written.error().file, written.error().reason);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Errors of Swept's formulas against 50-digit results, as Markdown", "swept_stability");
  std::size_t points = 1000000;
  std::uint64_t seed = 1;
  std::string part, json_path;
  app.add_option("--part", part, "only this part of the table")
      ->check(CLI::IsMember({"integral", "coordinates", "tube", "fragment", "crossing", "filter", "edges"}));
  app.add_option("--points", points, "points per row")
      ->check(CLI::Range(std::size_t{1}, std::size_t{100000000}))
      ->capture_default_str();
  app.add_option("--seed", seed, "of the points")->capture_default_str();
  app.add_option("--json", json_path, "write the table to this file, too");
  try {
    app.parse(argc, argv);
    return run(part, points, seed, json_path);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "swept_stability: {}\n", error.what());
    return 1;
  }
}
