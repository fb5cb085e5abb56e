#include "tools/study/plan.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include <fmt/core.h>

#include "splat/io/atomic_file.h"
#include "splat/io/scene_file.h"
#include "tools/study/raycast.h"
#include "tools/study/scene_asset.h"

namespace swept {
namespace {

constexpr const char* own_scenes[] = {"default", "knot", "heads", "page", "overlap", "both_ends", "still"};

/// The scene that motion and points are varied on, where it is not given.
constexpr const char* varied_scene = "knot";

class Planner {
 public:
  explicit Planner(const StudyOptions& options) : options_(options) {}

  Result<StudyPlan> plan() {
    StudyPlan plan;
    std::vector<std::string> scenes = options_.scenes, names;
    const bool own = scenes.empty();
    if (own) scenes.assign(std::begin(own_scenes), std::end(own_scenes));
    for (std::string& scene : scenes) {
      Result<std::string> file = own ? own_scene(scene) : Result<std::string>(scene);
      if (!file) return file.error();
      names.push_back(unique_name(std::filesystem::path(scene).stem().string(), names));
      scene = *file;
    }
    const std::size_t varied = own ? std::find(names.begin(), names.end(), varied_scene) - names.begin() : 0;

    for (std::size_t i = 0; i < scenes.size() && has(StudyPart::scenes); ++i) {
      const Result<Task> task = task_of(names[i], names[i], scenes[i], {});
      if (!task) return task.error();
      plan.scenes.push_back(*task);
      plan.scenes.back().settings = settings_of_all();
      plan.scenes.back().pictures = true;
    }
    if (has(StudyPart::motion))
      for (const double scale : options_.quick ? std::vector{0.0625, 0.25, 1.0}
                                               : std::vector{0.03125, 0.0625, 0.125, 0.25, 0.5, 1.0}) {
        const Result<Task> task = task_of(names[varied], fmt::format("{}-exposure-{}", names[varied], scale),
                                          scenes[varied], {scale, 1.0});
        if (!task) return task.error();
        plan.motion.push_back(*task);
        plan.motion.back().settings = settings_of_sweeps();
      }
    if (has(StudyPart::points))
      for (const double scale : {0.0625, 0.25, 1.0, 4.0}) {
        const Result<Task> task = task_of(names[varied], fmt::format("{}-points-{}", names[varied], scale),
                                          scenes[varied], {1.0, scale});
        if (!task) return task.error();
        // Points of files cannot be multiplied.
        if (!task->facts.scalable) break;
        plan.points.push_back(*task);
        plan.points.back().settings = settings_of_sweeps();
      }
    if (has(StudyPart::table1))
      for (const PaperRow& row : paper_table1()) {
        const Result<Task> task = table1_task(row);
        if (!task) return task.error();
        plan.table1.emplace_back(row, *task);
      }
    return plan;
  }

 private:
  struct Scales {
    double exposure = 1.0, points = 1.0;
  };

  [[nodiscard]] bool has(StudyPart part) const {
    if (options_.parts.empty()) return !options_.quick || part != StudyPart::table1;
    return options_.parts.count(part) > 0;
  }

  [[nodiscard]] bool has_method(const std::string& id) const {
    if (!options_.methods.empty()) return options_.methods.count(id) > 0;
    return id != "raycast" || raycast_available();
  }

  [[nodiscard]] std::vector<Setting> settings_of_all() const {
    std::vector<Setting> settings;
    for (const StudyMethod& method : study_methods())
      if (has_method(method.id))
        for (const int value : options_.quick ? method.quick_values : method.values)
          settings.push_back({method.id, value});
    return settings;
  }

  [[nodiscard]] std::vector<Setting> settings_of_sweeps() const {
    std::vector<Setting> settings = {{"abuffer", 0}, {"gpu", 4}, {"sampled", 16}, {"raycast", 16}};
    if (!options_.quick)
      settings.insert(settings.end(),
                      {{"abuffer-pixel", 0}, {"gpu", 1}, {"gpu", 16}, {"gpu-still", 16}, {"sampled", 64}});
    std::erase_if(settings, [&](const Setting& setting) { return !has_method(setting.method); });
    return settings;
  }

  [[nodiscard]] static std::string unique_name(const std::string& stem,
                                               const std::vector<std::string>& taken) {
    std::string name = stem;
    for (int i = 2; std::find(taken.begin(), taken.end(), name) != taken.end(); ++i)
      name = fmt::format("{}-{}", stem, i);
    return name;
  }

  /// Puts a scene that comes with the program where the study's reader finds it.
  [[nodiscard]] Result<std::string> own_scene(const std::string& name) const {
    const std::string folder = options_.runner.folder + "/scenes", path = folder + '/' + name + ".json";
    std::error_code code;
    std::filesystem::create_directories(folder, code);
    if (code) return Error{folder, "", code.message()};
    if (const Status written = write_file(path, scene_asset(name + ".json")); !written)
      return written.error();
    return path;
  }

  /// The film the study wants of a scene of this film.
  [[nodiscard]] std::array<int, 2> size_of(const Film& film) const {
    if (options_.size) return *options_.size;
    const double longest = options_.quick ? 160.0 : 384.0;
    const double scale = std::min(1.0, longest / std::max(film.width, film.height));
    return {std::max(1, static_cast<int>(std::lround(film.width * scale))),
            std::max(1, static_cast<int>(std::lround(film.height * scale)))};
  }

  [[nodiscard]] Result<Task> task_of(const std::string& title, const std::string& id, const std::string& file,
                                     const Scales& scales) const {
    const Result<SceneFile> scene = read_scene_file(file);
    if (!scene) return scene.error();
    Task task;
    task.variant = {id,
                    title,
                    file,
                    size_of(scene->scene().film),
                    scales.points * options_.points_scale * (options_.quick ? 0.1 : 1.0),
                    scales.exposure};
    Result<VariantFacts> facts = facts_of(task.variant);
    if (!facts) return facts.error();
    if (facts->points == 0) return Error{file, "/objects", "there are no points to study"};
    task.facts = *facts;
    return task;
  }

  /// The paper's number of points, whatever the scene file says.
  [[nodiscard]] Result<Task> table1_task(const PaperRow& row) const {
    const Result<std::string> file = own_scene(row.scene);
    if (!file) return file.error();
    const Result<VariantFacts> facts = facts_of({"", "", *file, {}, 1.0, 1.0});
    if (!facts) return facts.error();
    const double scale = static_cast<double>(row.points) / static_cast<double>(facts->points);
    return task_of(row.scene, "table1-" + row.figure, *file, {1.0, scale});
  }

  const StudyOptions& options_;
};

}  // namespace

Result<StudyPlan> plan_study(const StudyOptions& options) { return Planner(options).plan(); }

}  // namespace swept
