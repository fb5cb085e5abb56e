// Normals of meshes (model section 15): made by angles, or the file's.
#include "splat/io/mesh_normals.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "splat/io/cloud_source.h"
#include "splat/io/mesh_creases.h"
#include "splat/io/scene_file.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Points of a cube, and its faces; each cut along the one or the other diagonal.
std::vector<Vector3d> cube_points() {
  std::vector<Vector3d> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  return points;
}
constexpr std::uint32_t cube_faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                            {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
std::vector<Triangle> cube_triangles(unsigned diagonals) {
  std::vector<Triangle> triangles;
  for (unsigned f = 0; f < 6; ++f) {
    const auto& q = cube_faces[f];
    const unsigned k = diagonals >> f & 1;
    triangles.push_back({q[k], q[k + 1], q[k + 2]});
    triangles.push_back({q[k], q[k + 2], q[(k + 3) % 4]});
  }
  return triangles;
}

Vector3d normal_at(const SurfelCloud& cloud, std::size_t i, double frame) {
  const SurfelInstant at = surfel_at(cloud, i, frame);
  return at.axis_u.cross(at.axis_v).normalized();
}

TEST(MeshNormals, OfACubeAreItsDiagonalsHoweverItsFacesAreCut) {
  const std::vector<Vector3d> points = cube_points();
  for (unsigned diagonals = 0; diagonals < 64; ++diagonals) {
    const std::vector<Vector3d> normals = mesh_normals(points, cube_triangles(diagonals));
    for (std::size_t i = 0; i < 8; ++i)
      EXPECT_LT((normals[i] - points[i].normalized()).norm(), 1e-15) << diagonals << ' ' << i;
  }
}

TEST(MeshNormals, AnglesWeighAndAreasDoNot) {
  // At the origin a right angle of the floor, cut in slivers, and a huge face of 45° that stands on its end.
  std::vector<Vector3d> points{{0, 0, 0}, {-1e3, 1e3, 0}, {-1e3, 0, 0}};
  std::vector<Triangle> triangles;
  for (int k = 0; k <= 30; ++k) {
    const double angle = std::pow(k / 30.0, 3.0) * std::acos(0.0);
    points.emplace_back(0.01 * std::cos(angle), 0.0, 0.01 * std::sin(angle));
    const auto last = static_cast<std::uint32_t>(points.size() - 1);
    if (k > 0) triangles.push_back({0, last - 1, last});
  }
  triangles.push_back({0, 1, 2});
  const Vector3d floor(0, -1, 0), wall(0, 0, 1);
  const Vector3d truth = (2.0 * floor + wall).normalized();
  EXPECT_LT((mesh_normals(points, triangles)[0] - truth).norm(), 1e-12);
  // However large all of it is.
  for (const double scale : {1e-160, 1e150}) {
    std::vector<Vector3d> scaled = points;
    for (Vector3d& p : scaled) p *= scale;
    EXPECT_LT((mesh_normals(scaled, triangles)[0] - truth).norm(), 1e-12) << scale;
  }
}

TEST(MeshNormals, ThereAreNoneWithoutAnAreaOrWhereTrianglesCancel) {
  const std::vector<Vector3d> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {5, 5, 5}};
  const std::vector<Vector3d> normals = mesh_normals(points, {{0, 1, 2}, {0, 2, 1}, {0, 1, 3}});
  for (const Vector3d& normal : normals) EXPECT_EQ(normal, Vector3d::Zero());
}

class MeshNormalFiles : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    const std::string path = folder_ / name;
    std::ofstream(path) << text;
    return path;
  }
  static std::string cube_text(double z_scale) {
    std::string text;
    for (const Vector3d& p : cube_points())
      text += "v " + std::to_string(p.x()) + ' ' + std::to_string(p.y()) + ' ' +
              std::to_string(z_scale * p.z()) + '\n';
    for (const auto& face : cube_faces) {
      text += 'f';
      for (const std::uint32_t corner : face) text += ' ' + std::to_string(corner + 1);
      text += '\n';
    }
    return text;
  }
  static Result<LoadedCloud> load(const std::vector<KeyFile>& files, bool by_normals = false) {
    CloudSource source;
    source.files = files;
    source.triangles = true;
    source.color_by_normals = by_normals;
    return read_cloud(source, files.front().frame, files.back().frame);
  }
  test::TemporaryFolder folder_;
};

TEST_F(MeshNormalFiles, AreMadeAtEveryKeyAndColourPoints) {
  const auto loaded =
      load({{1.0, write("a.obj", cube_text(1.0))}, {2.0, write("b.obj", cube_text(3.0))}}, true);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  for (std::size_t i = 0; i < 8; ++i) {
    const Vector3d corner = cube_points()[i].normalized();
    // A box of any proportions has three right angles at its corners.
    for (const double frame : {1.0, 1.5, 2.0})
      EXPECT_LT((normal_at(loaded->cloud, i, frame) - corner).norm(), 1e-6) << i << ' ' << frame;
    const Vector3f color = (0.5 * (corner + Vector3d::Ones())).cast<float>();
    EXPECT_LT((loaded->cloud.color[i] - color).norm(), 1e-6f);
  }
  std::string notes;
  for (const std::string& line : loaded->report.lines()) notes += line + '\n';
  EXPECT_NE(notes.find("there are no normals: those of all triangles about a point"), std::string::npos)
      << notes;
}

TEST_F(MeshNormalFiles, ACreaseAngleTakesOpenMeshAndIsNeverLeftOutInSilence) {
  CloudSource source;
  source.files = {{1.0, write("c.obj", cube_text(1.0))}};
  source.triangles = true;
  source.crease_angle = 30.0;
  const auto loaded = read_cloud(source, 1.0, 1.0);
  if (io::creases_available()) {
    ASSERT_TRUE(loaded.ok()) << loaded.error().message();
    EXPECT_EQ(loaded->cloud.size(), 24u);
  } else {
    ASSERT_FALSE(loaded.ok());
    EXPECT_EQ(loaded.error().kind, ErrorKind::unsupported);
    EXPECT_NE(loaded.error().message().find("c.obj: crease_angle: this build was made without OpenMesh"),
              std::string::npos)
        << loaded.error().message();
  }
  for (const double wrong : {-1.0, 180.5, std::nan("")}) {
    source.crease_angle = wrong;
    const auto refused = read_cloud(source, 1.0, 1.0);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().field, "crease_angle");
  }
}

TEST_F(MeshNormalFiles, AreTheFilesWhereItHasThem) {
  const std::string path =
      write("n.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
            "property float nx\nproperty float ny\nproperty float nz\nelement face 1\n"
            "property list uchar int vertex_indices\nend_header\n"
            "0 0 0 0 0.6 0.8\n1 0 0 0 0 0\n0 1 0 -2 0 0\n3 0 1 2\n");
  const auto loaded = load({{1.0, path}});
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  EXPECT_LT((normal_at(loaded->cloud, 0, 1.0) - Vector3d(0, 0.6, 0.8)).norm(), 1e-6);
  EXPECT_LT((normal_at(loaded->cloud, 1, 1.0) - Vector3d(0, 0, 1)).norm(), 1e-6) << "the file has none";
  EXPECT_LT((normal_at(loaded->cloud, 2, 1.0) - Vector3d(-1, 0, 0)).norm(), 1e-6);
  std::string notes;
  for (const std::string& line : loaded->report.lines()) notes += line + '\n';
  EXPECT_NE(notes.find("1 points have no normal"), std::string::npos) << notes;
}

TEST_F(MeshNormalFiles, OfObjAreThoseThatCornersName) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  // Before or after its faces, from the end, with places on textures or without; 3 has two, and 4 has none.
  const std::string path = write("n.obj", points +
                                              "vn 0 0 2\nvn 1 0 0\nf 1//1 2//-1 3//1\nvt 0 0\n"
                                              "f 1/1/1 3/1/3 4\nvn 0 3 0\n");
  const auto loaded = load({{1.0, path}});
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  const Vector3d z(0, 0, 1);
  EXPECT_LT((normal_at(loaded->cloud, 0, 1.0) - z).norm(), 1e-6);
  EXPECT_LT((normal_at(loaded->cloud, 1, 1.0) - Vector3d(1, 0, 0)).norm(), 1e-6);
  EXPECT_LT((normal_at(loaded->cloud, 2, 1.0) - z).norm(), 1e-6);
  EXPECT_LT((normal_at(loaded->cloud, 3, 1.0) - z).norm(), 1e-6);
  std::string notes;
  for (const std::string& line : loaded->report.lines()) notes += line + '\n';
  EXPECT_NE(notes.find("1 vertices have several vn"), std::string::npos) << notes;
  EXPECT_NE(notes.find("2 points have no normal"), std::string::npos) << notes;
  EXPECT_EQ(notes.find("lines vn"), std::string::npos) << notes;
  // Those that no face names are not used, and that is said.
  const auto unused = load({{1.0, write("u.obj", points + "vn 1 0 0\nvn 1 0 0\nf 1 2 3 4\n")}});
  ASSERT_TRUE(unused.ok());
  EXPECT_LT((normal_at(unused->cloud, 0, 1.0) - z).norm(), 1e-6);
  EXPECT_NE(unused->report.unread.size(), 0u);
}

TEST_F(MeshNormalFiles, BadOnesAreNamedByFileAndLine) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
  const auto error = [&](const std::string& rest) {
    const auto loaded = load({{1.0, write("bad.obj", points + rest)}});
    EXPECT_FALSE(loaded.ok()) << rest;
    return loaded ? std::string() : loaded.error().message();
  };
  EXPECT_NE(error("vn 0 x 1\nf 1//1 2//1 3//1\n").find("bad.obj: line 4, vn"), std::string::npos);
  EXPECT_NE(error("vn 0 1\nf 1//1 2//1 3//1\n").find("line 4, vn"), std::string::npos);
  EXPECT_NE(error("vn 0 0 1\nf 1//1 2//1 3//a\n").find("line 5, face"), std::string::npos);
  EXPECT_NE(error("vn 0 0 1\nf 1//1 2//-2 3//1\n").find("index -2 names no vn"), std::string::npos);
  EXPECT_NE(error("vn 0 0 1\nf 1//1 2//2 3//1\n").find("index 2 names none of the 1 vn"), std::string::npos);
  // Tools that leave all of them out name them for all that.
  const auto none = load({{1.0, write("none.obj", points + "f 1//1 2//2 3//3\n")}});
  ASSERT_TRUE(none.ok()) << none.error().message();
  EXPECT_EQ(std::count(none->report.assumed.begin(), none->report.assumed.end(),
                       "corners of faces name vn, and the file has none"),
            1);
  // What no triangle has may name what is not there.
  EXPECT_TRUE(load({{1.0, write("flat.obj", points + "vn 0 0 1\nf 9//1 9//1\n")}}).ok());
}

}  // namespace
}  // namespace swept
