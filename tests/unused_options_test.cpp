// Options that change nothing are told, those that change something are not, and none is forgotten.
#include <algorithm>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/fields.h"
#include "tests/command.h"
#include "tests/temporary_folder.h"
#include "tests/unused_scenes.h"
#include "tools/render_methods.h"
#include "tools/unused_options.h"

namespace swept {
namespace {

using nlohmann::json;
using test::content_of;
using test::Outcome;
using test::put;
using test::TemporaryFolder;

class UnusedOptions : public ::testing::Test {
 protected:
  void SetUp() override {
    const json ball = {{"source", {{"generator", "sphere"}, {"points", 60}}}};
    json moving = ball;
    moving["transform"] = test::turning();
    put(folder_ / "still.json", test::unused_scene(json::array({ball})).dump());
    put(folder_ / "moving.json", test::unused_scene(json::array({moving})).dump());
    put(folder_ / "one.obj", test::one_triangle);
    put(folder_ / "mesh.json",
        test::unused_scene(
            {{{"source", {{"file", "one.obj"}}}, {"draw", "triangles"}, {"transform", test::turning()}}})
            .dump());
    const std::string head =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string discs = head + "property float radius\nend_header\n";
    put(folder_ / "key.1.ply", discs + "0 0 0 0.5\n");
    put(folder_ / "key.2.ply", discs + "1 0 0 0.5\n");
    put(folder_ / "key.3.ply", discs + "0 2 0 0.5\n");
    put(folder_ / "keys.json", test::unused_scene({{{"source", {{"sequence", "key.%d.ply"}}}}}).dump());
    std::string splat = head;
    for (const char* name : {"f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                             "rot_0", "rot_1", "rot_2", "rot_3"})
      splat += "property float " + std::string(name) + "\n";
    put(folder_ / "splat.ply", splat + "end_header\n0 0 0 1 0 1 2 -1 -1 -1 1 0 0 0\n");
    put(folder_ / "splats.json",
        test::unused_scene({{{"source", {{"file", "splat.ply"}}}, {"transform", test::turning()}}}).dump());
  }

  [[nodiscard]] Outcome render(const std::string& line, const std::string& name) const {
    return test::run_command("cd '" + folder_ / "" + "' && " SWEPT_COMMAND " render --overwrite -o " + name +
                             ".exr --stats-json " + name + ".json " + line);
  }
  [[nodiscard]] std::vector<float> pixels(const std::string& name) const {
    return test::pixels_of(folder_ / (name + ".exr"));
  }

  TemporaryFolder folder_;
};

struct Case {
  std::string option;        ///< with its value
  std::string unused, used;  ///< scenes and other options
};

const Case cases[] = {
    {"--shutter-curve gaussian", "still.json", "moving.json"},
    {"--shutter-curve gaussian", "moving.json --shutter 0,0", "moving.json"},
    {"--shutter-ramps 0.4,0.5", "moving.json", "moving.json --shutter-curve trapezoid"},
    {"--shutter-delta 1", "moving.json", "moving.json --shutter-curve gaussian"},
    {"--row-delay 0.01", "still.json", "moving.json"},
    {"--path spline", "moving.json", "keys.json --frames 2"},
    {"--motion-tolerance 50", "moving.json", "moving.json --exact"},
    {"--segments 1", "moving.json", "moving.json --exact"},
    {"--segments 1", "mesh.json --exact", "moving.json --exact"},
    {"--delta 1", "mesh.json", "moving.json"},
    {"--filter-radius 3", "mesh.json", "moving.json"},
    {"--coverage hard", "splats.json", "moving.json"},
    {"--edge-weight 0.1", "moving.json --coverage hard", "moving.json"},
    {"--depth-tolerance 0", "splats.json", "moving.json"},
    {"--splat-dilation 2", "moving.json", "splats.json"},
    {"--splat-least-alpha 0.3", "mesh.json", "splats.json"},
    {"--splat-most-alpha 0.4", "moving.json", "splats.json"},
    {"--splat-least-light 0.9", "moving.json", ""},
    {"--splat-near 20", "moving.json", "splats.json"},
    {"--splat-blending linear", "moving.json", "splats.json"},
    {"--clip-frames 9", "splats.json", ""},
    {"--points-scale 2", "mesh.json", "moving.json"},
    {"--lens-rotation 20", "moving.json --aperture 0.5 --focus 3 --max-error 40dB",
     "moving.json --aperture 0.5 --focus 3 --blades 3 --max-error 40dB"},
    {"--lens-points 9", "moving.json --aperture 0.5 --focus 3 --method stochastic --samples 16",
     "moving.json --aperture 0.5 --focus 3 --exact"},
    {"--reference-motion segments", "still.json --method reference --samples 4",
     "moving.json --method reference --samples 4 --segments 1"},
    {"--tile-bounds hulls", "moving.json --method stochastic --samples 4", ""}};

TEST_F(UnusedOptions, AreToldAndChangeNoBit) {
  for (const Case& c : cases) {
    const std::string name = c.option.substr(0, c.option.find(' '));
    const Outcome with = render(c.unused + ' ' + c.option, "with"), without = render(c.unused, "without");
    ASSERT_EQ(with.exit_code, 0) << c.option << with.err;
    ASSERT_EQ(without.exit_code, 0) << c.option << without.err;
    EXPECT_NE(with.err.find("note: " + name + " changes nothing: "), std::string::npos)
        << c.option << ' ' << c.unused << '\n'
        << with.err;
    EXPECT_EQ(without.err.find("changes nothing"), std::string::npos) << c.option << without.err;
    EXPECT_NE(content_of(folder_ / "with.json").find(name + " changes nothing: "), std::string::npos);
    if (name == "--lens-rotation") continue;  // it turns the points that a round lens is looked through, too
    const std::vector<float> a = pixels("with"), b = pixels("without");
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0) << c.option << ' ' << c.unused;
  }
}

TEST_F(UnusedOptions, AreNotToldOfOptionsThatChangeThePicture) {
  for (const Case& c : cases) {
    if (c.used.empty()) continue;
    const Outcome with = render(c.used + ' ' + c.option, "with"), without = render(c.used, "without");
    ASSERT_EQ(with.exit_code, 0) << c.option << with.err;
    ASSERT_EQ(without.exit_code, 0) << c.option << without.err;
    EXPECT_EQ(with.err.find("changes nothing"), std::string::npos) << c.option << with.err;
    EXPECT_NE(pixels("with"), pixels("without")) << c.option << ' ' << c.used;
  }
}

TEST_F(UnusedOptions, AreToldByInfoAndDryRunsToo) {
  const std::string at = "cd '" + folder_ / "" + "' && " SWEPT_COMMAND " ";
  const Outcome info = test::run_command(at + "info moving.json --splat-near 1 --shutter-ramps 0.1,0.1");
  EXPECT_NE(info.out.find("--splat-near changes nothing: nothing is drawn as splats"), std::string::npos)
      << info.out;
  EXPECT_NE(info.out.find("--shutter-ramps changes nothing: "), std::string::npos) << info.out;
  const Outcome dry = test::run_command(at + "render moving.json --dry-run --splat-near 1");
  EXPECT_NE(dry.err.find("--splat-near changes nothing"), std::string::npos) << dry.err;
}

TEST_F(UnusedOptions, AnErrorThatNothingSeesToIsTold) {
  const std::string lens = "moving.json --aperture 0.5 --focus 3 ", told = "no error is estimated";
  EXPECT_NE(render(lens + "--lens-points 9 --max-error 40dB", "a").err.find(told), std::string::npos);
  EXPECT_EQ(render(lens + "--max-error 40dB", "a").err.find(told), std::string::npos);
  EXPECT_EQ(render(lens + "--lens-points 9 --samples 9", "a").err.find(told), std::string::npos);
  EXPECT_EQ(render("moving.json --lens-points 9", "a").err.find(told), std::string::npos)
      << "there is no lens";
}

/// A new option has to be one or the other.
TEST_F(UnusedOptions, EveryOptionIsInTheTableOrAlwaysTells) {
  const std::set<std::string_view> always = {
      // What is in the header, or what the frame is.
      "--size", "--crop", "--overscan", "--fps", "--shutter", "--background",
      // What a method is asked to reach, which device it takes, and what it refuses where it means nothing.
      "--normalisation", "--place-intervals", "--back-faces", "--max-error", "--max-cell-error",
      "--max-seconds", "--samples", "--traversal", "--subframes", "--gpu", "--lookup-tables",
      "--clamp-motion"};
  std::set<std::string_view> known = always;
  for (const std::string_view option : options_with_needs()) {
    EXPECT_FALSE(always.contains(option)) << option;
    known.insert(option);
  }
  for (const Field& field : scene_fields()) EXPECT_TRUE(known.contains(field.option)) << field.option;
  for (const MethodOption& option : method_options()) EXPECT_TRUE(known.contains(option.name)) << option.name;
}

}  // namespace
}  // namespace swept
