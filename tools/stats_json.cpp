#include "tools/stats_json.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

/// Counts as whole numbers.
Json number_of(double value) {
  constexpr double exact = 9007199254740992.0;
  if (std::abs(value) <= exact && value == std::floor(value)) return static_cast<long long>(value);
  return value;
}

Json object_of(const std::vector<std::pair<std::string, double>>& pairs) {
  Json object = Json::object();
  for (const auto& [name, value] : pairs) object[name] = number_of(value);
  return object;
}

Json to_json(const FrameStatistics& frame) {
  Json json = {{"frame", number_of(frame.frame)}, {"output", frame.output}, {"scene_hash", frame.scene_hash}};
  if (frame.skipped) {
    json["skipped"] = true;
    return json;
  }
  json["seconds"] = {
      {"load", frame.load_seconds}, {"render", frame.render_seconds}, {"write", frame.write_seconds}};
  json["counters"] = object_of(frame.statistics.counters);
  json["stages"] = object_of(frame.statistics.seconds);
  json["effects"] = frame.statistics.effects;
  json["plan"] = Json::array();
  for (const ObjectPlan& plan : frame.plan) json["plan"].push_back(plan.json());
  json["notes"] = frame.notes;
  return json;
}

}  // namespace

std::string to_json(const RunStatistics& run) {
  Json json = {{"software", run.software},
               {"scene", run.scene},
               {"method", run.method},
               {"film", {{"width", run.width}, {"height", run.height}}},
               {"options", object_of(run.options)},
               {"peak_memory_bytes", number_of(run.peak_memory_bytes)}};
  json["frames"] = Json::array();
  for (const FrameStatistics& frame : run.frames) json["frames"].push_back(to_json(frame));
  // A path need not be UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace swept
