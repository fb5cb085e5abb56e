#include "tools/study/mesh_tables.h"

#include <cmath>

#include <fmt/core.h>

#include "abuffer/abuffer.h"
#include "abuffer/sampled.h"
#include "abuffer/visibility.h"
#include "splat/compare/metrics.h"
#include "tools/cpu_seconds.h"

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

/// Spread over the exposure, one in each part of it, so that none shares its place in a part with another.
std::vector<double> spread_times(int count) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) {
    const double place = 0.618033988749895 * (i + 0.5);
    times.push_back((i + (place - std::floor(place))) / count);
  }
  return times;
}

std::string text_of(const Json& cell) {
  if (cell.is_null()) return "";
  if (cell.is_string()) return cell.get<std::string>();
  const double v = cell.get<double>();
  if (std::floor(v) == v && std::abs(v) < 1e15) return fmt::format("{:.0f}", v);
  return fmt::format("{:.4g}", v);
}

RenderControl one_thread() {
  RenderControl control;
  control.threads = 1;
  return control;
}

/// A row that says what went wrong.
void fail(StudyTable& table, const std::string& title, const std::string& why, const RowDone& done) {
  table.rows.push_back({title, why});
  table.rows.back().resize(table.columns.size());
  ++table.failed;
  done(table);
}

}  // namespace

Json to_json(const StudyTable& table) {
  return {{"id", table.id},
          {"title", table.title},
          {"note", table.note},
          {"columns", table.columns},
          {"rows", table.rows}};
}

std::string markdown(const StudyTable& table) {
  std::string text = "# " + table.title + "\n\n" + table.note + "\n\n|";
  for (const std::string& column : table.columns) text.append(" ").append(column).append(" |");
  text += "\n|";
  for (std::size_t i = 0; i < table.columns.size(); ++i) text += "---|";
  for (const auto& row : table.rows) {
    text += "\n|";
    for (const Json& cell : row) text.append(" ").append(text_of(cell)).append(" |");
  }
  return text + "\n";
}

StudyTable visibility_table(const std::vector<TraversalScene>& scenes, const MeshTableOptions& options,
                            const RowDone& done) {
  const int instants = options.quick ? 4 : 16;
  StudyTable table{
      "visibility",
      "Visibility accuracy, and intervals that are merged",
      fmt::format("The exact method on triangles of one colour each, one thread, {} px; PSNR against {} "
                  "stills. Accuracy: of the samples in (x, y, t), 16 places a pixel at {} instants, that see "
                  "a triangle, those of which the intervals name the one that rays meet first. Without tile "
                  "tests every "
                  "pixel of a moving triangle's box is solved for, as in Gribel et al. 2010.",
                  options.side_px, options.stills, instants),
      {"scene", "intervals a place", "accuracy, %", "PSNR, dB", "CPU s", "intervals, MiB", "samples"},
      {}};
  const std::vector<double> times = spread_times(instants);
  for (const TraversalScene& scene : scenes) {
    if (!scene.error.empty()) {
      fail(table, scene.title, scene.error, done);
      continue;
    }
    const Result<VisibleTriangles> truth = visible_at_instants(scene.scene, times);
    SampledOptions still;
    still.samples = options.stills;
    const Result<Rendered> stills = render_sampled(scene.scene, still);
    if (!truth || !stills) {
      fail(table, scene.title, !truth ? truth.error().message() : stills.error().message(), done);
      continue;
    }
    struct Setting {
      Json label;
      std::size_t most;
      bool tile_tests;
    };
    for (const auto& [label, most, tile_tests] : {Setting{"all", 0, true},
                                                  {"all, no tile tests", 0, false},
                                                  {32, 32, true},
                                                  {16, 16, true},
                                                  {8, 8, true},
                                                  {4, 4, true},
                                                  {2, 2, true}}) {
      AbufferOptions exact;
      exact.place_intervals = most;
      exact.tile_tests = tile_tests;
      const double before = cpu_seconds();
      const Result<Rendered> rendered = render_abuffer(scene.scene, exact, one_thread());
      const double seconds = cpu_seconds() - before;
      const Result<VisibleTriangles> named = visible_by_intervals(scene.scene, times, exact);
      if (!rendered || !named) {
        fail(table, scene.title, !rendered ? rendered.error().message() : named.error().message(), done);
        break;
      }
      const VisibilityAccuracy accuracy = visibility_accuracy(*truth, *named);
      const Result<ImageMetrics> metrics = compare_images(rendered->image, stills->image);
      // 32 bytes each, as they are held.
      const double bytes = 32.0 * rendered->statistics.counter("fragments_held").value_or(0.0);
      table.rows.push_back({scene.title, label, 100.0 * accuracy.share(),
                            metrics ? Json(metrics->psnr_db) : Json(nullptr), seconds, bytes / 0x1p20,
                            accuracy.samples});
      done(table);
    }
  }
  return table;
}

}  // namespace swept
