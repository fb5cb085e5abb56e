// The study's report: the file, and the page as a browser shows it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/io/image_file.h"
#include "tests/study_report/browser.h"
#include "tests/temporary_folder.h"
#include "tools/study/report.h"

namespace swept {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;
using test::Browser;
using test::content_of;
using test::put;
using test::TemporaryFolder;

/// An image of one colour; the green channel tells which it is.
void write_plain_png(const std::string& path, int width, float green) {
  Image image;
  image.width = image.film_width = width;
  image.height = image.film_height = 16;
  for (std::size_t i = 0; i < image.pixel_count(); ++i)
    image.rgba.insert(image.rgba.end(), {0.2F, green, 0.1F, 1.0F});
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  const Status written = write_png(path, image);
  ASSERT_TRUE(written) << written.error().message();
}

/// Kept when what was queued for the next frame is on the screen.
constexpr const char* two_frames =
    "new Promise((kept) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(kept))))";

std::string quoted(const std::string& text) { return json(text).dump(); }

/// A report of made-up numbers, with a failed result, results without error, and text that breaks careless
/// pages.
class StudyReport : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ifstream file(SWEPT_SAMPLE_STUDY);
    study_ = ordered_json::parse(file);
    int width = 16;
    for (const ordered_json& scene : study_["scenes"]) {
      write_plain_png(folder_ / scene["reference"]["image"].get<std::string>(), 16, 0.9F);
      for (const ordered_json& cell : scene["cells"]) {
        // Sizes of every remainder to three, for what the page encodes.
        for (const char* key : {"image", "difference"})
          if (cell.contains(key)) write_plain_png(folder_ / cell[key].get<std::string>(), ++width, 0.3F);
      }
    }
  }

  std::string page() const { return folder_ / "report.html"; }

  void write() {
    const Status written = write_report(page(), study_, folder_ / "");
    ASSERT_TRUE(written) << written.error().message();
  }

  /// Skips where there is no browser; otherwise the page is open, its plots drawn.
  void open(int width = 1280) {
    browser_ = Browser::start();
    if (browser_ == nullptr) GTEST_SKIP() << "no chromium is installed";
    write();
    browser_->resize(width, 900);
    show();
  }

  void show() {
    browser_->open(page());
    browser_->wait_until("[...document.querySelectorAll('.plot')].every((plot) => plot.data?.length > 0)");
  }

  void open_with_plots(int width = 1280) {
    if (!report_has_plots()) GTEST_SKIP() << "this build has no plotting library";
    open(width);
  }

  json evaluate(const std::string& expression) { return browser_->evaluate(expression); }

  /// {series: {x: [...], y: [...]}} of a plot, gaps left out.
  json points_of(const std::string& plot) {
    return evaluate("Object.fromEntries(document.getElementById(" + quoted(plot) +
                    ").data.filter((trace) => trace.meta.series).map((trace) => [trace.meta.series, "
                    "{x: trace.x.filter((x) => x !== null), y: trace.y.filter((y) => y !== null)}]))");
  }

  TemporaryFolder folder_;
  ordered_json study_;
  std::unique_ptr<Browser> browser_;
};

TEST_F(StudyReport, NamesWhatIsWrongAndLeavesNoPage) {
  const std::string missing = folder_ / "images/knot/reference.png";
  std::filesystem::rename(missing, missing + ".away");
  Status written = write_report(page(), study_, folder_ / "");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().file, missing);

  put(missing, "GIF89a");
  written = write_report(page(), study_, folder_ / "");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().message(), missing + ": is not a PNG file");

  written = write_report(page(), ordered_json::object(), folder_ / "");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().field, "/scenes");
  EXPECT_FALSE(write_report(folder_ / "nowhere/report.html", {{"scenes", ordered_json::array()}}, ""));
  EXPECT_EQ(folder_.names(), std::set<std::string>{"images"});
}

TEST_F(StudyReport, KeepsTheDocumentWhateverItsTextSays) {
  study_["command"] = "</script><!--<script> \" ' & {{css}} \xe2\x80\xa8";
  study_["scenes"][0]["title"] = "not UTF-8: \xff";
  study_["scenes"][0]["reference"]["rmse"] = std::nan("");
  write();
  const std::string text = content_of(page());
  const std::string start = "<script type=\"application/json\" id=\"study\">";
  const std::size_t from = text.find(start) + start.size();
  const std::string held = text.substr(from, text.find("</script>", from) - from);
  const ordered_json read = ordered_json::parse(held, nullptr, false);
  ASSERT_TRUE(read.is_object());
  EXPECT_EQ(read["command"], study_["command"]);
  EXPECT_EQ(read["scenes"][0]["title"], "not UTF-8: \xef\xbf\xbd");
  EXPECT_TRUE(read["scenes"][0]["reference"]["rmse"].is_null());
  EXPECT_EQ(read["scenes"][0]["cells"], study_["scenes"][0]["cells"]);
}

TEST_F(StudyReport, OpensWithoutComplaintOrRequest) {
  ASSERT_NO_FATAL_FAILURE(open());
  if (IsSkipped()) return;
  EXPECT_EQ(browser_->complaints(), std::vector<std::string>());
  EXPECT_EQ(browser_->requests(), std::vector<std::string>());

  // No width lets the page itself scroll sideways, and dark colours are used where they are asked for.
  for (const int width : {320, 768, 1920}) {
    browser_->resize(width, 800);
    evaluate(two_frames);
    EXPECT_EQ(evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth"), 0)
        << width;
  }
  const std::string background = "getComputedStyle(document.body).backgroundColor";
  EXPECT_EQ(evaluate(background), "rgb(255, 255, 255)");
  browser_->call("Emulation.setEmulatedMedia",
                 {{"features", json::array({{{"name", "prefers-color-scheme"}, {"value", "dark"}}})}});
  EXPECT_EQ(evaluate(background), "rgb(20, 23, 27)");
  if (report_has_plots()) {
    browser_->wait_until(
        "[...document.querySelectorAll('.plot')].every((plot) => plot.layout.paper_bgcolor === '#14171b')");
  }
  EXPECT_EQ(browser_->complaints(), std::vector<std::string>());

  // What this test looks for would be seen: the page may not load what it is told to, and the browser says
  // so.
  evaluate(
      "(() => { new Image().src = 'https://elsewhere.invalid/a.png'; console.error('planted'); "
      "setTimeout(() => { throw new Error('planted'); }); })()");
  browser_->wait_until("new Promise((kept) => setTimeout(() => kept(true), 200))");
  const std::vector<std::string> complaints = browser_->complaints();
  for (const char* seen : {"Content Security Policy", "consoleAPICalled", "exceptionThrown"}) {
    EXPECT_TRUE(std::ranges::any_of(complaints, [&](const std::string& text) {
      return text.find(seen) != text.npos;
    })) << seen;
  }
}

TEST_F(StudyReport, HoldsEveryImageByteForByte) {
  ASSERT_NO_FATAL_FAILURE(open());
  if (IsSkipped()) return;
  const json held = evaluate(
      "Object.fromEntries([...document.querySelectorAll('script[data-image]')].map((image) => "
      "[image.dataset.image, [...atob(image.textContent)].map((c) => c.charCodeAt(0))]))");
  std::size_t named = 0;
  for (const ordered_json& scene : study_["scenes"]) {
    std::vector<std::string> images{scene["reference"]["image"]};
    for (const ordered_json& cell : scene["cells"])
      for (const char* key : {"image", "difference"})
        if (cell.contains(key)) images.push_back(cell[key]);
    for (const std::string& image : images) {
      const std::string bytes = content_of(folder_ / image);
      ASSERT_TRUE(held.contains(image)) << image;
      EXPECT_TRUE(std::ranges::equal(held[image], bytes, [](const json& code, char byte) {
        return code == static_cast<int>(static_cast<unsigned char>(byte));
      })) << image;
      ++named;
    }
  }
  EXPECT_EQ(held.size(), named);
}

TEST_F(StudyReport, PlotsHaveExactlyTheirPoints) {
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

TEST_F(StudyReport, PlotFollowsItsChoices) {
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
}

TEST_F(StudyReport, LabelsCoverNeitherEachOtherNorMarkers) {
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

TEST_F(StudyReport, TableSorts) {
  ASSERT_NO_FATAL_FAILURE(open());
  if (IsSkipped()) return;
  const auto column = [&](int number) {
    return evaluate(
        "[...document.querySelectorAll('#scene-knot tbody tr')].map((row) => "
        "row.classList.contains('failed') ? "
        "'failed' : row.children[" +
        std::to_string(number - 1) + "].textContent)");
  };
  const auto header = [](int number) {
    return "#scene-knot thead tr:last-child th:nth-child(" + std::to_string(number) + ")";
  };
  const auto order = [&](int number) {
    return evaluate("document.querySelector(" + quoted(header(number)) + ").ariaSort");
  };
  constexpr int setting = 2, time = 3, rmse = 5;
  const json before = column(time);
  ASSERT_EQ(before.size(), study_["scenes"][0]["cells"].size());
  EXPECT_EQ(evaluate("document.querySelector('#scene-knot tr.failed .reason').textContent"),
            "failed: " + study_["scenes"][0]["cells"][8]["error"].get<std::string>());

  std::vector<double> seconds;
  for (const ordered_json& cell : study_["scenes"][0]["cells"])
    if (cell["status"] == "done") seconds.push_back(cell["seconds"]["median"]);
  std::ranges::sort(seconds);
  browser_->click(header(time) + " button");
  json sorted = column(time);
  EXPECT_EQ(order(time), "ascending");
  ASSERT_EQ(sorted.size(), seconds.size() + 1);
  EXPECT_EQ(sorted.back(), "failed");
  // Three digits are shown: half a unit of the third.
  for (std::size_t i = 0; i < seconds.size(); ++i)
    EXPECT_NEAR(std::stod(sorted[i].get<std::string>()), seconds[i], 0.005 * seconds[i]);

  browser_->click(header(time) + " button");
  sorted = column(time);
  EXPECT_EQ(order(time), "descending");
  EXPECT_EQ(sorted.back(), "failed");
  for (std::size_t i = 0; i < seconds.size(); ++i)
    EXPECT_NEAR(std::stod(sorted[i].get<std::string>()), seconds[seconds.size() - 1 - i],
                0.005 * seconds[seconds.size() - 1 - i]);

  // Numbers in powers of ten sort as numbers, and numbers in text too.
  browser_->click(header(rmse) + " button");
  EXPECT_EQ(order(rmse), "ascending");
  EXPECT_EQ(order(time), "none");
  EXPECT_EQ(column(rmse)[0], "1.35 × 10⁻⁵");
  browser_->click(header(setting) + " button");
  json settings = evaluate(
      "[...document.querySelectorAll('#scene-knot tbody tr')].map((row) => "
      "row.children[1].firstChild.textContent).filter((text) => text.endsWith('stills'))");
  EXPECT_EQ(settings,
            json({"4 stills", "4 stills", "16 stills", "16 stills", "64 stills", "64 stills", "256 stills"}));
}

TEST_F(StudyReport, SliderMovesTheSplit) {
  ASSERT_NO_FATAL_FAILURE(open());
  if (IsSkipped()) return;
  // Which picture is seen there, as the browser itself decides it.
  const auto seen = [&](double part) {
    return evaluate(
        "(() => { const stack = document.querySelector('#scene-knot .stack'); "
        "stack.scrollIntoView({block: 'center', behavior: 'instant'}); const box = "
        "stack.getBoundingClientRect(); "
        "return document.elementFromPoint(box.left + " +
        std::to_string(part) + " * box.width, box.top + box.height / 3).className; })()");
  };
  EXPECT_EQ(seen(0.45), "left");
  EXPECT_EQ(seen(0.55), "right");
  EXPECT_GT(evaluate("document.querySelector('#scene-knot .left').naturalWidth"), 0);
  EXPECT_GT(evaluate("document.querySelector('#scene-knot .difference-image').naturalWidth"), 0);

  evaluate("document.querySelector('#scene-knot input[type=range]').focus()");
  for (int i = 0; i < 10; ++i) browser_->press("ArrowRight");
  EXPECT_EQ(seen(0.65), "left");
  EXPECT_EQ(seen(0.75), "right");
  for (int i = 0; i < 20; ++i) browser_->press("ArrowLeft");
  EXPECT_EQ(seen(0.25), "left");
  EXPECT_EQ(seen(0.35), "right");
  browser_->press("End");
  EXPECT_EQ(seen(0.98), "left");
  browser_->press("Home");
  EXPECT_EQ(seen(0.02), "right");
  browser_->drag("#scene-knot .stack", 0.1, 0.8, false);
  EXPECT_EQ(seen(0.75), "left");
  EXPECT_EQ(seen(0.85), "right");
  browser_->drag("#scene-knot .stack", 0.7, 0.2, true);
  EXPECT_EQ(seen(0.15), "left");
  EXPECT_EQ(seen(0.25), "right");
  browser_->drag("#scene-knot input[type=range]", 0.2, 0.6, false);
  EXPECT_EQ(seen(0.5), "left");
  EXPECT_EQ(seen(0.7), "right");

  // Another picture, and its difference with it.
  evaluate(
      "(() => { const list = document.querySelectorAll('#scene-knot .comparison select')[1]; list.value = "
      "'abuffer'; "
      "list.dispatchEvent(new Event('change')); })()");
  EXPECT_EQ(evaluate("document.querySelector('#scene-knot .right').alt"), "knot: Exact A-buffer, exact");
  EXPECT_EQ(evaluate("document.querySelector('#scene-knot .right').src.split(',')[1] === "
                     "document.querySelector('[data-image=\"images/knot/abuffer.png\"]').textContent"),
            true);
  EXPECT_EQ(
      evaluate("document.querySelector('#scene-knot .difference-image').src.split(',')[1] === "
               "document.querySelector('[data-image=\"images/knot/abuffer.difference.png\"]').textContent"),
      true);
  EXPECT_EQ(browser_->complaints(), std::vector<std::string>());
}

TEST_F(StudyReport, LeavesOutWhatIsNotThere) {
  study_ = {{"swept_study", 1}, {"scenes", ordered_json::array()}, {"motion_length", ordered_json::array()}};
  ASSERT_NO_FATAL_FAILURE(open());
  if (IsSkipped()) return;
  EXPECT_EQ(evaluate("[...document.querySelectorAll('h2')].map((title) => title.textContent)"),
            json({"The machine and the command"}));

  // A scene of which nothing but its name is known, and results of a method that is not introduced.
  const ordered_json odd = {{"id", "odd"}, {"method", "other"}, {"status", "failed"}, {"error", nullptr}};
  study_["scenes"] = {{{"id", "bare"}}, {{"id", "all-failed"}, {"cells", ordered_json::array({odd})}}};
  write();
  show();
  EXPECT_EQ(evaluate("document.querySelectorAll('h2').length"), 3);
  EXPECT_EQ(evaluate("document.querySelectorAll('.plot').length"), 0);
  EXPECT_EQ(evaluate("document.querySelector('.reason').textContent"), "failed");
  EXPECT_EQ(browser_->complaints(), std::vector<std::string>());
}

}  // namespace
}  // namespace swept
