#include "tools/study/document.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/core.h>

#include "tools/study/difference_map.h"
#include "tools/study/machine.h"
#include "tools/study/raycast.h"

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

Json number(const std::optional<double>& value) {
  return value && *value < HUGE_VAL ? Json(*value) : Json(nullptr);
}

/// Nothing is both faster and nearer the reference.
bool on_pareto_front(const Cell& cell, const std::vector<const Cell*>& cells) {
  if (!cell.accuracy || cell.seconds.empty()) return false;
  const double seconds = spread_of(cell.seconds).median;
  return std::none_of(cells.begin(), cells.end(), [&](const Cell* other) {
    if (!other->accuracy || other->seconds.empty()) return false;
    const double other_seconds = spread_of(other->seconds).median;
    return other_seconds <= seconds && other->accuracy->rmse <= cell.accuracy->rmse &&
           (other_seconds < seconds || other->accuracy->rmse < cell.accuracy->rmse);
  });
}

Json reference_json(const Runner& runner, const Task& task) {
  const Cell& reference = runner.reference(task);
  Json json = {{"samples", reference.setting.value},
               {"seconds", reference.seconds.empty() ? Json(nullptr) : Json(reference.seconds.front())},
               {"rmse", number(reference.reference_rmse)},
               {"psnr_db", number(reference.reference_psnr_db)},
               {"error", reference.error.empty() ? Json(nullptr) : Json(reference.error)}};
  if (task.pictures && reference.error.empty()) json["image"] = Runner::picture(task, reference.setting);
  return json;
}

Json task_json(const Runner& runner, const Task& task) {
  const VariantFacts& facts = task.facts;
  Json json = {{"id", task.variant.id},
               {"title", task.variant.title},
               {"scene", task.variant.title},
               {"file", task.variant.file},
               {"points", facts.points},
               {"width", facts.width},
               {"height", facts.height},
               {"exposure_scale", task.variant.exposure_scale},
               {"motion_px", {{"median", facts.motion_median_px}, {"largest", facts.motion_largest_px}}},
               {"reference", reference_json(runner, task)},
               {"cells", Json::array()}};
  std::vector<const Cell*> cells;
  for (const Setting& setting : task.settings) cells.push_back(&runner.cell(task, setting));
  for (const Cell* cell : cells) {
    Json entry = to_json(*cell);
    entry["pareto"] = on_pareto_front(*cell, cells);
    if (task.pictures && cell->error.empty()) {
      entry["image"] = Runner::picture(task, cell->setting);
      entry["difference"] = Runner::difference(task, cell->setting);
    }
    json["cells"].push_back(std::move(entry));
  }
  return json;
}

/// With one motion for the whole scene, as a plot needs it.
Json sweep_json(const Runner& runner, const std::vector<Task>& tasks) {
  Json list = Json::array();
  for (const Task& task : tasks) {
    Json json = task_json(runner, task);
    json["motion_px"] = task.facts.motion_median_px;
    list.push_back(std::move(json));
  }
  return list;
}

Json machine_json(const Runner& runner, const StudyPlan& done) {
  const Machine machine = this_machine();
  Json gpu = nullptr;
  for (const std::vector<Task>* tasks : {&done.scenes, &done.motion, &done.points})
    for (const Task& task : *tasks)
      for (const Setting& setting : task.settings)
        if (const Cell& cell = runner.cell(task, setting); !cell.device.empty()) gpu = cell.device;
  return {{"cpu", machine.cpu}, {"threads", machine.threads},   {"memory_bytes", machine.memory_bytes},
          {"os", machine.os},   {"compiler", machine.compiler}, {"gpu", gpu}};
}

Json difference_scale_json() {
  Json colors = Json::array();
  for (const auto& [red, green, blue] : difference_colors())
    colors.push_back(fmt::format("#{:02x}{:02x}{:02x}", red, green, blue));
  return {{"low", kDifferenceLow},
          {"high", kDifferenceHigh},
          {"log", true},
          {"unit", "largest channel difference, linear"},
          {"colors", colors}};
}

std::string csv_field(const Json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  std::string text = value.get<std::string>();
  if (text.find_first_of("\",\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

Json study_document(const StudyHeader& header, const Runner& runner, const StudyPlan& done,
                    const std::vector<Table1Row>& table1) {
  Json json = {{"swept_study", 1},
               {"software", "swept " SWEPT_VERSION},
               {"command", header.command},
               {"started", header.started},
               {"seconds", header.seconds},
               {"machine", machine_json(runner, done)},
               {"settings",
                {{"quick", header.quick},
                 {"repeats", header.repeats},
                 {"reference_samples", header.reference_samples}}},
               {"methods", Json::array()},
               {"scenes", Json::array()},
               {"difference_scale", difference_scale_json()},
               {"motion_length", sweep_json(runner, done.motion)},
               {"point_count", sweep_json(runner, done.points)},
               {"table1", Json::array()}};
  for (const StudyMethod& method : study_methods()) {
    json["methods"].push_back({{"id", method.id},
                               {"name", method.name},
                               {"description", method.description},
                               {"unit", method.unit_plural}});
    if (std::string_view(method.id) == "raycast" && !raycast_available())
      json["methods"].back()["missing"] = "this build has no Embree (tools/setup study)";
  }
  for (const Task& task : done.scenes) json["scenes"].push_back(task_json(runner, task));
  for (const Table1Row& row : table1) json["table1"].push_back(to_json(row));
  return json;
}

std::string study_csv(const Json& document) {
  constexpr const char* cell_columns[] = {"method",  "value", "status", "error",   "rmse",
                                          "psnr_db", "ssim",  "flip",   "max_abs", "share_over_1_255"};
  constexpr const char* time_columns[] = {"median", "least", "most"};
  constexpr const char* last_columns[] = {"fragments", "events", "rays", "peak_memory_bytes", "pareto"};
  std::string text = "part,scene,points,width,height,motion_median_px,reference_samples,reference_rmse";
  for (const char* name : cell_columns) text += fmt::format(",{}", name);
  for (const char* name : time_columns) text += fmt::format(",seconds_{}", name);
  for (const char* name : last_columns) text += fmt::format(",{}", name);
  text += "\r\n";
  for (const char* part : {"scenes", "motion_length", "point_count"})
    for (const Json& scene : document.at(part))
      for (const Json& cell : scene.at("cells")) {
        const Json& motion = scene.at("motion_px");
        text += fmt::format(
            "{},{},{},{},{},{},{},{}", part, csv_field(scene.at("scene")), csv_field(scene.at("points")),
            csv_field(scene.at("width")), csv_field(scene.at("height")),
            csv_field(motion.is_object() ? motion.at("median") : motion),
            csv_field(scene.at("reference").at("samples")), csv_field(scene.at("reference").at("rmse")));
        for (const char* name : cell_columns) text += ',' + csv_field(cell.at(name));
        for (const char* name : time_columns) text += ',' + csv_field(cell.at("seconds").at(name));
        for (const char* name : last_columns) text += ',' + csv_field(cell.at(name));
        text += "\r\n";
      }
  return text;
}

}  // namespace swept
