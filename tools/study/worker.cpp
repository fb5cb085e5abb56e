#include "tools/study/worker.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <iterator>

#include <signal.h>
#include <sys/prctl.h>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <nlohmann/json.hpp>

#include "datasets/generators.h"
#include "splat/io/image_file.h"
#include "splat/stopwatch.h"
#include "tools/study/child_process.h"

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const WorkOrder& order) {
  const Variant& v = order.variant;
  return {{"variant",
           {{"id", v.id},
            {"title", v.title},
            {"file", v.file},
            {"size", v.size},
            {"points_scale", v.points_scale},
            {"exposure_scale", v.exposure_scale}}},
          {"method", order.setting.method},
          {"value", order.setting.value},
          {"threads", order.options.threads},
          {"gpu", order.options.gpu},
          {"image", order.image},
          {"warm_up", order.warm_up}};
}

WorkOrder order_from(const Json& json) {
  WorkOrder order;
  const Json& v = json.at("variant");
  order.variant = {v.at("id"),   v.at("title"),        v.at("file"),
                   v.at("size"), v.at("points_scale"), v.at("exposure_scale")};
  order.setting = {json.at("method"), json.at("value")};
  order.options = {json.at("threads"), json.at("gpu")};
  order.image = json.at("image");
  order.warm_up = json.at("warm_up");
  return order;
}

void put(Json& json, const char* name, const std::optional<double>& value) {
  if (value) json[name] = *value;
}

std::optional<double> get(const Json& json, const char* name) {
  const auto found = json.find(name);
  // What is infinite was written as null.
  if (found == json.end()) return std::nullopt;
  return found->is_number() ? found->get<double>() : HUGE_VAL;
}

Json to_json(const WorkDone& done) {
  Json json = {{"seconds", done.seconds}, {"device", done.device}};
  put(json, "fragments", done.fragments);
  put(json, "events", done.events);
  put(json, "rays", done.rays);
  put(json, "error_rmse", done.error_rmse);
  put(json, "error_psnr_db", done.error_psnr_db);
  return json;
}

WorkDone done_from(const Json& json) {
  WorkDone done;
  done.seconds = json.at("seconds");
  done.device = json.at("device");
  done.fragments = get(json, "fragments");
  done.events = get(json, "events");
  done.rays = get(json, "rays");
  done.error_rmse = get(json, "error_rmse");
  done.error_psnr_db = get(json, "error_psnr_db");
  return done;
}

/// Every object's first points: enough to start threads, compile shaders and touch the film's memory.
Scene for_warming_up(const Scene& scene) {
  constexpr std::size_t points = 64;
  Scene few = scene;
  for (Object& object : few.objects) {
    SurfelCloud& cloud = object.cloud;
    const auto cut = [](auto& values) {
      if (values.size() > points) values.resize(points);
    };
    for (auto& key : cloud.keys) {
      cut(key.pose.position);
      cut(key.pose.axis_u);
      cut(key.pose.axis_v);
    }
    cut(cloud.velocity);
    cut(cloud.acceleration);
    cut(cloud.angular_velocity);
    cut(cloud.lifetime);
    cut(cloud.color);
    cut(cloud.oriented);
    cut(cloud.opacity);
    for (LookKey& look : cloud.looks) {
      cut(look.color);
      cut(look.opacity);
    }
    std::erase_if(object.triangles, [](const Triangle& t) {
      return std::any_of(t.begin(), t.end(), [](std::uint32_t corner) { return corner >= points; });
    });
  }
  return few;
}

WorkDone summary_of(const Statistics& statistics, double seconds) {
  WorkDone done;
  done.seconds = seconds;
  done.fragments = statistics.counter("fragments");
  done.events = statistics.counter("intervals");
  done.rays = statistics.counter("rays");
  done.error_rmse = statistics.counter("reference_error_rmse");
  done.error_psnr_db = statistics.counter("reference_error_psnr_db");
  const std::string device = "device: ";
  for (const std::string& effect : statistics.effects)
    if (effect.starts_with(device)) done.device = effect.substr(device.size());
  return done;
}

Result<WorkDone> work(const WorkOrder& order) {
  Result<SceneFile> file = open_variant(order.variant);
  if (!file) return file.error();
  const Result<const Scene*> loaded = file->scene_at(file->scene().frame, generate);
  if (!loaded) return loaded.error();
  Scene scene = **loaded;
  apply_to_scene(order.setting, scene);
  const auto renderer = renderer_of(order.setting, order.options);
  if (!renderer) return renderer.error();
  if (order.warm_up)
    if (const Result<Rendered> warm = (*renderer)(for_warming_up(scene)); !warm) return warm.error();

  Stopwatch watch;
  const Result<Rendered> rendered = (*renderer)(scene);
  const double seconds = watch.lap();
  if (!rendered) return rendered.error();
  if (!order.image.empty())
    if (const Status written = write_exr(order.image, rendered->image); !written) return written.error();
  return summary_of(rendered->statistics, seconds);
}

/// What went wrong is an answer too; only a process that dies gives none.
void answer_order() {
  // A study that is killed takes its worker along.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  Json answer;
  try {
    const std::string text(std::istreambuf_iterator<char>(std::cin), {});
    const Result<WorkDone> done = work(order_from(Json::parse(text)));
    answer = done ? to_json(*done) : Json{{"failed", done.error().message()}};
  } catch (const std::exception& error) {
    answer = {{"failed", error.what()}};
  }
  fmt::print("{}\n", answer.dump(-1, ' ', false, Json::error_handler_t::replace));
}

constexpr const char* worker_command = "study-worker";

}  // namespace

Result<WorkDone> run_in_child(const WorkOrder& order, double limit_seconds) {
  const Result<ChildOutcome> outcome =
      run_child({"/proc/self/exe", worker_command}, to_json(order).dump(), limit_seconds);
  if (!outcome) return outcome.error();
  const auto failed = [&](std::string reason) {
    return Error{"", setting_id(order.setting), std::move(reason)};
  };
  if (outcome->timed_out) return failed(fmt::format("took longer than {:.0f} s", limit_seconds));
  if (outcome->signal != 0) return failed(fmt::format("ended by signal {}", outcome->signal));
  const Json answer = Json::parse(outcome->output, nullptr, false);
  if (!answer.is_object())
    return failed(fmt::format("ended with exit code {} and no answer", outcome->exit_code));
  if (answer.contains("failed")) return failed(answer["failed"]);
  try {
    WorkDone done = done_from(answer);
    done.peak_memory_bytes = outcome->peak_memory_bytes;
    return done;
  } catch (const Json::exception& error) {
    return failed(error.what());
  }
}

void add_study_worker_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(worker_command, "One render of a study");
  command->group("");
  command->callback([&exit_code] {
    answer_order();
    exit_code = 0;
  });
}

}  // namespace swept
