// How far the library's formulas are from exact results, in every hard case of model section 10, beside the
// formulas one first writes. Markdown on standard output; the same as JSON in a file. Exit codes: 0 all
// within their bounds, 1 not, or a file could not be written, 2 bad arguments.
#include <cstdint>
#include <exception>
#include <string>
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
    std::pair<const char*, void (*)(std::size_t, std::uint64_t, std::vector<swept::stability::Row>&)>;
constexpr Part parts[] = {
    {"integral", swept::stability::add_integral_rows}, {"coordinates", swept::stability::add_coordinate_rows},
    {"tube", swept::stability::add_tube_rows},         {"fragment", swept::stability::add_fragment_rows},
    {"crossing", swept::stability::add_crossing_rows}, {"filter", swept::stability::add_filter_rows}};

int run(const std::string& part, std::size_t points, std::uint64_t seed, const std::string& json_path) {
  using namespace swept::stability;
  std::vector<Row> rows;
  for (const auto& [name, add_rows] : parts)
    if (part.empty() || part == name) add_rows(points, seed, rows);
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
  std::size_t points = 2000;
  std::uint64_t seed = 1;
  std::string part, json_path;
  app.add_option("--part", part, "only this part of the table")
      ->check(CLI::IsMember({"integral", "coordinates", "tube", "fragment", "crossing", "filter"}));
  app.add_option("--points", points,
                 "points per row; 1000000 takes three minutes for the integral, half an hour for all")
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
