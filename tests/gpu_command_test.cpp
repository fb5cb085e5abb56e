// The GPU modes as the command offers them.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "datasets/generators.h"
#include "gpu_passes/gpu_renderer.h"
#include "splat/io/image_file.h"
#include "splat/io/scene_file.h"
#include "tests/command.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using test::content_of;
using test::Outcome;
using test::put;
using test::run_command;
using test::TemporaryFolder;

constexpr const char* small_scene = R"({
  "swept": 1,
  "film": {"width": 32, "height": 24},
  "frame": 3,
  "camera": {"fov": {"axis": "vertical", "degrees": 40},
             "keys": [{"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]}]},
  "objects": [{"name": "ball", "source": {"generator": "sphere", "points": 300},
               "transform": {"keys": [{"frame": 0, "translate": [0, 0, 0]},
                                      {"frame": 10, "translate": [5, 0, 0]}]}}]
})";

class GpuCommand : public testing::Test {
 protected:
  void SetUp() override {
    if (const Result<GpuRenderer> renderer = GpuRenderer::create(); !renderer)
      GTEST_SKIP() << renderer.error().message();
    put(folder_ / "scene.json", small_scene);
  }

  /// `prefix` goes before the command: variables, or a program that runs it.
  Outcome swept(const std::string& arguments, const std::string& prefix = "") const {
    return run_command("cd '" + (folder_ / "") + "' && " + prefix + " " SWEPT_COMMAND " " + arguments);
  }
  [[nodiscard]] bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  TemporaryFolder folder_;
};

TEST_F(GpuCommand, WritesTheImageAndStatisticsOfTheLibrary) {
  Result<SceneFile> file = read_scene_file(folder_ / "scene.json", {});
  ASSERT_TRUE(file);
  const Result<const Scene*> scene = file->scene_at(3.0, generate);
  ASSERT_TRUE(scene);
  Result<GpuRenderer> renderer = GpuRenderer::create();
  ASSERT_TRUE(renderer);
  for (const auto& [method, id, passes] :
       {std::tuple{"gpu", GpuMethod::six_pass, 6}, std::tuple{"gpu-still", GpuMethod::still, 5}}) {
    SCOPED_TRACE(method);
    const Outcome outcome =
        swept(std::string("render scene.json -o out.exr --overwrite --stats-json stats.json "
                          "--subframes 3 --method ") +
              method);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Result<Image> image = read_exr(folder_ / "out.exr");
    ASSERT_TRUE(image);
    const Result<Rendered> expected = renderer->render(**scene, {id, 3, false});
    ASSERT_TRUE(expected);
    EXPECT_EQ(image->rgba, expected->image.rgba);
    const auto stats = nlohmann::json::parse(content_of(folder_ / "stats.json"));
    EXPECT_EQ(stats["method"], method);
    EXPECT_EQ(stats["options"]["subframes"], 3);
    int timed = 0;
    for (const auto& stage : stats["frames"][0]["stages"].items())
      timed += stage.key().ends_with(", GPU") ? 1 : 0;
    EXPECT_EQ(timed, passes);
  }
}

TEST_F(GpuCommand, RefusesOptionsOfOtherMethods) {
  for (const char* options :
       {"--method abuffer --subframes 2", "--gpu 0", "--method reference --lookup-tables",
        "--method gpu-still --lookup-tables", "--method gpu-still --clamp-motion", "--method gpu --samples 4",
        "--method gpu --subframes -1", "--method gpu --subframes 65537"}) {
    EXPECT_EQ(swept(std::string("render scene.json -o out.exr ") + options).exit_code, 2) << options;
    EXPECT_FALSE(exists("out.exr")) << options;
  }
}

TEST_F(GpuCommand, FailsWithAMessageWhereThereIsNoDevice) {
  for (const auto& [options, prefix, message] :
       {std::tuple{"--gpu 4711", "", "--gpu: must be"},
        std::tuple{"", "SWEPT_GPU=none", "SWEPT_GPU: must be"},
        std::tuple{"", "__EGL_VENDOR_LIBRARY_FILENAMES=/nowhere.json", "no OpenGL 4.3 without a display"}}) {
    const Outcome outcome =
        swept(std::string("render scene.json -o out.exr --method gpu ") + options, prefix);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err;
    EXPECT_FALSE(exists("out.exr"));
  }
}

TEST_F(GpuCommand, ListsTheDevicesWithoutAScene) {
  const Outcome outcome = swept("info --gpus");
  EXPECT_EQ(outcome.exit_code, 0);
  const Result<std::vector<GpuDevice>> devices = list_gpus();
  ASSERT_TRUE(devices);
  for (const GpuDevice& device : *devices)
    EXPECT_NE(outcome.out.find(device.id + ": "), std::string::npos) << outcome.out;
  EXPECT_EQ(swept("info").exit_code, 2);
  EXPECT_EQ(swept("info scene.json --gpus").exit_code, 2);
}

TEST_F(GpuCommand, SeveralFramesAreThoseRenderedOneByOne) {
  ASSERT_EQ(swept("render scene.json -o all.#.exr --preview all.#.png --frames 5,1-4 --method gpu "
                  "--subframes 2 --stats-json all.json")
                .exit_code,
            0);
  const auto stats = nlohmann::json::parse(content_of(folder_ / "all.json"));
  ASSERT_EQ(stats["frames"].size(), 5u);
  std::size_t place = 0;
  for (const int frame : {5, 1, 2, 3, 4}) {
    SCOPED_TRACE(frame);
    const std::string number = std::to_string(frame);
    ASSERT_EQ(swept("render scene.json -o one.exr --preview one.png --overwrite --method gpu --subframes 2 "
                    "--stats-json one.json --frames " +
                    number)
                  .exit_code,
              0);
    EXPECT_EQ(content_of(folder_ / ("all." + number + ".exr")), content_of(folder_ / "one.exr"));
    EXPECT_EQ(content_of(folder_ / ("all." + number + ".png")), content_of(folder_ / "one.png"));
    const auto one = nlohmann::json::parse(content_of(folder_ / "one.json"))["frames"][0];
    const auto& of_all = stats["frames"][place++];
    EXPECT_EQ(of_all["frame"], frame);
    EXPECT_EQ(of_all["counters"], one["counters"]);
    EXPECT_EQ(of_all["effects"], one["effects"]);
    EXPECT_EQ(of_all["stages"].size(), one["stages"].size());
    EXPECT_GT(of_all["seconds"]["render"], 0.0);
    EXPECT_GT(of_all["seconds"]["write"], 0.0);
  }
}

TEST_F(GpuCommand, AFailedFrameKeepsThoseBeforeItAlsoWhenTheyAreInFlight) {
  for (const char* name : {"w.1.obj", "w.2.obj"}) put(folder_ / name, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  std::string text = small_scene;
  const std::string source = R"({"generator": "sphere", "points": 300})";
  text.replace(text.find(source), source.size(), R"({"sequence": "w.#.obj", "first": 1, "last": 4})");
  put(folder_ / "scene.json", text);
  const Outcome outcome =
      swept("render scene.json -o f.#.exr --frames 1-4 --shutter 0,0.5 --method gpu --stats-json stats.json");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("w.3.obj (frame 2)"), std::string::npos) << outcome.err;
  EXPECT_EQ(folder_.names(), (std::set<std::string>{"scene.json", "w.1.obj", "w.2.obj", "f.1.exr"}));
}

TEST_F(GpuCommand, KilledInAFrameItLeavesNoFile) {
  const Outcome outcome = swept(
      "render scene.json -o out.exr --preview out.png --method gpu --subframes 65536", "timeout -s KILL 0.5");
  EXPECT_EQ(outcome.exit_code, 137) << outcome.err;
  EXPECT_FALSE(exists("out.exr"));
  EXPECT_FALSE(exists("out.png"));
}

/// Names in the folder that contain `part`.
int count_of(const std::set<std::string>& names, const std::string& part) {
  int count = 0;
  for (const std::string& name : names) count += name.find(part) != std::string::npos ? 1 : 0;
  return count;
}

TEST_F(GpuCommand, KilledWhileItWritesItLeavesWholeFramesAlone) {
  for (const int frames_before : {0, 3}) {
    SCOPED_TRACE(frames_before);
    const TemporaryFolder out;
    const std::string scene = folder_ / "scene.json", output = out / "f.%03d.exr", size = "512x384";
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(126);
      execl(SWEPT_COMMAND, SWEPT_COMMAND, "render", scene.c_str(), "-o", output.c_str(), "--frames", "1-300",
            "--size", size.c_str(), "--method", "gpu", "--subframes", "1", nullptr);
      _exit(127);
    }
    // In the midst of a frame's file, after as many whole ones.
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    bool caught = false;
    while (!caught && std::chrono::steady_clock::now() < deadline) {
      const std::set<std::string> names = out.names();
      const int unfinished = count_of(names, ".exr.tmp");
      caught = unfinished > 0 && static_cast<int>(names.size()) - unfinished >= frames_before;
      if (!caught) std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    EXPECT_EQ(kill(child, SIGKILL), 0);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(caught);
    EXPECT_TRUE(WIFSIGNALED(status));
    const std::set<std::string> names = out.names();
    const int whole = static_cast<int>(names.size()) - count_of(names, ".tmp");
    EXPECT_GE(whole, frames_before);
    EXPECT_LT(whole, 300);
    // All of them without a gap, and each of them whole.
    for (int frame = 1; frame <= whole; ++frame) {
      const std::string name = fmt::format("f.{:03}.exr", frame);
      ASSERT_EQ(names.count(name), 1u) << name;
      const Result<Image> image = read_exr(out / name);
      ASSERT_TRUE(image) << image.error().message();
      EXPECT_EQ(image->width, 512);
    }
  }
}

}  // namespace
}  // namespace swept
