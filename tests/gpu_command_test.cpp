// The GPU modes as the command offers them.
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "datasets/generators.h"
#include "gpu_passes/gpu_renderer.h"
#include "splat/io/image_file.h"
#include "splat/io/scene_file.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using test::content_of;
using test::put;
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

struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

class GpuCommand : public testing::Test {
 protected:
  void SetUp() override {
    if (const Result<GpuRenderer> renderer = GpuRenderer::create(); !renderer)
      GTEST_SKIP() << renderer.error().message();
    put(folder_ / "scene.json", small_scene);
  }

  /// `prefix` goes before the command: variables, or a program that runs it.
  Outcome swept(const std::string& arguments, const std::string& prefix = "") const {
    const std::string line = "cd '" + (folder_ / "") + "' && " + prefix + " " SWEPT_COMMAND " " + arguments +
                             " >'" + (streams_ / "out") + "' 2>'" + (streams_ / "err") + "' </dev/null";
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content_of(streams_ / "out"),
            content_of(streams_ / "err")};
  }
  [[nodiscard]] bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  TemporaryFolder folder_, streams_;
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

TEST_F(GpuCommand, KilledInAFrameItLeavesNoFile) {
  const Outcome outcome = swept(
      "render scene.json -o out.exr --preview out.png --method gpu --subframes 65536", "timeout -s KILL 0.5");
  EXPECT_EQ(outcome.exit_code, 137) << outcome.err;
  EXPECT_FALSE(exists("out.exr"));
  EXPECT_FALSE(exists("out.png"));
}

}  // namespace
}  // namespace swept
