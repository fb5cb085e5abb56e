// A study as a researcher runs it: what is left on disk, going on after a stop, cells that fail.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <sys/wait.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/temporary_folder.h"

namespace swept {
namespace {

using nlohmann::json;
using test::content_of;
using test::put;
using test::TemporaryFolder;

constexpr const char* small_scene = R"({
  "swept": 1,
  "film": {"width": 48, "height": 32},
  "frame": 3,
  "camera": {"fov": {"axis": "vertical", "degrees": 40},
             "keys": [{"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]}]},
  "objects": [{"name": "ball", "source": {"generator": "sphere", "points": 300},
               "transform": {"keys": [{"frame": 2, "translate": [-1, 0, 0]},
                                      {"frame": 4, "translate": [1, 0, 0]}]}}]
})";

class StudyCommand : public ::testing::Test {
 protected:
  void SetUp() override { put(scene_, small_scene); }

  /// Exit code; stderr goes to log().
  int study(const std::string& options) const {
    const std::string line = std::string("'") + SWEPT_COMMAND + "' study " + scene_ + " -o " + output_ +
                             " --reference-samples 64 --repeats 1 " + options + " >" + (folder_ / "out") +
                             " 2>" + (folder_ / "log") + " </dev/null";
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  [[nodiscard]] std::string log() const { return content_of(folder_ / "log"); }
  [[nodiscard]] json document() const { return json::parse(content_of(output_ + "/study.json")); }
  [[nodiscard]] std::string cell_path(const std::string& id) const {
    return output_ + "/data/ball/" + id + ".json";
  }

  TemporaryFolder folder_;
  std::string scene_ = folder_ / "ball.json", output_ = folder_ / "study";
};

const json& cell_of(const json& scene, const std::string& id) {
  for (const json& cell : scene.at("cells"))
    if (cell.at("id") == id) return cell;
  static const json none;
  ADD_FAILURE() << "no cell " << id;
  return none;
}

TEST_F(StudyCommand, JudgesImagesThatAreAdded) {
  const std::string render = std::string("'") + SWEPT_COMMAND + "' render " + scene_ + " --overwrite ";
  ASSERT_EQ(std::system((render + "-o " + (folder_ / "mine.exr") + " --samples 4 2>/dev/null").c_str()), 0);
  ASSERT_EQ(std::system((render + "-o " + (folder_ / "small.exr") + " --size 24x16 2>/dev/null").c_str()), 0);
  const std::string added = "--add 'Mine=" + (folder_ / "mine.exr") +
                            "' --add 'Of another size=" + (folder_ / "small.exr") + "' --add lost=none.exr";
  ASSERT_EQ(study("--parts scenes --methods sampled " + added), 0) << log();
  const json scene = document().at("scenes").at(0);
  // The same instants as a method's own.
  const json mine = cell_of(scene, "added-1"), own = cell_of(scene, "sampled-4");
  EXPECT_EQ(mine.at("status"), "done");
  EXPECT_EQ(mine.at("rmse"), own.at("rmse"));
  EXPECT_EQ(mine.at("flip"), own.at("flip"));
  EXPECT_TRUE(mine.at("seconds").at("median").is_null());
  for (const char* member : {"image", "difference"})
    EXPECT_TRUE(std::filesystem::exists(output_ + '/' + mine.at(member).get<std::string>()));
  for (const char* id : {"added-2", "added-3"}) {
    EXPECT_EQ(cell_of(scene, id).at("status"), "failed");
    EXPECT_NE(cell_of(scene, id).at("error"), "");
  }
  EXPECT_EQ(document().at("methods").back().at("name"), "lost");
  const std::string csv = content_of(output_ + "/study.csv");
  EXPECT_NE(csv.find("added-1"), std::string::npos);
  EXPECT_NE(content_of(output_ + "/report.html").find("Of another size"), std::string::npos);
  EXPECT_EQ(study("--add mine.exr"), 2);
  EXPECT_EQ(study("--add =mine.exr"), 2);
  EXPECT_EQ(study("'" + scene_ + "' --add a=mine.exr"), 2) << "two scenes";
}

TEST_F(StudyCommand, MeasuresTraversalsWhereTheyAreAskedFor) {
  ASSERT_EQ(study("--parts traversal --quick --size 24x16"), 0) << log();
  const json traversal = document().at("traversal");
  ASSERT_EQ(traversal.at("rows").size(), 1u);
  EXPECT_EQ(traversal["rows"][0]["scene"], "ball");
  EXPECT_TRUE(traversal["rows"][0]["error"].is_null());
  EXPECT_EQ(traversal["findings"].size(), 2u);
  EXPECT_NE(content_of(output_ + "/report.html").find("Gribel et al. 2013, redone"), std::string::npos);
}

TEST_F(StudyCommand, LeavesAReportTheDataAndTheImages) {
  ASSERT_EQ(study("--parts scenes --methods abuffer,sampled"), 0) << log();
  EXPECT_EQ(content_of(folder_ / "out"), output_ + "/report.html\n");
  const json scene = document().at("scenes").at(0);
  EXPECT_EQ(scene.at("points"), 300);
  EXPECT_EQ(scene.at("width"), 48);
  // Half a unit of motion, of 4 units in front of the eye for the nearest points: 32 / (2 tan 20°) / 4.5 px.
  EXPECT_NEAR(scene.at("motion_px").at("median").get<double>(), 4.4, 0.9);
  ASSERT_EQ(scene.at("cells").size(), 7u);
  const json exact = cell_of(scene, "abuffer"), few = cell_of(scene, "sampled-4"),
             many = cell_of(scene, "sampled-64");
  // One segment: what is left is the pixel filter, which is that of the segment's middle.
  EXPECT_GT(exact.at("psnr_db").get<double>(), few.at("psnr_db").get<double>() + 10.0);
  EXPECT_GT(many.at("psnr_db").get<double>(), few.at("psnr_db").get<double>() + 10.0);
  EXPECT_GT(exact.at("seconds").at("median").get<double>(), 0.0);
  EXPECT_GT(exact.at("fragments").get<double>(), 300.0);
  EXPECT_GT(exact.at("peak_memory_bytes").get<double>(), 1e6);
  for (const json& cell : scene.at("cells"))
    for (const char* member : {"image", "difference"})
      EXPECT_TRUE(std::filesystem::exists(output_ + '/' + cell.at(member).get<std::string>()))
          << cell.at("id");
  EXPECT_TRUE(std::filesystem::exists(output_ + "/images/ball/abuffer.exr"));
  // A header, and a row for each cell.
  const std::string csv = content_of(output_ + "/study.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 8);
  EXPECT_NE(content_of(output_ + "/report.html").find("sampled-64"), std::string::npos);
}

TEST_F(StudyCommand, GoesOnWhereItWas) {
  ASSERT_EQ(study("--parts scenes --methods abuffer,sampled"), 0) << log();
  const std::string kept = content_of(cell_path("sampled-4")), lost = content_of(cell_path("sampled-8"));
  std::filesystem::remove(cell_path("sampled-8"));
  ASSERT_EQ(study("--parts scenes --methods abuffer,sampled"), 0);
  EXPECT_EQ(content_of(cell_path("sampled-4")), kept);
  // One render, of that cell.
  const std::string text = log();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  EXPECT_NE(text.find("8 instants"), std::string::npos) << text;
  // The same figures; only the times are new.
  json before = json::parse(lost), after = json::parse(content_of(cell_path("sampled-8")));
  for (json* cell : {&before, &after})
    for (const char* changes : {"seconds", "peak_memory_bytes"}) cell->erase(changes);
  EXPECT_EQ(before, after);
}

TEST_F(StudyCommand, ShowsACellThatFailedAndRunsTheRest) {
  ASSERT_EQ(study("--parts scenes --methods abuffer,gpu --gpu no-such-device"), 0) << log();
  const json scene = document().at("scenes").at(0);
  EXPECT_EQ(cell_of(scene, "abuffer").at("status"), "done");
  const json failed = cell_of(scene, "gpu-4");
  EXPECT_EQ(failed.at("status"), "failed");
  EXPECT_FALSE(failed.at("error").get<std::string>().empty());
  EXPECT_TRUE(failed.at("rmse").is_null());
  EXPECT_NE(log().find("6 of 7 cells failed"), std::string::npos) << log();
}

TEST_F(StudyCommand, StopsARenderThatTakesTooLong) {
  // A study without a single result is a failure, though its report is there.
  ASSERT_EQ(study("--parts scenes --methods sampled --limit 0.0001"), 1) << log();
  const json study = document();
  const json& cells = study.at("scenes").at(0).at("cells");
  EXPECT_FALSE(cells.empty());
  for (const json& cell : cells) EXPECT_EQ(cell.at("status"), "failed");
}

TEST_F(StudyCommand, VariesMotionAndPoints) {
  ASSERT_EQ(study("--parts motion,points --methods abuffer --quick"), 0) << log();
  const json study = document();
  EXPECT_TRUE(study.at("scenes").empty());
  ASSERT_EQ(study.at("motion_length").size(), 3u);
  double before = 0.0;
  for (const json& entry : study.at("motion_length")) {
    EXPECT_GT(entry.at("motion_px").get<double>(), 1.5 * before);
    before = entry.at("motion_px").get<double>();
  }
  ASSERT_EQ(study.at("point_count").size(), 4u);
  EXPECT_EQ(study.at("point_count").back().at("points"), 120);
  // Images are of use while they are compared.
  EXPECT_FALSE(std::filesystem::exists(output_ + "/images/ball-points-4/abuffer.exr"));
}

TEST_F(StudyCommand, RefusesWhatCannotBe) {
  EXPECT_EQ(study("--methods magic"), 2);
  EXPECT_EQ(study("--parts everything"), 2);
  EXPECT_EQ(study("--reference-samples 7"), 2);
  put(scene_, "{}");
  EXPECT_EQ(study(""), 1);
  EXPECT_NE(log().find("ball.json"), std::string::npos) << log();
}

}  // namespace
}  // namespace swept
