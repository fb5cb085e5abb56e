// swept compare, as a command.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/io/image_file.h"
#include "tests/command.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using test::Outcome;
using test::TemporaryFolder;

Outcome run(const std::vector<std::string>& arguments) {
  return test::run_command(SWEPT_COMMAND " compare", arguments);
}

class CompareCommand : public testing::Test {
 protected:
  void SetUp() override {
    Image image{0, 0, 16, 12, 16, 12, std::vector<float>(4 * 16 * 12, 0.5f), {}};
    ASSERT_TRUE(write_exr(a_, image).ok());
    for (std::size_t i = 0; i < image.pixel_count(); ++i) image.rgba[4 * i + 3] = 0.5f;
    for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] += i % 4 == 3 ? 0.0f : 0.125f;
    ASSERT_TRUE(write_exr(b_, image).ok());
    image.film_width = 20;
    ASSERT_TRUE(write_exr(wide_, image).ok());
  }

  TemporaryFolder folder_;
  std::string a_ = folder_ / "a.exr", b_ = folder_ / "b.exr", wide_ = folder_ / "wide.exr";
};

TEST_F(CompareCommand, PrintsFigures) {
  const Outcome outcome = run({a_, b_});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  // −20 log₁₀ 0.125 = 18.0618
  EXPECT_NE(outcome.out.find("18.062 dB"), std::string::npos) << outcome.out;
}

TEST_F(CompareCommand, PrintsJsonAlone) {
  const Outcome outcome = run({a_, b_, "--json"});
  EXPECT_EQ(outcome.exit_code, 0);
  const nlohmann::json report = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(report.at("rmse"), 0.125);
  EXPECT_EQ(report.at("identical"), false);
  EXPECT_EQ(report.at("pixels"), 16 * 12);
  EXPECT_NEAR(report.at("psnr_db").get<double>(), 18.0618, 5e-5);
  EXPECT_GT(report.at("flip"), 0.0);

  const nlohmann::json same = nlohmann::json::parse(run({a_, a_, "--json"}).out);
  EXPECT_EQ(same.at("identical"), true);
  EXPECT_TRUE(same.at("psnr_db").is_null());
}

TEST_F(CompareCommand, HoldsImagesToALimit) {
  EXPECT_EQ(run({a_, b_, "--min-psnr", "18"}).exit_code, 0);
  EXPECT_EQ(run({a_, a_, "--min-psnr", "1000"}).exit_code, 0);
  const Outcome below = run({a_, b_, "--min-psnr", "18.1"});
  EXPECT_EQ(below.exit_code, 1);
  EXPECT_NE(below.err.find("18.062 dB is below"), std::string::npos) << below.err;

  Image holed = *read_exr(a_);
  holed.rgba[5] = std::nanf("");
  ASSERT_TRUE(write_exr(folder_ / "holed.exr", holed).ok());
  const Outcome with_hole = run({a_, folder_ / "holed.exr", "--min-psnr", "18"});
  EXPECT_EQ(with_hole.exit_code, 1);
  EXPECT_NE(with_hole.out.find("NOT FINITE"), std::string::npos) << with_hole.out;
}

TEST_F(CompareCommand, WritesTheDifference) {
  ASSERT_EQ(run({a_, b_, "--difference", folder_ / "d.exr", "--scale", "4"}).exit_code, 0);
  const Result<Image> difference = read_exr(folder_ / "d.exr");
  ASSERT_TRUE(difference.ok()) << difference.error().message();
  EXPECT_EQ(difference->rgba[0], 0.5f);
  ASSERT_EQ(run({a_, b_, "--difference", folder_ / "d.png"}).exit_code, 0);
  EXPECT_EQ(test::content_of(folder_ / "d.png").substr(1, 3), "PNG");
}

TEST_F(CompareCommand, FailuresExitWithOneAndNameTheFile) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{a_, folder_ / "missing.exr"}, {folder_ / "missing.exr", a_}}) {
    const Outcome missing = run(arguments);
    EXPECT_EQ(missing.exit_code, 1);
    EXPECT_EQ(missing.out, "");
    EXPECT_NE(missing.err.find(folder_ / "missing.exr"), std::string::npos) << missing.err;
  }
  const Outcome films = run({b_, wide_});
  EXPECT_EQ(films.exit_code, 1);
  EXPECT_NE(films.err.find("16x12 and 20x12"), std::string::npos) << films.err;
  EXPECT_EQ(run({a_, b_, "--difference", a_ + "/d.png"}).exit_code, 1);
}

TEST_F(CompareCommand, HeadersAreComparedBeforePixels) {
  // Pixels that cannot be read, which goes unsaid: nobody looked.
  std::string damaged = test::content_of(wide_);
  for (std::size_t at = damaged.size() - 40; at < damaged.size(); ++at) damaged[at] = '\x55';
  const std::string path = folder_ / "damaged.exr";
  test::put(path, damaged);
  ASSERT_FALSE(read_exr(path).ok());
  for (const auto& [a, b] : {std::pair{path, a_}, {a_, path}}) {
    const Outcome outcome = run({a, b});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("16x12"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("20x12"), std::string::npos) << outcome.err;
  }
}

TEST_F(CompareCommand, BadArgumentsAreNotRun) {
  EXPECT_EQ(run({a_}).exit_code, 2);
  EXPECT_EQ(run({a_, b_, "--difference", "d.jpg"}).exit_code, 2);
  EXPECT_EQ(run({a_, b_, "--scale", "0"}).exit_code, 2);
  EXPECT_EQ(run({a_, b_, "--min-psnr", "high"}).exit_code, 2);
}

}  // namespace
}  // namespace swept
