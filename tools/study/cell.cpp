#include "tools/study/cell.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include <fmt/core.h>

#include "splat/compare/metrics.h"
#include "splat/io/atomic_file.h"

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

/// What is infinite was written as null.
double number_from(const Json& json, const char* name) {
  const Json& value = json.at(name);
  return value.is_null() ? HUGE_VAL : value.get<double>();
}

std::optional<double> optional_from(const Json& json, const char* name) {
  const Json& value = json.at(name);
  return value.is_null() ? std::nullopt : std::optional(value.get<double>());
}

Cell cell_from(const Json& json) {
  Cell cell;
  cell.setting = {json.at("method"), json.at("value")};
  cell.key = json.at("key");
  if (!json.at("rmse").is_null()) {
    Accuracy& a = cell.accuracy.emplace();
    a.rmse = json.at("rmse");
    a.psnr_db = number_from(json, "psnr_db");
    a.ssim = number_from(json, "ssim");
    a.flip = number_from(json, "flip");
    a.max_abs = json.at("max_abs");
    a.max_abs_x = json.at("max_abs_at")[0];
    a.max_abs_y = json.at("max_abs_at")[1];
    a.share_over_1_255 = json.at("share_over_1_255");
  }
  cell.seconds = json.at("seconds").at("repeats").get<std::vector<double>>();
  cell.fragments = optional_from(json, "fragments");
  cell.events = optional_from(json, "events");
  cell.rays = optional_from(json, "rays");
  cell.peak_memory_bytes = json.at("peak_memory_bytes");
  cell.device = json.at("device");
  cell.reference_rmse = optional_from(json, "reference_rmse");
  cell.reference_psnr_db = optional_from(json, "reference_psnr_db");
  return cell;
}

}  // namespace

Result<Accuracy> accuracy_of(const Image& image, const Image& reference) {
  const Result<ImageMetrics> compared = compare_images(reference, image);
  if (!compared) return compared.error();
  const ImageMetrics& m = *compared;
  if (m.nonfinite_a + m.nonfinite_b > 0)
    return Error{"", "", fmt::format("{} pixels are not finite", m.nonfinite_a + m.nonfinite_b)};
  return Accuracy{m.rmse, m.psnr_db, m.ssim, m.flip, m.max_abs, m.max_abs_x, m.max_abs_y, m.share_over_1_255};
}

Spread spread_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return {0.5 * (values[(n - 1) / 2] + values[n / 2]), values.front(), values.back()};
}

Json to_json(const Cell& cell) {
  Json json = {{"id", setting_id(cell.setting)},
               {"method", cell.setting.method},
               {"setting", setting_text(cell.setting)},
               {"label", cell.setting.value > 0 ? std::to_string(cell.setting.value) : ""},
               {"value", cell.setting.value},
               {"status", cell.error.empty() ? "done" : "failed"},
               {"error", cell.error.empty() ? Json(nullptr) : Json(cell.error)}};
  if (cell.accuracy) {
    const Accuracy& a = *cell.accuracy;
    json["rmse"] = number(a.rmse);
    json["psnr_db"] = number(a.psnr_db);
    json["ssim"] = number(a.ssim);
    json["flip"] = number(a.flip);
    json["max_abs"] = number(a.max_abs);
    json["max_abs_at"] = {a.max_abs_x, a.max_abs_y};
    json["share_over_1_255"] = number(a.share_over_1_255);
  } else {
    for (const char* name : {"rmse", "psnr_db", "ssim", "flip", "max_abs", "max_abs_at", "share_over_1_255"})
      json[name] = nullptr;
  }
  if (cell.seconds.empty()) {
    json["seconds"] = {
        {"median", nullptr}, {"least", nullptr}, {"most", nullptr}, {"repeats", Json::array()}};
  } else {
    const Spread spread = spread_of(cell.seconds);
    json["seconds"] = {
        {"median", spread.median}, {"least", spread.least}, {"most", spread.most}, {"repeats", cell.seconds}};
  }
  json["fragments"] = number(cell.fragments);
  json["events"] = number(cell.events);
  json["rays"] = number(cell.rays);
  json["peak_memory_bytes"] = cell.peak_memory_bytes;
  json["device"] = cell.device;
  return json;
}

std::optional<Cell> load_cell(const std::string& path, const std::string& key) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  try {
    Cell cell = cell_from(Json::parse(file));
    if (cell.key == key) return cell;
  } catch (const Json::exception&) {
    // Not ours, or of another version: as good as none.
  }
  return std::nullopt;
}

Status save_cell(const std::string& path, const Cell& cell) {
  Json json = to_json(cell);
  json["key"] = cell.key;
  json["reference_rmse"] = number(cell.reference_rmse);
  json["reference_psnr_db"] = number(cell.reference_psnr_db);
  return write_file(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n');
}

}  // namespace swept
