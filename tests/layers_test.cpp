// Normals, motion vectors and coverage against what geometry says.
#include "abuffer/layers.h"

#include <cmath>
#include <map>
#include <string>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include "abuffer/sampled.h"
#include "splat/io/image_file.h"
#include "tests/command.h"
#include "tests/small_scenes.h"
#include "tests/temporary_folder.h"
#include "tools/layer_options.h"

namespace swept {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr LayerChoice all{true, true, true};

/// The layers of one pixel of the window, by channel.
class Layers {
 public:
  explicit Layers(const Scene& scene, const LayerChoice& choice = all) : width_(scene.film.window_width()) {
    auto channels = render_layers(scene, choice);
    EXPECT_TRUE(channels.ok()) << channels.error().message();
    for (ImageChannel& channel : *channels) values_[channel.name] = std::move(channel.values);
  }
  [[nodiscard]] double at(const std::string& name, int x, int y) const {
    return static_cast<double>(values_.at(name).at(static_cast<std::size_t>(y * width_ + x)));
  }
  [[nodiscard]] Vector3d normal(int x, int y) const {
    return {at("normal.x", x, y), at("normal.y", x, y), at("normal.z", x, y)};
  }
  [[nodiscard]] Vector2d forward(int x, int y) const {
    return {at("forward.u", x, y), at("forward.v", x, y)};
  }
  [[nodiscard]] Vector2d backward(int x, int y) const {
    return {at("backward.u", x, y), at("backward.v", x, y)};
  }
  [[nodiscard]] const std::map<std::string, std::vector<float>>& values() const { return values_; }

 private:
  int width_;
  std::map<std::string, std::vector<float>> values_;
};

/// 64 × 48 px of 48 px focal length; a disc of 12 px radius in the middle, 4 before the eye.
Scene one_disc() {
  Scene scene = test::stage();
  scene.camera.look_ats.front().eye = {0, 0, 4};
  Object& object = scene.objects.emplace_back();
  test::add_disc(object, {0, 0, 0}, {0, 0, 1}, 1.0);
  return scene;
}

TEST(Layers, NormalsAreThoseOfTheSideThatIsSeen) {
  Scene scene = test::stage();
  scene.camera.look_ats.front().eye = {0, 0, 4};
  scene.objects = {test::checkered_sphere(1.0, 4000)};
  // Stretched: normals lean the other way than the surface is stretched. Mirrored: still outward.
  TransformKey key;
  key.scale = {1.0, -1.4, 1.0};
  key.rotate_radians = 0.4;
  key.rotate_axis = Vector3d::UnitZ();
  scene.objects[0].transform.keys = {key};
  const Eigen::Affine3d world = scene.objects[0].transform.at(0.0);
  const Layers layers(scene);
  std::size_t seen = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const Vector3d normal = layers.normal(x, y);
      if (layers.at("coverage", x, y) == 0.0) {
        EXPECT_EQ(normal, Vector3d::Zero());
        continue;
      }
      EXPECT_NEAR(normal.norm(), 1.0, 1e-6);
      // The ray, in the sphere's own space.
      const Vector3d ray((x + 0.5 - 32.0) / 48.0, -(y + 0.5 - 24.0) / 48.0, -1.0);
      const Vector3d o = world.inverse() * Vector3d(0, 0, 4), d = world.inverse().linear() * ray;
      const double half = o.dot(d) / d.squaredNorm(), rest = (o.squaredNorm() - 1.0) / d.squaredNorm();
      if (half * half - rest < 0.1) continue;  // the rim
      const Vector3d hit = o + (-half - std::sqrt(half * half - rest)) * d;
      const Vector3d truth = (world.linear().inverse().transpose() * hit).normalized();
      // Discs of 0.04 are flat, and several are averaged.
      EXPECT_GT(normal.dot(truth), std::cos(0.06)) << x << ' ' << y;
      ++seen;
    }
  EXPECT_GT(seen, 300u);
}

TEST(Layers, MotionIsThatOfThePointInPixelsPerFrame) {
  Scene scene = one_disc();
  scene.objects[0].cloud.velocity = {{0.5f, 0.25f, 0.0f}};
  // From the middle of the exposure, where the disc is at (0.25, 0.125): half a frame each way.
  Layers layers(scene);
  const int x = 32 + 3, y = 24 - 2;
  EXPECT_LT((layers.forward(x, y) - Vector2d(6.0, 3.0)).norm(), 1e-5) << "0.5 of 4 deep at 48 px; v is up";
  EXPECT_LT((layers.backward(x, y) + Vector2d(6.0, 3.0)).norm(), 1e-5);
  EXPECT_EQ(layers.at("coverage", x, y), 1.0);
  EXPECT_EQ(layers.at("coverage", 2, 2), 0.0);
  EXPECT_EQ(layers.forward(2, 2), Vector2d::Zero());
  // However long the shutter is open, also not at all.
  for (const double close : {0.25, 0.0}) {
    scene.shutter = {0.0, close};
    const Layers shorter(scene);
    EXPECT_LT((shorter.forward(32, 24) - Vector2d(6.0, 3.0)).norm(), 1e-4) << close;
    EXPECT_LT((shorter.backward(32, 24) + Vector2d(6.0, 3.0)).norm(), 1e-4) << close;
  }
  // A camera that moves the other way does the same.
  scene = one_disc();
  LookAtKey end = scene.camera.look_ats.front();
  end.frame = 1.0;
  end.eye -= Vector3d(0.5, 0.25, 0);
  end.target -= Vector3d(0.5, 0.25, 0);
  scene.camera.look_ats.push_back(end);
  EXPECT_LT((Layers(scene).forward(x, y) - Vector2d(6.0, 3.0)).norm(), 1e-5);
}

/// Within a disc that turns about the view, every place moves as it does itself.
TEST(Layers, MotionDiffersWithinADisc) {
  Scene scene = one_disc();
  test::move(scene.objects[0], {0, 0, 0}, {0, 0, 0}, 0.2);
  for (TransformKey& key : scene.objects[0].transform.keys) key.rotate_axis = Vector3d::UnitZ();
  const Layers layers(scene);
  const double turn = 0.1;  // from the middle to either end
  for (const auto& [x, y] : {std::pair{32, 24}, {40, 24}, {32, 16}, {25, 29}}) {
    const Vector2d from(x + 0.5 - 32.0, -(y + 0.5 - 24.0));
    const Vector2d to = Eigen::Rotation2Dd(turn) * from, back = Eigen::Rotation2Dd(-turn) * from;
    EXPECT_LT((layers.forward(x, y) - 2.0 * (to - from)).norm(), 1e-3) << x << ' ' << y;
    EXPECT_LT((layers.backward(x, y) - 2.0 * (back - from)).norm(), 1e-3) << x << ' ' << y;
  }
}

TEST(Layers, TheNearestSurfaceIsShown) {
  Scene scene = one_disc();
  test::add_disc(scene.objects[0], {0, 0, -4}, {0, 0.6, 0.8}, 8.0);
  scene.objects[0].cloud.velocity = {{1, 0, 0}, {0, 1, 0}};
  scene.frame = -0.5;  // the middle of the exposure is 0, where the discs are
  const Layers layers(scene);
  EXPECT_LT((layers.normal(32, 24) - Vector3d(0, 0, 1)).norm(), 1e-6);
  EXPECT_LT((layers.normal(32, 6) - Vector3d(0, 0.6, 0.8)).norm(), 1e-6);
  EXPECT_NEAR(layers.forward(32, 24).x(), 12.0, 1e-4);
  EXPECT_NEAR(layers.forward(32, 6).x(), 0.0, 1e-4);
  EXPECT_GT(layers.forward(32, 6).y(), 4.0);
}

/// Where there is one surface and nothing moves, coverage is alpha.
TEST(Layers, CoverageIsAlphaOfOneSurface) {
  for (const Coverage coverage : {Coverage::soft, Coverage::hard}) {
    Scene scene = one_disc();
    scene.shutter = {0.0, 0.0};
    scene.model.coverage = coverage;
    const auto still = render_sampled(scene);
    ASSERT_TRUE(still.ok());
    scene.objects[0].cloud.opacity = {0.25f};
    const Layers layers(scene);
    for (std::size_t i = 0; i < still->image.pixel_count(); ++i)
      EXPECT_NEAR(layers.values().at("coverage")[i], still->image.rgba[4 * i + 3], 1e-5) << i;
  }
}

TEST(Layers, ThreadsAndCropsChangeNoBit) {
  Scene scene = test::busy_scene();
  RenderControl one, three;
  one.threads = 1;
  three.threads = 3;
  const auto a = render_layers(scene, all, one), b = render_layers(scene, all, three);
  ASSERT_TRUE(a.ok() && b.ok());
  ASSERT_EQ(a->size(), 8u);
  scene.film.crop_x = 7;
  scene.film.crop_y = 35;
  scene.film.crop_width = 21;
  scene.film.crop_height = 11;
  const auto crop = render_layers(scene, all);
  ASSERT_TRUE(crop.ok());
  for (std::size_t c = 0; c < a->size(); ++c) {
    EXPECT_EQ((*a)[c].values, (*b)[c].values) << (*a)[c].name;
    for (std::size_t i = 0; i < (*crop)[c].values.size(); ++i)
      EXPECT_EQ((*crop)[c].values[i], (*a)[c].values[(35 + i / 21) * 64 + 7 + i % 21]) << (*a)[c].name;
  }
  EXPECT_TRUE(render_layers(scene, {})->empty());
  EXPECT_EQ(render_layers(scene, {false, false, true})->size(), 1u);
  scene.fps.numerator = 0;
  EXPECT_FALSE(render_layers(scene, all).ok());
}

/// What passes the eye has no vectors, and nothing is ever not a number.
TEST(Layers, AreNumbersWhateverMoves) {
  Scene scene = test::busy_scene();
  test::move(scene.objects[0], {0, 0, 5.2}, {0, 0, 4.4}, 3.0);
  test::move(scene.objects[1], {1e5, 0, 0}, {-1e5, 0, 1}, 3.0);
  const Layers layers(scene);
  for (const auto& [name, values] : layers.values())
    for (const float value : values) ASSERT_TRUE(std::isfinite(value)) << name;
}

TEST(Layers, SamplesAreTheInstantsOfEachPixel) {
  Scene scene = test::busy_scene();
  scene.film = {768, 192, 0, 0, 0, 0};
  auto rendered = render_sampled(scene);
  ASSERT_TRUE(rendered.ok());
  LayerOptions wanted;
  wanted.samples = true;
  add_layers(wanted, {{"own", std::vector<float>(rendered->image.pixel_count())}}, *rendered);
  ASSERT_EQ(rendered->image.channels.size(), 2u);
  const ImageChannel& channel = rendered->image.channels[1];
  EXPECT_EQ(channel.name, "samples");
  double sum = 0.0, most = 0.0, least = 1e9;
  for (const float value : channel.values) {
    sum += static_cast<double>(value);
    most = std::max(most, static_cast<double>(value));
    least = std::min(least, static_cast<double>(value));
  }
  EXPECT_DOUBLE_EQ(sum / static_cast<double>(channel.values.size()),
                   *rendered->statistics.counter("instants_per_pixel"));
  EXPECT_EQ(most, *rendered->statistics.counter("most_instants"));
  EXPECT_EQ(least, 1.0) << "sides of the film where nothing moves";
}

TEST(Layers, StandInTheFileBesideTheSamePicture) {
  const test::TemporaryFolder folder;
  test::put(folder / "scene.json",
            R"({"swept": 1, "film": {"width": 64, "height": 48}, "shutter": {"open": 0, "close": 1},
    "camera": {"fov": {"axis": "vertical", "degrees": 50}, "keys": [{"eye": [0, 0, 4], "target": [0, 0, 0]}]},
    "objects": [{"source": {"generator": "sphere", "points": 500}, "transform": {"keys": [
      {"frame": 1, "translate": [0, 0, 0]}, {"frame": 2, "translate": [0.5, 0, 0]}]}}]})");
  const auto render = [&](const std::string& output, const std::string& options) {
    return test::run_command(std::string(SWEPT_COMMAND) + " render '" + folder / "scene.json" + "' -o '" +
                             folder / output + "' " + options);
  };
  ASSERT_EQ(render("plain.exr", "").exit_code, 0);
  const test::Outcome outcome =
      render("layers.exr", "--half --layers normal,motion --layers coverage,samples,error");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  ASSERT_EQ(render("half.exr", "--half").exit_code, 0);
  const Result<Image> plain = read_exr(folder / "half.exr"), with = read_exr(folder / "layers.exr");
  ASSERT_TRUE(plain.ok() && with.ok());
  EXPECT_EQ(plain->rgba, with->rgba);

  Imf::InputFile file((folder / "layers.exr").c_str(), 0);
  std::vector<std::string> names;
  for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c)
    names.emplace_back(c.name());
  EXPECT_EQ(names, (std::vector<std::string>{"A", "B", "G", "R", "Z", "backward.u", "backward.v", "coverage",
                                             "error", "forward.u", "forward.v", "normal.x", "normal.y",
                                             "normal.z", "samples"}));
  std::vector<float> forward(64 * 48);
  Imf::FrameBuffer frame;
  frame.insert("forward.u", Imf::Slice::Make(Imf::FLOAT, forward.data(), file.header().dataWindow()));
  file.setFrameBuffer(frame);
  file.readPixels(0, 47);
  // From 3, where the sphere's front is, half a unit a frame.
  EXPECT_NEAR(forward[24 * 64 + 32 + 4], 0.5 / 3.0 * 24.0 / std::tan(25.0 * M_PI / 180.0), 0.3);
  EXPECT_NE(file.header().typedAttribute<Imf::StringAttribute>("method").value().find(
                "layers normal motion coverage samples error"),
            std::string::npos);
  // A file without them is another picture.
  EXPECT_EQ(render("plain.exr", "--layers normal --skip-existing").exit_code, 1);
  EXPECT_EQ(render("b.exr", "--layers normals").exit_code, 2);
  EXPECT_EQ(render("b.exr", "--layers samples --exact").exit_code, 2);
  EXPECT_EQ(render("b.exr", "--layers normal --exact").exit_code, 0);
}

TEST(Layers, ImagesCheckTheirChannels) {
  const test::TemporaryFolder folder;
  Image image{0, 0, 2, 1, 2, 1, std::vector<float>(8), {}};
  const auto problem = [&](std::vector<ImageChannel> channels) {
    image.channels = std::move(channels);
    const Status status = write_exr(folder / "a.exr", image);
    return status.ok() ? std::string() : status.error().field;
  };
  EXPECT_EQ(problem({{"a", {1, 2}}, {"b.c", {3, 4}}}), "");
  EXPECT_EQ(problem({{"a", {1}}}), "channels");
  EXPECT_EQ(problem({{"a", {1, 2}}, {"a", {1, 2}}}), "channels");
  EXPECT_EQ(problem({{"R", {1, 2}}}), "channels");
  EXPECT_EQ(problem({{"", {1, 2}}}), "channels");
}

}  // namespace
}  // namespace swept
