// The plots of the study's report, as a browser draws them.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/study_report/page.h"
#include "tools/study/report.h"

namespace swept {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;
using test::quoted;
using test::two_frames;

class StudyReportPlot : public test::StudyReportPage {};

TEST_F(StudyReportPlot, PlotsHaveExactlyTheirPoints) {
  // On the front if the document says so, though others beat it.
  ordered_json& beaten = study_["scenes"][0]["cells"][1];
  ASSERT_EQ(beaten["pareto"], false);
  beaten["pareto"] = true;
  ASSERT_NO_FATAL_FAILURE(open_with_plots());
  if (IsSkipped()) return;
  for (const ordered_json& scene : study_["scenes"]) {
    const std::string plot = "plot-" + scene["id"].get<std::string>();
    const json drawn = points_of(plot);
    std::size_t done = 0, shown = 0, exact = 0;
    double least = INFINITY, least_error = INFINITY;
    for (const json& series : drawn)
      for (const double y : series["y"]) least = std::min(least, y);
    for (const ordered_json& method : study_["methods"]) {
      const std::string id = method["id"];
      std::size_t i = 0;
      for (const ordered_json& cell : scene["cells"]) {
        if (cell["method"] != id || cell["status"] != "done") continue;
        ASSERT_LT(i, drawn[id]["x"].size()) << id;
        // Printed with 4 digits, and taken to a logarithm by the same function.
        EXPECT_NEAR(drawn[id]["x"][i].get<double>(), std::log10(cell["seconds"]["median"].get<double>()),
                    1e-12);
        const double rmse = cell["rmse"], y = drawn[id]["y"][i];
        if (rmse > 0) {
          EXPECT_NEAR(y, std::log10(rmse), 1e-12);
          least_error = std::min(least_error, y);
        } else {
          EXPECT_EQ(y, least);
          ++exact;
        }
        ++i, ++done;
      }
      shown += i;
      EXPECT_EQ(drawn[id]["x"].size(), i) << id;
    }
    EXPECT_GE(done, 19U);
    // No error at all is below every error.
    if (exact > 0) {
      EXPECT_LT(least, least_error);
    }
    EXPECT_EQ(exact > 0, scene["id"] == "still");
    // As many markers as there are points, and a label for each.
    const std::string host = "document.getElementById(" + quoted(plot) + ")";
    EXPECT_EQ(evaluate(host + ".querySelectorAll('.scatterlayer .point').length"), shown);
    EXPECT_EQ(evaluate(host + ".layout.annotations.filter((label) => label.name === 'label').length"), shown);
    // The front is the one of the document.
    const auto on_front = std::ranges::count_if(
        scene["cells"], [](const ordered_json& cell) { return cell.value("pareto", false); });
    EXPECT_EQ(evaluate(host + ".data.find((trace) => trace.meta.front).x.length"), on_front + 1);
  }
  // Only where the reference has an error is there a line for it.
  EXPECT_EQ(evaluate("document.getElementById('plot-knot').layout.shapes.length"), 2);
  EXPECT_EQ(evaluate("document.getElementById('plot-still').layout.shapes.length"), 0);

  for (const char* list : {"motion_length", "point_count"}) {
    std::size_t done = 0;
    for (const ordered_json& row : study_[list])
      done += std::ranges::count_if(row["cells"],
                                    [](const ordered_json& cell) { return cell["status"] == "done"; });
    std::size_t drawn = 0;
    for (const json& series : points_of(list == std::string("motion_length") ? "motion-length-knot-cost"
                                                                             : "point-count-knot-cost"))
      drawn += series["x"].size();
    EXPECT_EQ(drawn, done) << list;
  }
}

TEST_F(StudyReportPlot, PlotFollowsItsChoices) {
  ASSERT_NO_FATAL_FAILURE(open_with_plots());
  if (IsSkipped()) return;
  const std::string figure = "document.getElementById('plot-knot').closest('figure')";
  const ordered_json& exact = study_["scenes"][0]["cells"][0];
  const auto choose = [&](const std::string& measure, const std::string& title) {
    evaluate("(() => { const list = " + figure + ".querySelector('select'); list.value = " + quoted(measure) +
             "; list.dispatchEvent(new Event('change')); })()");
    browser_->wait_until("document.getElementById('plot-knot').layout.yaxis.title.text === " + quoted(title));
    return points_of("plot-knot")["abuffer"]["y"][0].get<double>();
  };
  EXPECT_DOUBLE_EQ(choose("psnr_db", "PSNR, dB"), exact["psnr_db"].get<double>());
  EXPECT_NEAR(choose("ssim", "1 − SSIM"), std::log10(1 - exact["ssim"].get<double>()), 1e-9);
  EXPECT_NEAR(choose("flip", "FLIP"), std::log10(exact["flip"].get<double>()), 1e-12);
  EXPECT_NEAR(choose("max_abs", "Largest difference"), std::log10(exact["max_abs"].get<double>()), 1e-12);

  // The front by a measure of which the document says nothing is worked out; in the sample it is that of the
  // RMSE.
  const auto on_front = std::ranges::count_if(
      study_["scenes"][0]["cells"], [](const ordered_json& cell) { return cell.value("pareto", false); });
  EXPECT_EQ(evaluate("document.getElementById('plot-knot').data.find((trace) => trace.meta.front).x.length"),
            on_front + 1);

  // A method can be hidden, and shown again.
  EXPECT_TRUE(points_of("plot-knot").contains("gpu"));
  const std::string button = "#scene-knot .legend li:nth-child(4) button";
  browser_->click(button);
  browser_->wait_until(
      "!document.getElementById('plot-knot').data.some((trace) => trace.meta.series === 'gpu')");
  EXPECT_EQ(evaluate("document.querySelector(" + quoted(button) + ").ariaPressed"), "false");
  browser_->click(button);
  browser_->wait_until(
      "document.getElementById('plot-knot').data.some((trace) => trace.meta.series === 'gpu')");

  // Zoomed in there are labels for what is in view alone, and a double click returns.
  const std::string labels =
      "document.getElementById('plot-knot').layout.annotations.filter((label) => label.name === "
      "'label').length";
  const int all = evaluate(labels);
  browser_->drag("#plot-knot .nsewdrag", 0.1, 0.4, false);
  browser_->wait_until(labels + " < " + std::to_string(all));
  EXPECT_GT(evaluate(labels), 0);
  // The library takes presses within 300 ms for one double click; the drag's is not to be one of them.
  evaluate("new Promise((kept) => setTimeout(kept, 400))");
  browser_->click("#plot-knot .nsewdrag", 2);
  browser_->wait_until(labels + " === " + std::to_string(all));
}

TEST_F(StudyReportPlot, LabelsCoverNeitherEachOtherNorMarkers) {
  ASSERT_NO_FATAL_FAILURE(open_with_plots());
  if (IsSkipped()) return;
  for (const int width : {1280, 360}) {
    browser_->resize(width, 800);
    browser_->wait_until("document.getElementById('plot-knot').layout.width <= " + std::to_string(width));
    evaluate(two_frames);
    // Boxes of the text as drawn; two may touch, and what is cut off would be outside the plot.
    const json covered = evaluate(R"((() => {
      const found = [];
      for (const plot of document.querySelectorAll('.plot')) {
        const frame = plot.querySelector('.nsewdrag').getBoundingClientRect();
        const boxes = [...plot.querySelectorAll('.annotation-text')].map((text) => [text.textContent, text.getBoundingClientRect()]);
        const markers = [...plot.querySelectorAll('.scatterlayer .point')].map((point) => point.getBoundingClientRect());
        const meet = (a, b, by) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > by && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > by;
        boxes.forEach(([name, a], i) => {
          // A marker is 10 px wide; its corner may reach under a letter's box.
          if (innerWidth > 1000 && markers.some((marker) => meet(a, marker, 3))) found.push(`${plot.id}: ${name} covers a marker`);
          if (a.left < frame.left - 2 || a.right > frame.right + 2 || a.top < frame.top - 2 || a.bottom > frame.bottom + 2)
            found.push(`${plot.id}: ${name} is cut off`);
          for (const [other, b] of boxes.slice(i + 1)) {
            if (meet(a, b, 1)) found.push(`${plot.id}: ${name} and ${other}`);
          }
        });
      }
      return found; })())");
    EXPECT_EQ(covered, json::array()) << width;
  }
}

}  // namespace
}  // namespace swept
