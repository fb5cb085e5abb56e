// What the command makes of meshes: normals, layers, samples by depth, materials.
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include "splat/io/image_file.h"
#include "tests/command.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

class MeshCommand : public ::testing::Test {
 protected:
  MeshCommand() {
    test::put(folder_ / "a.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nf 1 2 3 4\n");
  }
  [[nodiscard]] test::Outcome run(const std::string& arguments) const {
    return test::run_command("cd '" + folder_ / "" + "' && " + SWEPT_COMMAND + " " + arguments);
  }
  test::TemporaryFolder folder_;
};

TEST_F(MeshCommand, WritesLayers) {
  const test::Outcome outcome =
      run("render a.obj --draw triangles -o a.exr --crop 900,500,32,24 --layers "
          "normal,motion,coverage,samples,error");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(MeshCommand, WritesSamplesByDepth) {
  const test::Outcome outcome =
      run("render a.obj --draw triangles --exact --crop 900,500,32,24 -o a.exr --deep deep.exr");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(folder_.names().count("deep.exr"), 1u);
}

TEST_F(MeshCommand, SaysWhereNormalsComeFrom) {
  const test::Outcome outcome = run("info a.obj --draw triangles");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE((outcome.out + outcome.err).find("there are no normals"), std::string::npos) << outcome.out;
}

TEST_F(MeshCommand, TakesMaterialsForColoursWhereThereAreSome) {
  const std::string render = "render a.obj --draw triangles --crop 950,530,20,20 -o a.exr --overwrite";
  const auto middle = [&]() -> Eigen::Vector3f {
    const test::Outcome outcome = run(render);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const Result<Image> image = read_exr(folder_ / "a.exr");
    if (!image) return Eigen::Vector3f::Zero();
    return Eigen::Vector3f(&image->rgba[4 * (10 * 20 + 10)]);
  };
  EXPECT_LT((middle() - Eigen::Vector3f(0.5f, 0.5f, 1.0f)).norm(), 1e-5f) << "its normal, (n + 1)/2";
  test::put(folder_ / "a.obj",
            "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nusemtl red\nf 1 2 3 4\n");
  test::put(folder_ / "a.mtl", "newmtl red\nKd 1 0 0\nNs 9\n");
  EXPECT_LT((middle() - Eigen::Vector3f(1, 0, 0)).norm(), 1e-6f);
  const test::Outcome info = run("info a.obj --draw triangles");
  EXPECT_NE((info.out + info.err).find("not read: 1 line Ns"), std::string::npos) << info.out << info.err;
  test::put(folder_ / "a.mtl", "newmtl red\nKd 1 0 blue\n");
  const test::Outcome bad = run(render);
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_NE(bad.err.find("a.mtl: line 2, Kd"), std::string::npos) << bad.err;
}

}  // namespace
}  // namespace swept
