// The study's report: the file, and the page as a browser shows it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
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
using test::content_of;
using test::put;
using test::quoted;
using test::two_frames;

class StudyReport : public test::StudyReportPage {};

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

  // Without its plotting library a report says so in the place of each plot.
  EXPECT_EQ(evaluate("document.querySelectorAll('main .note').length > 0"), !report_has_plots());

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

/// The verdict is what the cells say: two scenes, two methods that reach 60 dB, one that does not.
TEST_F(StudyReport, BeginsWithAVerdictInTwoSentences) {
  const auto cell = [](const char* method, double seconds, double db) {
    return ordered_json{
        {"id", method},     {"method", method},
        {"status", "done"}, {"psnr_db", db},
        {"rmse", 0.1},      {"seconds", {{"median", seconds}, {"least", seconds}, {"most", 1.5 * seconds}}}};
  };
  study_ = {
      {"swept_study", 1},
      {"methods",
       {{{"id", "a"}, {"name", "Method A"}},
        {{"id", "b"}, {"name", "Method B"}},
        {{"id", "c"}, {"name", "Method C"}},
        {{"id", "d"}, {"name", "Method D"}, {"missing", "there is no D here"}},
        {{"id", "e"}, {"name", "Method E"}}}},
      {"scenes",
       {{{"id", "one"},
         {"cells", {cell("a", 1.0, 61.0), cell("a", 0.1, 50.0), cell("b", 2.0, 70.0), cell("c", 0.1, 59.0)}}},
        {{"id", "two"}, {"cells", {cell("a", 4.0, 65.0), cell("b", 32.0, 60.0), cell("e", 1.0, 9.0)}}}}}};
  study_["scenes"][0]["cells"][0]["seconds"]["most"] = 1.0;
  study_["scenes"][1]["cells"][2] = {
      {"id", "e"}, {"method", "e"}, {"status", "failed"}, {"error", "no device"}};
  ASSERT_NO_FATAL_FAILURE(open());
  if (IsSkipped()) return;
  EXPECT_EQ(evaluate("document.querySelector('#head .verdict').textContent"),
            "Method A reaches 60 dB on 2 of 2 scenes, in 2.00 s in the geometric mean, and on 2 of them "
            "before all others. "
            "Next comes Method B, which takes 4.00 times as long (on the 2 that both reach).");
  // Methods without results say why.
  const json reasons = evaluate(
      "[...document.querySelectorAll('#methods dd .bad')].map((reason) => reason.textContent.trim())");
  EXPECT_EQ(reasons, json({"No results: there is no D here.", "No results: no device."}));
  // Half of the median lies between the fastest repeat and the slowest, but for one, where nothing does.
  EXPECT_EQ(evaluate("document.querySelectorAll('#scene-one .wide').length"), 3);
  EXPECT_EQ(evaluate("document.querySelector('#scene-one .wide').textContent"), "50 % ⚠");
  EXPECT_EQ(browser_->complaints(), std::vector<std::string>());
}

TEST_F(StudyReport, NoColumnIsOffTheEdge) {
  ASSERT_NO_FATAL_FAILURE(open());
  if (IsSkipped()) return;
  browser_->resize(1400, 900);
  evaluate(two_frames);
  evaluate("document.querySelectorAll('details').forEach((part) => { part.open = true; })");
  evaluate(two_frames);
  EXPECT_GT(evaluate("document.querySelectorAll('.scroll').length"), 3);
  EXPECT_EQ(
      evaluate("[...document.querySelectorAll('.scroll')].filter((box) => box.scrollWidth > "
               "box.clientWidth).map((box) => `${box.ariaLabel}: ${box.scrollWidth - box.clientWidth}`)"),
      json::array());
}

/// A label in a plot begins with a word that the legend has too.
TEST_F(StudyReport, LegendAndLabelsSayTheSameNames) {
  ASSERT_NO_FATAL_FAILURE(open());
  if (IsSkipped()) return;
  const json names = evaluate(
      "[...document.querySelectorAll('#scene-knot .legend button')].map((button) => button.textContent)");
  ASSERT_EQ(names.size(), 7u);
  EXPECT_EQ(names[0], "abuffer: Exact A-buffer");
  EXPECT_EQ(names[3], "gpu: Six GPU passes");
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
  // Which picture is seen there, as the browser itself decides it; both, if one shows through the other.
  const auto seen = [&](double part) {
    return evaluate(
        "(() => { const stack = document.querySelector('#scene-knot .stack'); "
        "stack.scrollIntoView({block: 'center', behavior: 'instant'}); const box = "
        "stack.getBoundingClientRect(); "
        "return document.elementsFromPoint(box.left + " +
        std::to_string(part) +
        " * box.width, box.top + box.height / 3).filter((found) => found.tagName === 'IMG').map((found) => "
        "found.className).join(' and '); })()");
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
  EXPECT_EQ(evaluate("document.querySelector('#head p:not(.verdict)').textContent.split(':')[0]"),
            "1 method at their settings on 2 scenes");
  EXPECT_EQ(browser_->complaints(), std::vector<std::string>());
}

}  // namespace
}  // namespace swept
