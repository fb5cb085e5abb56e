#include "tools/study/study_command.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "splat/io/atomic_file.h"
#include "splat/io/point_file.h"
#include "splat/io/splat_file.h"
#include "tools/check_number.h"
#include "tools/console.h"
#include "tools/progress.h"
#include "tools/study/added_images.h"
#include "tools/study/document.h"
#include "tools/study/mesh_tables.h"
#include "tools/study/plan.h"
#include "tools/study/report.h"
#include "tools/study/traversal.h"

namespace swept {
namespace {

using Clock = std::chrono::steady_clock;

struct StudyArguments {
  StudyOptions options;
  std::vector<std::string> parts, methods;
  std::vector<AddedImage> added;
  bool fresh = false, repeats_given = false, samples_given = false;
};

const std::map<std::string, StudyPart> part_names = {
    {"scenes", StudyPart::scenes}, {"motion", StudyPart::motion},       {"points", StudyPart::points},
    {"table1", StudyPart::table1}, {"traversal", StudyPart::traversal}, {"visibility", StudyPart::visibility},
    {"ronnow", StudyPart::ronnow}, {"hierarchy", StudyPart::hierarchy}};

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

/// As it was typed, but for quotes.
std::string command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (!text.empty() && text.back() == '\0') text.pop_back();
  std::replace(text.begin(), text.end(), '\0', ' ');
  return text;
}

/// All that a study is, from the first render to the report.
class Study {
 public:
  explicit Study(const StudyArguments& arguments)
      : options_(arguments.options), added_(arguments.added), runner_(options_.runner) {
    header_.command = command_line();
    header_.started = utc_now();
    header_.quick = options_.quick;
    header_.repeats = options_.runner.repeats;
    header_.reference_samples = options_.runner.reference_samples;
  }

  Status run() {
    const Result<StudyPlan> plan = plan_study(options_);
    if (!plan) return plan.error();
    for (const std::vector<Task>* tasks : {&plan->scenes, &plan->motion, &plan->points})
      for (const Task& task : *tasks) runner_.plan(task);
    if (const Status ran = run(plan->scenes, done_.scenes); !ran) return ran;
    if (const Status ran = run(plan->motion, done_.motion); !ran) return ran;
    if (const Status ran = run(plan->points, done_.points); !ran) return ran;
    for (const auto& [paper, task] : plan->table1) {
      const Result<Table1Row> row = run_table1_row(runner_, paper, task);
      if (!row) return row.error();
      table1_.push_back(*row);
      if (const Status written = write(); !written) return written;
    }
    if (options_.parts.count(StudyPart::traversal) > 0)
      if (const Status ran = run_traversals(); !ran) return ran;
    if (const Status ran = run_mesh_tables(); !ran) return ran;
    return write();
  }

  [[nodiscard]] std::size_t failed() const { return failed_; }
  [[nodiscard]] std::size_t cells() const { return cells_; }

 private:
  Status run(const std::vector<Task>& tasks, std::vector<Task>& done) {
    for (const Task& task : tasks) {
      if (const Status ran = runner_.run(task); !ran) return ran;
      done.push_back(task);
      cells_ += task.settings.size();
      for (const Setting& setting : task.settings)
        failed_ += runner_.cell(task, setting).error.empty() ? 0 : 1;
      // What there is can be looked at while the rest is rendered.
      if (const Status written = write(); !written) return written;
    }
    return Done{};
  }

  /// Made-up scenes, and real ones where they are; each time anew.
  Status run_mesh_tables() {
    const auto asked = [&](StudyPart part) { return options_.parts.count(part) > 0; };
    if (!asked(StudyPart::visibility) && !asked(StudyPart::ronnow) && !asked(StudyPart::hierarchy))
      return Done{};
    MeshTableOptions options;
    options.quick = options_.quick;
    options.stills = header_.reference_samples;
    options.triangles = options_.triangles;
    options.motions_px = options_.motions_px;
    options.films_px = options_.films_px;
    options.looks = options_.looks;
    options.side_px = options_.size   ? std::max((*options_.size)[0], (*options_.size)[1])
                      : options.quick ? 96
                                      : 256;
    const std::string folder = options_.runner.folder + "/scenes";
    std::error_code code;
    std::filesystem::create_directories(folder, code);
    if (code) return Error{folder, "", code.message()};
    Status written = Done{};
    const auto run_one = [&](const auto& make) {
      mesh_tables_.emplace_back();
      const auto done = [&](const StudyTable& table) {
        ++cells_;
        failed_ += table.failed - mesh_tables_.back().failed;
        mesh_tables_.back() = table;
        log("{}: {} rows\n", table.title, table.rows.size());
        if (written) written = write();
        if (written) written = write_file(options_.runner.folder + "/" + table.id + ".md", markdown(table));
      };
      make(done);
    };
    if (asked(StudyPart::visibility))
      run_one([&](const RowDone& done) {
        return visibility_table(visibility_scenes(options.side_px, folder), options, done);
      });
    if (asked(StudyPart::ronnow))
      run_one([&](const RowDone& done) {
        MeshTableOptions large = options;
        if (!options_.size && !options.quick) large.side_px = 1024;  // the paper's, and its double
        // The paper's cloth ball, or where that is not a ball as round.
        std::vector<TraversalScene> scenes = visibility_scenes(large.side_px, folder);
        const bool real = scenes.front().title == "Cloth ball";
        std::erase_if(scenes, [&](const TraversalScene& scene) {
          return scene.title != (real ? "Cloth ball" : "Rotation");
        });
        return ronnow_table(scenes, large, done);
      });
    if (asked(StudyPart::hierarchy))
      run_one([&](const RowDone& done) { return hierarchy_table(options, done); });
    return written;
  }

  /// Each time anew: it takes little.
  Status run_traversals() {
    const int side_px = options_.size    ? std::max((*options_.size)[0], (*options_.size)[1])
                        : options_.quick ? 96
                                         : 256;
    const int samples = options_.quick ? 16 : 64;
    std::vector<TraversalScene> scenes;
    for (const std::string& path : options_.scenes)
      scenes.push_back(traversal_scene(std::filesystem::path(path).stem().string(), path, side_px));
    if (scenes.empty()) {
      const std::string folder = options_.runner.folder + "/scenes";
      std::error_code code;
      std::filesystem::create_directories(folder, code);
      if (code) return Error{folder, "", code.message()};
      scenes = traversal_scenes(side_px, folder);
    }
    for (const TraversalScene& scene : scenes) {
      traversals_.push_back(measure_traversals(scene, samples, std::min(header_.repeats, 2)));
      const TraversalRow& row = traversals_.back();
      ++cells_;
      failed_ += row.error.empty() ? 0 : 1;
      log("traversals on {}: {}\n", row.title, row.error.empty() ? "done" : row.error);
      if (const Status written = write(); !written) return written;
    }
    return Done{};
  }

  Status write() {
    header_.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    nlohmann::ordered_json document = study_document(header_, runner_, done_, table1_);
    if (!traversals_.empty()) document["traversal"] = to_json(traversals_);
    for (const StudyTable& table : mesh_tables_) document["mesh_tables"].push_back(to_json(table));
    const std::string& folder = options_.runner.folder;
    if (Status added = add_images(added_, folder, document); !added) return added;
    const auto replace = nlohmann::ordered_json::error_handler_t::replace;
    if (Status written = write_file(folder + "/study.json", document.dump(2, ' ', false, replace) + '\n');
        !written)
      return written;
    if (Status written = write_file(folder + "/study.csv", study_csv(document)); !written) return written;
    return write_report(folder + "/report.html", document, folder);
  }

  StudyOptions options_;
  std::vector<AddedImage> added_;
  Runner runner_;
  StudyHeader header_;
  StudyPlan done_;
  std::vector<Table1Row> table1_;
  std::vector<TraversalRow> traversals_;
  std::vector<StudyTable> mesh_tables_;
  std::size_t failed_ = 0, cells_ = 0;
  Clock::time_point start_ = Clock::now();
};

/// Throws what the command line gets wrong.
void complete(StudyArguments& arguments) {
  StudyOptions& options = arguments.options;
  for (const std::string& part : arguments.parts) options.parts.insert(part_names.at(part));
  options.methods.insert(arguments.methods.begin(), arguments.methods.end());
  if (options.runner.reference_samples % 2 != 0)
    throw CLI::ValidationError("--reference-samples", "must be even");
  if (!arguments.added.empty() && options.scenes.size() != 1)
    throw CLI::ValidationError("--add", "goes with one scene");
  if (options.quick && !arguments.repeats_given) options.runner.repeats = 2;
  if (options.quick && !arguments.samples_given) options.runner.reference_samples = 192;
}

int study(StudyArguments& arguments) {
  complete(arguments);
  const std::string& folder = arguments.options.runner.folder;
  const auto fail = [](const Error& error) {
    log("swept study: {}\n", error.message());
    return 1;
  };
  for (const std::string& scene : arguments.options.scenes)
    if (is_point_file_name(scene) || is_splat_file_name(scene))
      return fail({scene, "", "a study takes scene files; swept init makes one of points"});
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) return fail({folder, "--output", code.message()});
  if (arguments.fresh) std::filesystem::remove_all(folder + "/data", code);
  Study run(arguments);
  if (const Status done = run.run(); !done) return fail(done.error());
  if (run.failed() > 0) log("{} of {} cells failed; the report says why\n", run.failed(), run.cells());
  fmt::print("{}\n", folder + "/report.html");
  // A method that this machine lacks is a result. A study of nothing else is none.
  return run.cells() > 0 && run.failed() == run.cells() ? 1 : 0;
}

std::vector<std::string> method_ids() {
  std::vector<std::string> ids;
  for (const StudyMethod& method : study_methods()) ids.push_back(method.id);
  return ids;
}

}  // namespace

void add_study_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<StudyArguments>();
  StudyOptions& options = arguments->options;
  CLI::App* command = app.add_subcommand(
      "study", "Measure how wrong every method is on scenes, and how long it takes; started again, goes on");
  command->footer(std::string("Examples:\n"
                              "  swept study -o study --quick             some two minutes, over the scenes "
                              "that come with the program\n"
                              "  swept study scene.json -o study --methods sampled,abuffer\n"
                              "\n") +
                  exit_codes_help);
  command->add_option("scene", options.scenes, "Scene files; by default the seven that come with the program")
      ->type_name("FILE.json");
  command
      ->add_option("-o,--output", options.runner.folder,
                   "Folder for report.html, study.json, study.csv and the images")
      ->required()
      ->type_name("FOLDER");
  command->add_flag("--quick", options.quick,
                    "Some two minutes: small films, a tenth of the points, few settings");
  command
      ->add_option(
          "--parts", arguments->parts,
          "Only these: scenes, motion, points, table1, and what no study has unasked: traversal, and "
          "visibility, ronnow and hierarchy, of triangles alone")
      ->delimiter(',')
      ->check(CLI::IsMember(
          {"scenes", "motion", "points", "table1", "traversal", "visibility", "ronnow", "hierarchy"}));
  command->add_option("--methods", arguments->methods, "Only these")
      ->delimiter(',')
      ->check(CLI::IsMember(method_ids()));
  const auto* repeats =
      command->add_option("--repeats", options.runner.repeats, "Timed renders of each cell [3; quick: 2]")
          ->check(CLI::Range(1, 1000));
  const auto* samples = command
                            ->add_option("--reference-samples", options.runner.reference_samples,
                                         "Still images of the reference, even [1024; quick: 192]")
                            ->check(CLI::Range(2, 1 << 20));
  command
      ->add_option_function<std::vector<int>>(
          "--size",
          [arguments](const std::vector<int>& size) {
            arguments->options.size = {{size[0], size[1]}};
          },
          "Film size in pixels; else the scene's, reduced to a longest side of 384 [quick: 160]")
      ->delimiter('x')
      ->expected(2)
      ->check(CLI::Range(1, 65536))
      ->type_name("WxH");
  command->add_option("--points-scale", options.points_scale, "Multiply the points of generated objects")
      ->check(CLI::PositiveNumber);
  command->add_option("--threads", options.runner.method.threads, "Threads; 0 takes all")
      ->check(CLI::Range(0, 1024));
  command
      ->add_option("--triangles", options.triangles,
                   "Of the part hierarchy: so many triangles [10000,100000,1000000]")
      ->delimiter(',')
      ->check(CLI::Range(1, 20'000'000))
      ->type_name("N,...");
  command
      ->add_option("--motions", options.motions_px,
                   "Of the part hierarchy: how far they move, px [0,10,30,100,300]")
      ->delimiter(',')
      ->check(CLI::Range(0.0, 1e6))
      ->check(check_is_number)
      ->type_name("PX,...");
  command
      ->add_option("--films", options.films_px,
                   "Of the part ronnow: sides of its films, px, without the last columns [1024,2048]")
      ->delimiter(',')
      ->check(CLI::Range(1, 65536))
      ->type_name("PX,...");
  command->add_option("--looks", options.looks, "Of the part ronnow: only these [all four]")
      ->delimiter(',')
      ->check(CLI::IsMember({"opaque", "painted", "transparent", "textured"}));
  command
      ->add_option("--gpu", options.runner.method.gpu,
                   "Device of the GPU methods, as `swept info --gpus` lists them")
      ->type_name("DEVICE");
  command
      ->add_option("--limit", options.runner.limit_seconds, "Seconds after which a render counts as failed")
      ->check(CLI::PositiveNumber)
      ->check(check_is_number)
      ->capture_default_str();
  command
      ->add_option_function<std::vector<std::string>>(
          "--add",
          [arguments](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) {
              const std::size_t equals = text.find('=');
              if (equals == 0 || equals == std::string::npos || !text.ends_with(".exr"))
                throw CLI::ValidationError("--add", "expected NAME=FILE.exr, found " + text);
              arguments->added.push_back({text.substr(0, equals), text.substr(equals + 1)});
            }
          },
          "Judge this image of the one scene too, of another program and of the study's --size; several may "
          "be added")
      ->type_name("NAME=FILE.exr")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_flag("--fresh", arguments->fresh, "Measure all of it again");
  command->callback([arguments, repeats, samples, &exit_code] {
    arguments->repeats_given = repeats->count() > 0;
    arguments->samples_given = samples->count() > 0;
    exit_code = study(*arguments);
  });
}

}  // namespace swept
