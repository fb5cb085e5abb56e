#include "tools/study/traversal.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/core.h>

#include "tools/cpu_seconds.h"

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

/// Sample test efficiency in percent, and time relative to 4 × 4 px tiles, as printed: TILE of 4, 2, 1 px,
/// then INTERVAL of 4, 16, 64; and the efficiency of 1 px tiles by hulls in place of slefes.
struct Printed {
  double efficiency[6], time[6], hulls;
};
const std::map<std::string, Printed>& printed() {
  static const std::map<std::string, Printed> of = {
      {"Cloth ball", {{11, 18, 24, 1.2, 6.4, 15}, {1, 1.38, 3.5, 4.3, 0.93, 0.61}, 2.4}},
      {"Sponza", {{47, 65, 79, 10, 18, 21}, {1, 1.0, 1.7, 2.8, 1.8, 2.0}, 71}},
      {"BigGuy", {{17, 27, 36, 3.1, 11, 18}, {1, 1.2, 2.4, 2.9, 1.1, 0.77}, 3.6}},
      {"Ben", {{12, 21, 34, 0.68, 5.2, 14}, {1, 1.6, 4.3, 7.1, 1.1, 0.52}, 7.4}},
      {"Hairball", {{3.5, 7.5, 14, 0.75, 2.8, 4.8}, {1, 1.0, 2.0, 2.8, 0.87, 0.65}, 5.5}}};
  return of;
}

/// The settings that the paper has, in its order.
constexpr const char* paper_ids[] = {"tile-4",     "tile-2",      "tile-1",
                                     "interval-4", "interval-16", "interval-64"};

std::size_t index_of(const std::string& id) {
  const std::vector<TraversalSetting> settings = traversal_settings(1);
  return static_cast<std::size_t>(
      std::find_if(settings.begin(), settings.end(), [&](const auto& s) { return s.id == id; }) -
      settings.begin());
}

const TraversalCell& cell(const TraversalRow& row, const std::string& id) { return row.cells[index_of(id)]; }

template <class Holds>
std::size_t count_of(const std::vector<TraversalRow>& rows, const Holds& holds) {
  return static_cast<std::size_t>(std::count_if(
      rows.begin(), rows.end(), [&](const TraversalRow& row) { return row.error.empty() && holds(row); }));
}

}  // namespace

std::vector<TraversalSetting> traversal_settings(int samples) {
  std::vector<TraversalSetting> settings;
  for (const int px : {4, 2, 1})
    settings.push_back({fmt::format("tile-{}", px),
                        fmt::format("TILE {}×{}", px, px),
                        {.samples = samples, .traversal = Traversal::tile, .tile_px = px}});
  settings.push_back(
      {"tile-1-hulls",
       "TILE 1×1, hulls",
       {.samples = samples, .traversal = Traversal::tile, .tile_px = 1, .bounds = CurveBounds::hulls}});
  for (const int parts : {4, 16, 64})
    settings.push_back({fmt::format("interval-{}", parts),
                        fmt::format("INTERVAL {}", parts),
                        {.samples = samples, .traversal = Traversal::interval, .intervals = parts}});
  if (hierarchy_available())
    settings.push_back(
        {"hierarchy", "Hierarchy 4×4", {.samples = samples, .traversal = Traversal::hierarchy}});
  settings.push_back({"interleave",
                      "INTERLEAVE 256",
                      {.samples = samples, .times = 256, .traversal = Traversal::interleave}});
  return settings;
}

TraversalRow measure_traversals(const TraversalScene& scene, int samples, int repeats) {
  TraversalRow row;
  row.title = scene.title;
  row.paper = scene.paper;
  row.error = scene.error;
  row.samples = samples;
  if (!row.error.empty()) return row;
  const std::vector<TraversalSetting> settings = traversal_settings(samples);
  row.cells.resize(settings.size());
  RenderControl control;
  control.threads = 1;
  Image first;
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (std::size_t i = 0; i < settings.size(); ++i) {
      const double before = cpu_seconds();
      Result<Rendered> rendered = render_stochastic(scene.scene, settings[i].options, control);
      const double seconds = cpu_seconds() - before;
      if (!rendered) {
        row.error = rendered.error().message();
        return row;
      }
      const Statistics& counts = rendered->statistics;
      row.cells[i] = {counts.counter("sample_test_efficiency").value_or(0.0),
                      repeat == 0 ? seconds : std::min(seconds, row.cells[i].cpu_seconds),
                      counts.counter("samples_tested").value_or(0.0)};
      row.primitives = static_cast<std::size_t>(counts.counter("primitives").value_or(0.0));
      if (i == 0 && repeat == 0) first = std::move(rendered->image);
      // Samples that share their times are others.
      else if (settings[i].options.times == 0 && rendered->image.rgba != first.rgba) {
        row.error = fmt::format("{} is another image than {}", settings[i].label, settings[0].label);
        return row;
      }
    }
  row.width = first.width;
  row.height = first.height;
  return row;
}

std::vector<std::string> traversal_findings(const std::vector<TraversalRow>& rows) {
  const std::size_t all = count_of(rows, [](const TraversalRow&) { return true; });
  const auto efficiency = [](const TraversalRow& row, const char* id) { return cell(row, id).efficiency; };
  const auto seconds = [](const TraversalRow& row, const char* id) { return cell(row, id).cpu_seconds; };
  const std::size_t best_tile = count_of(rows, [&](const TraversalRow& row) {
    return std::all_of(std::begin(paper_ids), std::end(paper_ids),
                       [&](const char* id) { return efficiency(row, id) <= efficiency(row, "tile-1"); });
  });
  const std::size_t rising = count_of(rows, [&](const TraversalRow& row) {
    return efficiency(row, "tile-4") <= efficiency(row, "tile-2") &&
           efficiency(row, "tile-2") <= efficiency(row, "tile-1") &&
           efficiency(row, "interval-4") <= efficiency(row, "interval-16") &&
           efficiency(row, "interval-16") <= efficiency(row, "interval-64");
  });
  double gain = 0.0;
  for (const TraversalRow& row : rows)
    if (row.error.empty() && efficiency(row, "tile-1-hulls") > 0.0)
      gain = std::max(gain, efficiency(row, "tile-1") / efficiency(row, "tile-1-hulls"));
  const auto best = [&](const TraversalRow& row, const char* kind) {
    double least = HUGE_VAL;
    for (const char* id : paper_ids)
      if (std::string(id).starts_with(kind)) least = std::min(least, seconds(row, id));
    return least;
  };
  std::string faster_tile, faster_interval;
  for (const TraversalRow& row : rows) {
    if (!row.error.empty()) continue;
    std::string& list = best(row, "tile") < best(row, "interval") ? faster_tile : faster_interval;
    (list += list.empty() ? "" : ", ") += row.title;
  }
  const std::size_t slowest = count_of(rows, [&](const TraversalRow& row) {
    return seconds(row, "tile-1") > seconds(row, "tile-2") && seconds(row, "tile-2") > seconds(row, "tile-4");
  });
  return {fmt::format("Tiles of 1×1 px have the highest sample test efficiency of the paper's traversals on "
                      "{} of {} scenes, "
                      "efficiency rises with smaller tiles and more intervals on {}, and slefes raise that "
                      "of 1×1 tiles by "
                      "up to {:.2g} times over hulls; the paper found the first two on all of its scenes, "
                      "and up to 10 times.",
                      best_tile, all, rising, gain),
          fmt::format("By time the best tiles are faster on {} and the best intervals on {}, where the paper "
                      "has intervals "
                      "ahead for small triangles and tiles for large ones, and smaller tiles take longer on "
                      "{} of {} scenes, "
                      "as on all of the paper's.",
                      faster_tile.empty() ? "no scene" : faster_tile,
                      faster_interval.empty() ? "no scene" : faster_interval, slowest, all)};
}

Json to_json(const std::vector<TraversalRow>& rows) {
  Json json = {{"settings", Json::array()}, {"rows", Json::array()}, {"findings", Json::array()}};
  for (const TraversalSetting& setting : traversal_settings(1))
    json["settings"].push_back({{"id", setting.id}, {"label", setting.label}});
  bool any = false;
  for (const TraversalRow& row : rows) {
    Json entry = {{"scene", row.title},
                  {"paper_scene", row.paper.empty() ? Json(nullptr) : Json(row.paper)},
                  {"error", row.error.empty() ? Json(nullptr) : Json(row.error)},
                  {"primitives", row.primitives},
                  {"width", row.width},
                  {"height", row.height},
                  {"samples", row.samples},
                  {"cells", Json::object()}};
    if (row.error.empty()) {
      any = true;
      const std::vector<TraversalSetting> settings = traversal_settings(1);
      for (std::size_t i = 0; i < settings.size(); ++i)
        entry["cells"][settings[i].id] = {
            {"efficiency", row.cells[i].efficiency},
            {"cpu_seconds", row.cells[i].cpu_seconds},
            {"relative_time", row.cells[i].cpu_seconds / row.cells[0].cpu_seconds},
            {"samples_tested", row.cells[i].tested}};
    }
    if (const auto found = printed().find(row.paper); found != printed().end())
      for (std::size_t i = 0; i < std::size(paper_ids); ++i)
        entry["paper"][paper_ids[i]] = {{"efficiency", found->second.efficiency[i] / 100.0},
                                        {"relative_time", found->second.time[i]}};
    json["rows"].push_back(std::move(entry));
  }
  if (any) json["findings"] = traversal_findings(rows);
  return json;
}

}  // namespace swept
