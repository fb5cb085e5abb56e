// A report of the sample study, and the browser that shows it.
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/io/image_file.h"
#include "tests/study_report/browser.h"
#include "tests/temporary_folder.h"
#include "tools/study/report.h"

namespace swept::test {

using nlohmann::json;
using nlohmann::ordered_json;

/// An image of one colour; the green channel tells which it is.
inline void write_plain_png(const std::string& path, int width, float green) {
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
inline constexpr const char* two_frames =
    "new Promise((kept) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(kept))))";

inline std::string quoted(const std::string& text) { return json(text).dump(); }

/// A report of made-up numbers, with a failed result, results without error, and text that breaks careless
/// pages.
class StudyReportPage : public ::testing::Test {
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

}  // namespace swept::test
