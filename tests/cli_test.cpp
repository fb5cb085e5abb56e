// The command as a user, or a render farm, meets it: exit codes, what goes to stdout, and what is left on
// disk.
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/io/image_file.h"
#include "tests/command.h"
#include "tests/sanitizers.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using nlohmann::json;
using test::content_of;
using test::Outcome;
using test::put;
using test::run_command;
using test::TemporaryFolder;

constexpr const char* small_scene = R"({
  "swept": 1,
  "film": {"width": 32, "height": 24},
  "fps": [24000, 1001],
  "frame": 3,
  "camera": {"fov": {"axis": "vertical", "degrees": 40},
             "keys": [{"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]}]},
  "objects": [{"name": "ball", "source": {"generator": "sphere", "points": 300},
               "transform": {"keys": [{"frame": 0, "translate": [0, 0, 0]},
                                      {"frame": 10, "translate": [5, 0, 0]}]}}]
})";

class Command : public ::testing::Test {
 protected:
  void SetUp() override { put(scene_, small_scene); }

  /// Runs `swept`; an argument may say {} for the test's folder.
  Outcome swept(std::vector<std::string> arguments) const {
    for (std::string& argument : arguments)
      if (const std::size_t at = argument.find("{}"); at != std::string::npos)
        argument.replace(at, 2, folder_ / "");
    return run_command(SWEPT_COMMAND, arguments);
  }

  TemporaryFolder folder_;
  const std::string scene_ = folder_ / "scene.json";
};

TEST_F(Command, AFrameThatTakesMoreMemoryThanItMayIsAnError) {
  if (SWEPT_WITH_ASAN) GTEST_SKIP() << "AddressSanitizer maps more than any bound";
  const std::vector<std::string> line = {"render", "{}scene.json", "-o", "{}a.exr", "--threads", "2"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), line.begin(), line.end());
    return swept(more);
  };
  const Outcome large = with({"--points-scale", "20000", "--max-memory", "150M"});
  EXPECT_EQ(large.exit_code, 1);
  EXPECT_NE(large.err.find("memory"), std::string::npos) << large.err;
  EXPECT_EQ(folder_.names(), std::set<std::string>{"scene.json"});
  const Outcome small = with({"--max-memory", "1G"});
  EXPECT_EQ(small.exit_code, 0) << small.err;
  EXPECT_EQ(with({"--max-memory", "lots", "--overwrite"}).exit_code, 2);
}

TEST_F(Command, BadArgumentsExitWith2AndLeaveNothing) {
  const std::vector<std::vector<std::string>> lines = {
      {},
      {"rendr"},
      {"render"},
      {"render", "{}scene.json"},
      {"render", "{}scene.json", "-o"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--no-such-option"},
      {"render", "{}scene.json", "{}scene.json", "-o", "{}a.exr"},
      {"render", "{}scene.json", "-o", "{}a.exr", "-o", "{}b.exr"},
      {"render", "{}scene.json", "-o", "{}a.png"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--preview", "{}a.exr"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--stats-json", "{}a.exr"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--size", "0x24"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--size", "32"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--size", "32x24x"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--size", "99999999999x1"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--crop", "0,0,8"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--crop", "-1,0,8,8"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--crop", "30,0,8,8"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--shutter", "0.5"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--shutter", "0.5,0"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--shutter", "0,nan"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--frames", "3-1"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--frames", "1-x"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--frames", "1-3"},
      {"render", "{}scene.json", "-o", "{}a.##.exr", "--frames", "1-3", "--preview", "{}a.png"},
      {"render", "{}scene.json", "-o", "{}a.%s.exr", "--frames", "1-3"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--method", "guess"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--exact", "--samples", "4"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--normalisation", "frame"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--normalisation", "pixel", "--method", "reference"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--reference-motion", "smooth"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--method", "reference", "--samples", "3"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--method", "reference", "--samples", "0"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--threads", "-1"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--segments", "0"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--points-scale", "0"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--points-scale", "nan"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--delta", "0"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--edge-weight", "2"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--coverage", "none"},
      {"render", "{}scene.json", "-o", "{}a.exr", "--overwrite", "--skip-existing"},
      {"info"},
      {"info", "{}scene.json", "--frame", "one"},
      {"info", "{}scene.json", "--frame", "inf"},
  };
  for (const auto& line : lines) {
    const Outcome outcome = swept(line);
    const std::string shown = ::testing::PrintToString(line);
    EXPECT_EQ(outcome.exit_code, 2) << shown << outcome.err;
    EXPECT_EQ(outcome.out, "") << shown;
    EXPECT_NE(outcome.err, "") << shown;
    EXPECT_EQ(folder_.names(), std::set<std::string>{"scene.json"}) << shown;
  }
}

TEST_F(Command, FailuresExitWith1SayWhyAndLeaveNothing) {
  const auto with = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string source = "{\"generator\": \"sphere\", \"points\": 300}";
  put(folder_ / "typo.json", with(small_scene, "\"fps\"", "\"fsp\""));
  put(folder_ / "shape.json", with(small_scene, "\"sphere\"", "\"spere\""));
  put(folder_ / "cloud.json", with(small_scene, source, "{\"file\": \"none.ply\"}"));
  put(folder_ / "torn.json", with(small_scene, source, "{\"file\": \"torn.ply\"}"));
  put(folder_ / "torn.ply",
      "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
      "property float x\nproperty float y\nproperty float z\nend_header\n");
  put(folder_ / "old.exr", "old");
  put(folder_ / "old.json", "old");
  std::filesystem::create_directory(folder_ / "folder.exr");
  const std::set<std::string> before = folder_.names();
  struct Failure {
    std::vector<std::string> line;
    const char* reason;
  };
  const std::vector<Failure> failures = {
      {{"render", "{}none.json", "-o", "{}a.exr"}, "none.json: cannot open"},
      {{"render", "{}", "-o", "{}a.exr"}, "is a folder"},
      {{"render", "{}typo.json", "-o", "{}a.exr"}, "/fsp: unknown key; did you mean \"fps\"?"},
      {{"render", "{}shape.json", "-o", "{}a.exr"}, "/objects/0/source/generator"},
      {{"render", "{}cloud.json", "-o", "{}a.exr"}, "/objects/0/source/file: there is no file"},
      {{"render", "{}cloud.json", "--dry-run"}, "/objects/0/source/file: there is no file"},
      {{"render", "{}torn.json", "-o", "{}a.exr", "--stats-json", "{}a.json"}, "torn.ply"},
      {{"render", "{}scene.json", "-o", "{}old.exr"}, "old.exr: exists"},
      {{"render", "{}scene.json", "-o", "{}old.exr", "--dry-run"}, "old.exr: exists"},
      {{"render", "{}scene.json", "-o", "{}a.exr", "--stats-json", "{}old.json"}, "old.json: exists"},
      {{"render", "{}scene.json", "-o", "{}a.exr", "--stats-json", "{}scene.json", "--overwrite"},
       "scene file"},
      {{"render", "{}scene.json", "-o", "{}folder.exr", "--overwrite"}, "is a folder"},
      {{"render", "{}scene.json", "-o", "{}none/a.exr"}, "none/a.exr"},
      {{"render", "{}scene.json", "-o", "{}a.exr", "--preview", "{}none/a.png"}, "none/a.png"},
      {{"render", "{}scene.json", "-o", "{}a.exr", "--stats-json", "{}none/a.json"}, "none/a.json"},
      {{"info", "{}none.json"}, "cannot open"},
      {{"info", "{}cloud.json", "--json"}, "there is no file"},
  };
  for (const Failure& failure : failures) {
    const Outcome outcome = swept(failure.line);
    const std::string shown = ::testing::PrintToString(failure.line);
    EXPECT_EQ(outcome.exit_code, 1) << shown << outcome.err;
    EXPECT_EQ(outcome.out, "") << shown;
    EXPECT_NE(outcome.err.find(failure.reason), std::string::npos) << shown << outcome.err;
    EXPECT_EQ(folder_.names(), before) << shown;
  }
  EXPECT_EQ(content_of(folder_ / "old.exr"), "old");
  EXPECT_EQ(content_of(folder_ / "old.json"), "old");
  EXPECT_EQ(content_of(scene_), small_scene);
}

TEST_F(Command, HelpAndVersionExitWith0) {
  for (const std::vector<std::string>& line :
       {std::vector<std::string>{"--help"}, {"--version"}, {"render", "--help"}, {"info", "--help"}}) {
    const Outcome outcome = swept(line);
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_NE(outcome.out, "");
    EXPECT_EQ(outcome.err, "");
  }
}

TEST_F(Command, HelpHasExamplesAndExitCodes) {
  for (const std::string command : {"render", "info", "init", "compare", "study", "completion", "schema"}) {
    const Outcome outcome = swept({command, "--help"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_NE(outcome.out.find("\n  swept " + command), std::string::npos) << command;
    EXPECT_NE(outcome.out.find("Exit codes: 0 done, 1 something failed, 2 bad arguments."), std::string::npos)
        << command;
  }
}

TEST_F(Command, RendersWithBothMethods) {
  for (const std::string method : {"abuffer", "reference"}) {
    const Outcome outcome =
        swept({"render", "{}scene.json", "-o", "{}" + method + ".exr", "--method", method});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find("frame 3: 1 of 1"), std::string::npos) << outcome.err;
  }
  const Result<Image> exact = read_exr(folder_ / "abuffer.exr"), mean = read_exr(folder_ / "reference.exr");
  ASSERT_TRUE(exact.ok() && mean.ok());
  EXPECT_EQ(exact->width, 32);
  EXPECT_EQ(exact->height, 24);
  // Frame 3 of 10 puts the ball 1.5 to the right: opaque there, and nothing far to the left.
  const auto alpha = [](const Image& image, int x, int y) {
    return image.rgba[4 * static_cast<std::size_t>(y * image.width + x) + 3];
  };
  for (const Image* image : {&*exact, &*mean}) {
    EXPECT_GT(alpha(*image, 25, 12), 0.99f);
    EXPECT_EQ(alpha(*image, 2, 12), 0.0f);
  }
}

TEST_F(Command, CropSizeAndThreadsChangeNoPixel) {
  ASSERT_EQ(swept({"render", "{}scene.json", "-o", "{}whole.exr", "--threads", "1"}).exit_code, 0);
  ASSERT_EQ(swept({"render", "{}scene.json", "-o", "{}three.exr", "--threads", "3"}).exit_code, 0);
  ASSERT_EQ(swept({"render", "{}scene.json", "-o", "{}crop.exr", "--crop", "10,5,12,9"}).exit_code, 0);
  EXPECT_EQ(content_of(folder_ / "whole.exr"), content_of(folder_ / "three.exr"));
  const Result<Image> whole = read_exr(folder_ / "whole.exr"), crop = read_exr(folder_ / "crop.exr");
  ASSERT_TRUE(whole.ok() && crop.ok());
  EXPECT_EQ(crop->x, 10);
  EXPECT_EQ(crop->width, 12);
  EXPECT_EQ(crop->film_width, 32);
  for (int y = 0; y < 9; ++y)
    for (int i = 0; i < 4 * 12; ++i)
      EXPECT_EQ(crop->rgba[static_cast<std::size_t>(y * 4 * 12 + i)],
                whole->rgba[static_cast<std::size_t>((y + 5) * 4 * 32 + 4 * 10 + i)]);
}

TEST_F(Command, FramesSkipAndOverwrite) {
  const std::vector<std::string> line = {"render",   "{}scene.json", "-o",        "{}f.%03d.exr",
                                         "--frames", "1-5x2",        "--preview", "{}f.#.png"};
  ASSERT_EQ(swept(line).exit_code, 0);
  const std::set<std::string> all = {"scene.json", "f.001.exr", "f.003.exr", "f.005.exr",
                                     "f.1.png",    "f.3.png",   "f.5.png"};
  EXPECT_EQ(folder_.names(), all);
  const std::string rendered = content_of(folder_ / "f.001.exr");
  EXPECT_NE(rendered, content_of(folder_ / "f.003.exr"));

  std::filesystem::remove(folder_ / "f.003.exr");
  EXPECT_EQ(swept(line).exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "f.003.exr"));
  const auto rendered_at = std::filesystem::last_write_time(folder_ / "f.001.exr");

  std::vector<std::string> plan = line, skip = line, overwrite = line;
  plan.insert(plan.end(), {"--skip-existing", "--dry-run"});
  const Outcome planned = swept(plan);
  EXPECT_EQ(planned.exit_code, 0);
  EXPECT_NE(planned.out.find("frame 1: skip"), std::string::npos) << planned.out;
  EXPECT_NE(planned.out.find("frame 3: render"), std::string::npos) << planned.out;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "f.003.exr"));

  skip.push_back("--skip-existing");
  EXPECT_EQ(swept(skip).exit_code, 0);
  EXPECT_EQ(std::filesystem::last_write_time(folder_ / "f.001.exr"), rendered_at);
  EXPECT_EQ(folder_.names(), all);

  put(folder_ / "f.001.exr", "old");
  overwrite.push_back("--overwrite");
  EXPECT_EQ(swept(overwrite).exit_code, 0);
  EXPECT_EQ(content_of(folder_ / "f.001.exr"), rendered);
  EXPECT_EQ(folder_.names(), all);
}

TEST_F(Command, WhatIsNotTheFrameIsNotSkipped) {
  const std::vector<std::string> line = {"render", "{}scene.json", "-o", "{}f.#.exr", "--frames", "1-2"};
  const auto with = [&](std::initializer_list<std::string> more) {
    std::vector<std::string> longer = line;
    longer.insert(longer.end(), more);
    return swept(longer);
  };
  ASSERT_EQ(with({}).exit_code, 0);
  const std::string first = content_of(folder_ / "f.1.exr"), second = content_of(folder_ / "f.2.exr");
  struct Foreign {
    const char* name;
    std::string content;
    const char* reason;
  };
  const Result<Image> image = read_exr(folder_ / "f.1.exr");
  ASSERT_TRUE(image.ok());
  ASSERT_TRUE(write_exr(folder_ / "bare.exr", *image).ok());
  for (const Foreign& foreign : {Foreign{"text", "not an image", "no whole image"},
                                 {"torn", first.substr(0, first.size() - 1), "no whole image"},
                                 {"another frame", second, "another frame"},
                                 {"no hash", content_of(folder_ / "bare.exr"), "does not say"}}) {
    put(folder_ / "f.1.exr", foreign.content);
    const Outcome outcome = with({"--skip-existing"});
    EXPECT_EQ(outcome.exit_code, 1) << foreign.name;
    EXPECT_NE(outcome.err.find(foreign.reason), std::string::npos) << foreign.name << outcome.err;
    EXPECT_EQ(content_of(folder_ / "f.1.exr"), foreign.content) << foreign.name;
  }
  put(folder_ / "f.1.exr", first);
  EXPECT_NE(with({"--skip-existing", "--method", "reference"}).err.find("was rendered by sampled"),
            std::string::npos);
  EXPECT_EQ(with({"--skip-existing", "--delta", "4"}).exit_code, 1);
  // An empty file holds nothing.
  put(folder_ / "f.1.exr", "");
  EXPECT_EQ(with({"--skip-existing"}).exit_code, 0);
  EXPECT_EQ(content_of(folder_ / "f.1.exr"), first);
  // Threads, and what the scene says already, make no other picture.
  EXPECT_EQ(with({"--skip-existing", "--threads", "1", "--size", "32x24"}).exit_code, 0);

  // The points themselves are another scene too.
  put(folder_ / "p.xyz", "0 0 0\n0.5 0 0\n0 0.5 0\n0.5 0.5 0\n");
  std::string text = small_scene;
  const std::string source = "{\"generator\": \"sphere\", \"points\": 300}";
  put(scene_, text.replace(text.find(source), source.size(), R"({"file": "p.xyz"}, "radius": 0.1)"));
  ASSERT_EQ(with({"--overwrite"}).exit_code, 0);
  EXPECT_EQ(with({"--skip-existing"}).exit_code, 0);
  put(folder_ / "p.xyz", "0 0 0\n0.5 0 0\n0 0.5 0\n0.5 0.7 0\n");
  EXPECT_EQ(with({"--skip-existing"}).exit_code, 1);
}

TEST_F(Command, InfoAndRenderSayTheSameHash) {
  const json info = json::parse(swept({"info", "{}scene.json", "--json"}).out, nullptr, false);
  ASSERT_EQ(swept({"render", "{}scene.json", "-o", "{}a.exr", "--stats-json", "{}s.json"}).exit_code, 0);
  const Result<ExrOrigin> origin = read_exr_origin(folder_ / "a.exr");
  ASSERT_TRUE(origin.ok());
  EXPECT_EQ(info["hash"], origin->scene_hash);
  EXPECT_EQ(json::parse(content_of(folder_ / "s.json"))["frames"][0]["scene_hash"], origin->scene_hash);
  EXPECT_EQ(origin->method, "sampled to 60 dB");
}

TEST_F(Command, AFailedFrameKeepsThoseBeforeIt) {
  for (const char* name : {"w.1.obj", "w.2.obj"}) put(folder_ / name, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  std::string text = small_scene;
  const std::string source = "{\"generator\": \"sphere\", \"points\": 300}";
  text.replace(text.find(source), source.size(), R"({"sequence": "w.#.obj", "first": 1, "last": 4})");
  put(scene_, text);
  const Outcome outcome = swept({"render", "{}scene.json", "-o", "{}f.#.exr", "--frames", "1-4", "--shutter",
                                 "0,0.5", "--stats-json", "{}stats.json"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("w.3.obj (frame 2)"), std::string::npos) << outcome.err;
  EXPECT_EQ(folder_.names(), (std::set<std::string>{"scene.json", "w.1.obj", "w.2.obj", "f.1.exr"}));
}

TEST_F(Command, StatisticsAreJson) {
  const Outcome outcome = swept({"render", "{}scene.json", "-o", "{}f.#.exr", "--frames", "2,7", "--method",
                                 "reference", "--samples", "8", "--stats-json", "{}stats.json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json stats = json::parse(content_of(folder_ / "stats.json"), nullptr, false);
  ASSERT_FALSE(stats.is_discarded());
  EXPECT_EQ(stats["method"], "reference");
  EXPECT_EQ(stats["options"]["samples"], 8);
  EXPECT_EQ(stats["film"]["width"], 32);
  ASSERT_EQ(stats["frames"].size(), 2u);
  EXPECT_EQ(stats["frames"][1]["frame"], 7);
  EXPECT_EQ(stats["frames"][1]["counters"]["samples"], 8);
  EXPECT_GT(stats["frames"][0]["counters"]["fragments"], 0);
  EXPECT_GE(stats["frames"][0]["seconds"]["render"], 0.0);
}

/// The reference takes its samples at the same instants of the same linear path.
TEST_F(Command, AveragedStillsAreTheReferenceOfAsMany) {
  ASSERT_EQ(
      swept({"render", "{}scene.json", "-o", "{}a.exr", "--method", "sampled", "--samples", "6"}).exit_code,
      0);
  ASSERT_EQ(swept({"render", "{}scene.json", "-o", "{}b.exr", "--method", "reference", "--samples", "6",
                   "--reference-motion", "smooth"})
                .exit_code,
            0);
  const Outcome outcome = swept({"compare", "{}a.exr", "{}b.exr", "--min-psnr", "100"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
}

TEST_F(Command, InfoResolvesTheScene) {
  const Outcome outcome = swept({"info", "{}scene.json", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json info = json::parse(outcome.out, nullptr, false);
  ASSERT_FALSE(info.is_discarded()) << outcome.out;
  EXPECT_EQ(info["frame"], 3.0);
  EXPECT_EQ(info["fps"], (json{24000, 1001}));
  EXPECT_EQ(info["exposure_seconds"], 0.5 * 1001 / 24000);
  EXPECT_EQ(info["camera"]["forward"], (json{0, 0, -1}));
  EXPECT_EQ(info["camera"]["down"], (json{0, -1, 0}));
  EXPECT_EQ(info["camera"]["moves"], false);
  ASSERT_EQ(info["objects"].size(), 1u);
  EXPECT_EQ(info["objects"][0]["points"], 300);
  EXPECT_EQ(info["objects"][0]["object_moves"], true);
  // The generator's ball around x = 1.375 to 1.625, two units large or so.
  EXPECT_LT(info["objects"][0]["bounds"]["low"][0], 1.0);
  EXPECT_GT(info["objects"][0]["bounds"]["high"][0], 2.0);

  const Outcome still = swept({"info", "{}scene.json", "--frame", "99"});
  EXPECT_EQ(still.exit_code, 0);
  EXPECT_NE(still.out.find("nothing moves while the shutter is open"), std::string::npos) << still.out;
}

TEST_F(Command, RealSequencesCycle) {
  const char* data = std::getenv("SWEPT_DATA_DIR");
  if (data == nullptr) GTEST_SKIP() << "SWEPT_DATA_DIR is unset";
  std::string text = small_scene;
  const std::string source = "{\"generator\": \"sphere\", \"points\": 300}";
  text.replace(text.find(source), source.size(),
               "{\"sequence\": \"" + std::filesystem::absolute(data).string() +
                   "/horse/%04d.obj\", \"first\": 1, \"last\": 12, \"cycle\": true}");
  put(scene_, text);
  const Outcome outcome = swept({"info", "{}scene.json", "--json", "--frame", "12.5"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json info = json::parse(outcome.out);
  EXPECT_EQ(info["objects"][0]["points"], 8431);
  EXPECT_EQ(info["objects"][0]["keys"], 2);
  EXPECT_EQ(info["objects"][0]["points_move"], true);
}

}  // namespace
}  // namespace swept
