// From files: whose front and back are known, and what a camera's lens is.
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "datasets/generators.h"
#include "splat/io/scene_file.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

class Files : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }

  /// Of the one object of a scene with this text in its "objects" entry.
  [[nodiscard]] std::vector<std::uint8_t> oriented(const std::string& object) const {
    auto file = scene(R"("keys": [{"eye": [0, 0, 5], "target": [0, 0, 0]}])", object);
    EXPECT_TRUE(file.ok()) << file.error().message();
    if (!file.ok()) return {9};
    const Result<const Scene*> loaded = file->scene_at(1.0, generate);
    EXPECT_TRUE(loaded.ok()) << loaded.error().message();
    if (!loaded.ok()) return {9};
    const auto& known = (*loaded)->objects.at(0).cloud.oriented;
    return {known.begin(), known.end()};
  }
  [[nodiscard]] Result<SceneFile> scene(const std::string& camera, const std::string& object = "") const {
    return scene_from_text(R"({"swept": 1, "camera": {"fov": {"axis": "vertical", "degrees": 40}, )" +
                               camera + R"(}, "objects": [)" + object + "]}",
                           folder_ / "scene.json");
  }
  [[nodiscard]] std::string field_of_bad(const std::string& camera) const {
    const Result<SceneFile> file = scene(camera);
    return file.ok() ? "none" : file.error().field;
  }

  test::TemporaryFolder folder_;
};

using Bytes = std::vector<std::uint8_t>;

TEST_F(Files, PointsWithNormalsHaveSides) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "end_header\n";
  write("all.ply", header + "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 -1\n1 1 0 0 0 1\n");
  EXPECT_EQ(oriented(R"({"source": {"file": "all.ply"}})"), (Bytes{1, 1, 1, 1}));
  EXPECT_EQ(oriented(R"({"source": {"file": "all.ply"}, "facing": "one_sided"})"), (Bytes{1, 1, 1, 1}));
  EXPECT_EQ(oriented(R"({"source": {"file": "all.ply"}, "facing": "sideless"})"), Bytes{});
  write("one.ply", header + "0 0 0 0 0 1\n1 0 0 0 0 0\n0 1 0 0 0 1\n1 1 0 0 0 1\n");
  EXPECT_EQ(oriented(R"({"source": {"file": "one.ply"}})"), (Bytes{1, 0, 1, 1}));
  write("none.xyz", "0 0 0\n1 0 0\n0 1 0\n1 1 0\n");
  EXPECT_EQ(oriented(R"({"source": {"file": "none.xyz"}})"), Bytes{});
}

TEST_F(Files, MeshesAndShapesHaveSidesAndParticlesNone) {
  write("triangle.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n5 5 5\n3 0 1 2\n");
  EXPECT_EQ(oriented(R"({"source": {"file": "triangle.off"}})"), (Bytes{1, 1, 1, 0}));
  EXPECT_EQ(oriented(R"({"source": {"generator": "sphere", "points": 3}})"), (Bytes{1, 1, 1}));
  EXPECT_EQ(oriented(R"({"source": {"generator": "sparks", "points": 3}})"), Bytes{});
}

TEST_F(Files, ALensIsRead) {
  const std::string look = R"("keys": [{"eye": [0, 0, 5], "target": [0, 0, 1]}])";
  auto file = scene(R"("lens": {"aperture": 0.5, "blades": 6, "rotation": 90, "samples": 20}, )" + look);
  ASSERT_TRUE(file.ok()) << file.error().message();
  const CameraTrack& camera = file->scene().camera;
  EXPECT_EQ(camera.aperture.radius, 0.25);
  EXPECT_EQ(camera.aperture.blades, 6);
  EXPECT_NEAR(camera.aperture.rotation_radians, M_PI / 2, 1e-12);
  EXPECT_EQ(camera.aperture.samples, 20);
  EXPECT_EQ(camera.look_ats[0].lens.focus, 4.0);  // the target's distance

  file = scene(R"("lens": {"f_number": 2, "focal_length": 0.1, "focus": 3}, "keys": [)"
               R"({"frame": 0, "eye": [0, 0, 5], "target": [0, 0, 1]},)"
               R"({"frame": 9, "eye": [0, 0, 5], "target": [0, 0, 1], "focus": 2}])");
  ASSERT_TRUE(file.ok()) << file.error().message();
  EXPECT_NEAR(file->scene().camera.aperture.radius, 0.025, 1e-15);
  EXPECT_EQ(file->scene().camera.look_ats[0].lens.focus, 3.0);
  EXPECT_EQ(file->scene().camera.look_ats[1].lens.focus, 2.0);
}

TEST_F(Files, ABadLensIsAnErrorThatNamesIt) {
  const std::string look = R"("keys": [{"eye": [0, 0, 5], "target": [0, 0, 1]}])";
  EXPECT_EQ(field_of_bad(R"("lens": {}, )" + look), "/camera/lens");
  EXPECT_EQ(field_of_bad(R"("lens": {"aperture": 1, "f_number": 2, "focal_length": 1}, )" + look),
            "/camera/lens");
  EXPECT_EQ(field_of_bad(R"("lens": {"aperture": -1}, )" + look), "/camera/lens/aperture");
  EXPECT_EQ(field_of_bad(R"("lens": {"f_number": 2}, )" + look), "/camera/lens/f_number");
  EXPECT_EQ(field_of_bad(R"("lens": {"aperture": 1, "focal_length": 2}, )" + look),
            "/camera/lens/focal_length");
  EXPECT_EQ(field_of_bad(R"("lens": {"aperture": 1, "blades": 2}, )" + look), "/camera/lens/blades");
  EXPECT_EQ(field_of_bad(R"("lens": {"aperture": 1, "focus": 0}, )" + look), "/camera/lens/focus");
  EXPECT_EQ(field_of_bad(R"("lens": {"aperture": 1, "bokeh": 0}, )" + look), "/camera/lens/bokeh");
  EXPECT_EQ(field_of_bad(R"("keys": [{"eye": [0, 0, 5], "target": [0, 0, 1], "focus": 1}])"),
            "/camera/keys/0/focus");
  EXPECT_EQ(
      field_of_bad(R"("lens": {"aperture": 1}, "keys": [{"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5,)"
                   R"( 0, 0, 0, 1]}])"),
      "/camera/keys/0");
}

}  // namespace
}  // namespace swept
