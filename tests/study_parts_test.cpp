// What the study is made of: child processes, cells on disk, the map of differences.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"
#include "tools/study/cell.h"
#include "tools/study/child_process.h"
#include "tools/study/difference_map.h"
#include "tools/study/methods.h"

namespace swept {
namespace {

using test::TemporaryFolder;

TEST(ChildProcess, GivesTextAndTakesText) {
  const auto outcome = run_child({"/bin/cat"}, "one\ntwo", 60.0);
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome->output, "one\ntwo");
  EXPECT_EQ(outcome->exit_code, 0);
  EXPECT_EQ(outcome->signal, 0);
  EXPECT_FALSE(outcome->timed_out);
  EXPECT_GT(outcome->peak_memory_bytes, 1e5);
}

TEST(ChildProcess, TakesMoreThanAPipeHolds) {
  const auto outcome = run_child({"/bin/sh", "-c", "head -c 1000000 /dev/zero"}, "", 60.0);
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome->output.size(), 1000000u);
}

TEST(ChildProcess, TellsHowItEnded) {
  const auto code = run_child({"/bin/sh", "-c", "exit 7"}, "", 60.0);
  ASSERT_TRUE(code.ok());
  EXPECT_EQ(code->exit_code, 7);
  const auto signal = run_child({"/bin/sh", "-c", "kill -SEGV $$"}, "", 60.0);
  ASSERT_TRUE(signal.ok());
  EXPECT_EQ(signal->signal, 11);
  EXPECT_FALSE(run_child({"/no/such/program"}, "", 60.0).ok());
}

TEST(ChildProcess, IsKilledWhenItsTimeIsOver) {
  const auto start = std::chrono::steady_clock::now();
  const auto outcome = run_child({"/bin/sleep", "60"}, "", 0.2);
  ASSERT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome->timed_out);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

/// A reader that is gone before it is written to must not take the writer along.
TEST(ChildProcess, SurvivesAChildThatDoesNotListen) {
  const auto outcome = run_child({"/bin/true"}, std::string(60000, 'x'), 60.0);
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome->exit_code, 0);
}

Cell measured() {
  Cell cell;
  cell.setting = {"gpu", 4};
  cell.key = "build hash";
  cell.accuracy = Accuracy{0.01, 40.0, 0.99, 0.02, 0.3, 5, 7, 0.25};
  cell.seconds = {3.0, 1.0, 2.0, 10.0};
  cell.fragments = 1234.0;
  cell.peak_memory_bytes = 5e6;
  cell.device = "a device";
  cell.reference_rmse = 1e-5;
  return cell;
}

TEST(StudyCell, ComesBackFromDisk) {
  const TemporaryFolder folder;
  const std::string path = folder / "cell.json";
  const Cell cell = measured();
  ASSERT_TRUE(save_cell(path, cell).ok());
  const auto loaded = load_cell(path, cell.key);
  ASSERT_TRUE(loaded.has_value());
  EXPECT_EQ(to_json(*loaded), to_json(cell));
  EXPECT_EQ(loaded->reference_rmse, cell.reference_rmse);
  EXPECT_FALSE(loaded->reference_psnr_db.has_value());
}

TEST(StudyCell, OfAnotherBuildOrSceneIsNotTaken) {
  const TemporaryFolder folder;
  const std::string path = folder / "cell.json";
  ASSERT_TRUE(save_cell(path, measured()).ok());
  EXPECT_FALSE(load_cell(path, "another build").has_value());
  EXPECT_FALSE(load_cell(folder / "nothing.json", "build hash").has_value());
  test::put(path, "{\"key\": \"build hash\"");
  EXPECT_FALSE(load_cell(path, "build hash").has_value());
}

/// An image equal to its reference has no finite PSNR, and JSON no infinity.
TEST(StudyCell, EqualImagesStayEqual) {
  const TemporaryFolder folder;
  Cell cell = measured();
  cell.accuracy->rmse = 0.0;
  cell.accuracy->psnr_db = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(to_json(cell).at("psnr_db").is_null());
  ASSERT_TRUE(save_cell(folder / "cell.json", cell).ok());
  const auto loaded = load_cell(folder / "cell.json", cell.key);
  ASSERT_TRUE(loaded.has_value());
  EXPECT_TRUE(std::isinf(loaded->accuracy->psnr_db));
}

TEST(StudyCell, SpreadIsOfTheMiddle) {
  const Spread even = spread_of({3.0, 1.0, 2.0, 10.0}), odd = spread_of({5.0, 1.0, 2.0}),
               one = spread_of({4.0});
  EXPECT_EQ(even.median, 2.5);
  EXPECT_EQ(even.least, 1.0);
  EXPECT_EQ(even.most, 10.0);
  EXPECT_EQ(odd.median, 2.0);
  EXPECT_EQ(one.median, 4.0);
}

Image flat(float value) {
  Image image;
  image.width = image.film_width = 4;
  image.height = image.film_height = 3;
  image.rgba.assign(48, value);
  image.depth.assign(12, 1.0f);
  return image;
}

TEST(StudyCell, PixelsThatAreNotFiniteAreAnError) {
  Image broken = flat(0.5f);
  broken.rgba[5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(accuracy_of(broken, flat(0.5f)).ok());
  ASSERT_TRUE(accuracy_of(flat(0.5f), flat(0.25f)).ok());
  EXPECT_DOUBLE_EQ(accuracy_of(flat(0.5f), flat(0.25f))->rmse, 0.25);
}

TEST(DifferenceMap, GrowsLighterByDecades) {
  const auto light_of = [](double difference) {
    Image a = flat(0.0f), b = flat(0.0f);
    b.rgba[1] = static_cast<float>(difference);
    const Image map = difference_map(a, b);
    return 0.2126f * map.rgba[0] + 0.7152f * map.rgba[1] + 0.0722f * map.rgba[2];
  };
  EXPECT_EQ(light_of(0.0), 0.0f);
  EXPECT_EQ(light_of(0.9 * kDifferenceLow), 0.0f);
  EXPECT_EQ(light_of(2.0 * kDifferenceHigh), light_of(kDifferenceHigh));
  float before = -1.0f;
  for (int step = 0; step <= 20; ++step) {
    const float light = light_of(kDifferenceLow * std::pow(kDifferenceHigh / kDifferenceLow, step / 20.0));
    EXPECT_GT(light, before) << step;
    before = light;
  }
}

TEST(StudyMethods, HaveIdsThatNameFiles) {
  for (const StudyMethod& method : study_methods()) {
    EXPECT_EQ(find_study_method(method.id), &method);
    EXPECT_EQ(method.id.find_first_not_of("abcdefghijklmnopqrstuvwxyz-"), std::string::npos) << method.id;
    EXPECT_FALSE(method.values.empty());
    for (const int value : method.values) EXPECT_EQ(value > 0, !method.unit.empty()) << method.id;
  }
  EXPECT_EQ(setting_id({"gpu", 4}), "gpu-4");
  EXPECT_EQ(setting_id({"abuffer", 0}), "abuffer");
  EXPECT_EQ(setting_text({"gpu", 1}), "1 sub-frame");
  EXPECT_EQ(setting_text({"raycast", 16}), "16 samples per pixel");
  EXPECT_EQ(find_study_method("reference"), nullptr);
}

}  // namespace
}  // namespace swept
