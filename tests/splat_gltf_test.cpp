// Splats in glTF: attributes, nodes, colour spaces, and what is refused by name.
#include <cmath>

#include "splat/io/read_splats.h"
#include "splat/io/rotate_harmonics.h"
#include "tests/gltf_files.h"
#include "tests/point_files.h"

namespace {

using namespace swept;
using namespace swept_test;

/// One primitive with two splats of degree 1; parts for tests to spoil.
struct Made {
  std::string asset = R"("asset":{"version":"2.0"},"extensionsUsed":["KHR_gaussian_splatting"])";
  std::string splatting = R"("kernel":"ellipse","colorSpace":"srgb_rec709_display")";
  std::string mode = R"("mode":0,)", nodes = R"([{"mesh":0}])", more;  ///< in the primitive's extensions
  std::string attributes =
      R"("POSITION":0,"KHR_gaussian_splatting:ROTATION":1,"KHR_gaussian_splatting:SCALE":2,)"
      R"("KHR_gaussian_splatting:OPACITY":3,"KHR_gaussian_splatting:SH_DEGREE_0_COEF_0":4,)"
      R"("KHR_gaussian_splatting:SH_DEGREE_1_COEF_0":5,"KHR_gaussian_splatting:SH_DEGREE_1_COEF_1":6,)"
      R"("KHR_gaussian_splatting:SH_DEGREE_1_COEF_2":7)";
  std::vector<float> positions{1, 2, 3, -4, 5, 6}, rotations{0, 0, 0, 1, 0.5f, 0.5f, -0.5f, 0.5f},
      scales{1, 2, 3, 0.5f, 0.5f, 4}, opacities{0.25f, 1}, dc{0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f};

  [[nodiscard]] std::string bytes() const {
    std::string buffer, views, accessors;
    const auto add = [&](const std::vector<float>& numbers, const char* type, std::size_t components) {
      const std::string comma = views.empty() ? "" : ",";
      views += comma + R"({"buffer":0,"byteOffset":)" + std::to_string(buffer.size()) + R"(,"byteLength":)" +
               std::to_string(4 * numbers.size()) + "}";
      accessors += comma + R"({"bufferView":)" + std::to_string(accessor_) +
                   R"(,"componentType":5126,"type":")" + type + R"(","count":)" +
                   std::to_string(numbers.size() / components) + "}";
      for (const float number : numbers) buffer += raw(number);
      ++accessor_;
    };
    accessor_ = 0;
    add(positions, "VEC3", 3);
    add(rotations, "VEC4", 4);
    add(scales, "VEC3", 3);
    add(opacities, "SCALAR", 1);
    add(dc, "VEC3", 3);
    for (int k = 0; k < 3; ++k) {
      std::vector<float> band;
      for (int i = 0; i < 6; ++i) band.push_back(0.01f * static_cast<float>(10 * k + i + 1));
      add(band, "VEC3", 3);
    }
    const std::string json = "{" + asset + R"(,"scenes":[{"nodes":[0]}],"nodes":)" + nodes +
                             R"(,"meshes":[{"primitives":[{)" + mode + R"("attributes":{)" + attributes +
                             R"(},"extensions":{"KHR_gaussian_splatting":{)" + splatting + "}" + more +
                             R"(}}]}],"buffers":[{"byteLength":)" + std::to_string(buffer.size()) +
                             R"(}],"bufferViews":[)" + views + R"(],"accessors":[)" + accessors + "]}";
    return glb(json, buffer);
  }

 private:
  mutable int accessor_ = 0;
};

Result<LoadedSplats> read(const Made& made) { return io::read_splat_gltf("a.glb", made.bytes(), {}); }

SplatCloud cloud_of(const Made& made) {
  Result<LoadedSplats> file = read(made);
  EXPECT_TRUE(file.ok()) << file.error().message();
  if (!file.ok()) return {};
  EXPECT_TRUE(file->splats.validate().ok());
  return std::move(file->splats);
}

std::string refusal(const Made& made) {
  const Result<LoadedSplats> file = read(made);
  if (file.ok()) return "none";
  EXPECT_EQ(file.error().file, "a.glb");
  return file.error().field + ": " + file.error().reason;
}

Eigen::Matrix3d covariance(const SplatCloud& cloud, std::size_t i) {
  const Eigen::Matrix3d axes =
      cloud.rotation[i].cast<double>().toRotationMatrix() * cloud.scale[i].cast<double>().asDiagonal();
  return axes * axes.transpose();
}

/// The harmonics' sum in direction d.
Eigen::Vector3d color(const SplatCloud& cloud, std::size_t i, const Eigen::Vector3d& d) {
  const auto basis = io::harmonic_basis(d.normalized());
  const auto count = static_cast<std::size_t>(SplatCloud::coefficients(cloud.degree));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < count; ++k)
    sum += basis[k] * Eigen::Map<const Eigen::Vector3f>(&cloud.harmonics[3 * (i * count + k)]).cast<double>();
  return sum;
}

TEST(SplatGltfTest, AxesAreThoseOfTraining) {
  const SplatCloud cloud = cloud_of({});
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.degree, 1);
  EXPECT_EQ(cloud.colors, SplatColors::srgb);
  EXPECT_EQ(cloud.position[0], Eigen::Vector3d(-1, -2, 3));
  EXPECT_EQ(cloud.scale[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.opacity, (std::vector<float>{0.25f, 1.0f}));
  EXPECT_EQ(cloud.rotation[0].coeffs().cwiseAbs(), Eigen::Vector4f(0, 0, 1, 0));  // half a turn about z
  // Functions of y, z and x: the first and the last change sign.
  for (int k = 0; k < 3; ++k) {
    const auto c = static_cast<std::size_t>(k);
    EXPECT_FLOAT_EQ(cloud.harmonics[c], 0.1f * static_cast<float>(k + 1));
    EXPECT_FLOAT_EQ(cloud.harmonics[3 + c], -0.01f * static_cast<float>(k + 1));
    EXPECT_FLOAT_EQ(cloud.harmonics[6 + c], 0.01f * static_cast<float>(k + 11));
    EXPECT_FLOAT_EQ(cloud.harmonics[9 + c], -0.01f * static_cast<float>(k + 21));
  }
}

TEST(SplatGltfTest, NodesMoveTurnScaleAndStretch) {
  const SplatCloud still = cloud_of({});
  const Eigen::Matrix3d axes = Eigen::Vector3d(-1, -1, 1).asDiagonal();
  const auto expect = [&](const std::string& node, const Eigen::Matrix3d& in_gltf,
                          const Eigen::Vector3d& offset, const Eigen::Matrix3d& turn) {
    SCOPED_TRACE(node);
    Made made;
    made.nodes = "[{" + node + R"(,"mesh":0}])";
    const SplatCloud cloud = cloud_of(made);
    ASSERT_EQ(cloud.size(), 2u);
    const Eigen::Matrix3d linear = axes * in_gltf * axes, turned = axes * turn * axes;
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_TRUE(cloud.position[i].isApprox(linear * still.position[i] + axes * offset, 1e-12));
      EXPECT_TRUE(covariance(cloud, i).isApprox(linear * covariance(still, i) * linear.transpose(), 1e-5));
      for (const Eigen::Vector3d& d :
           {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.3, -2, 0.7), Eigen::Vector3d(-1, 1, 4)})
        EXPECT_LT((color(cloud, i, turned * d) - color(still, i, d)).norm(), 1e-6);
    }
  };
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d turn = Eigen::Quaterniond(0.8, 0.0, 0.6, 0.0).toRotationMatrix();
  expect(R"("translation":[1,2,3])", one, {1, 2, 3}, one);
  expect(R"("rotation":[0,0.6,0,0.8],"scale":[2,2,2])", 2.0 * turn, {0, 0, 0}, turn);
  expect(R"("scale":[-1,1,1])", Eigen::Vector3d(-1, 1, 1).asDiagonal(), {0, 0, 0},
         Eigen::Vector3d(-1, 1, 1).asDiagonal());
  expect(R"("scale":[1,3,0.5])", Eigen::Vector3d(1, 3, 0.5).asDiagonal(), {0, 0, 0}, one);
  Made made;
  made.nodes = R"([{"scale":[1,3,1],"mesh":0}])";
  EXPECT_EQ(read(made)->notes.size(), 1u);
}

TEST(SplatGltfTest, HarmonicsOfAllDegreesTurn) {
  const Eigen::Matrix3d turn = Eigen::Quaterniond(0.5, -0.1, 0.7, 0.3).normalized().toRotationMatrix();
  for (const double mirror : {1.0, -1.0}) {
    std::array<Eigen::Vector3d, io::most_harmonics> before, after;
    for (int k = 0; k < 16; ++k)
      before[static_cast<std::size_t>(k)] = Eigen::Vector3d(1.0, std::sin(7.0 * k), std::cos(3.0 * k));
    after = before;
    io::HarmonicRotation(mirror * turn).apply(after, 3);
    for (int n = 0; n < 40; ++n) {
      const Eigen::Vector3d d =
          Eigen::Vector3d(std::sin(n), std::cos(2 * n), std::sin(3 * n + 1)).normalized();
      const auto here = io::harmonic_basis(d), there = io::harmonic_basis(mirror * turn * d);
      Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;
      for (std::size_t k = 0; k < before.size(); ++k) {
        a += here[k] * before[k];
        b += there[k] * after[k];
      }
      EXPECT_LT((a - b).norm(), 1e-13);
    }
  }
}

TEST(SplatGltfTest, EveryNodeThatShowsTheMesh) {
  Made made;
  made.nodes =
      R"([{"children":[1,2],"translation":[0,0,1]},{"mesh":0},{"mesh":0,"translation":[0,1,0]},{"mesh":0}])";
  const SplatCloud cloud = cloud_of(made);
  ASSERT_EQ(cloud.size(), 4u);  // the last node is not in the scene
  EXPECT_EQ(cloud.position[0], Eigen::Vector3d(-1, -2, 4));
  EXPECT_EQ(cloud.position[2], Eigen::Vector3d(-1, -3, 4));
}

TEST(SplatGltfTest, ColorSpacesAndDrafts) {
  Made made;
  made.splatting = R"("kernel":"ellipse","colorSpace":"lin_rec709_display")";
  EXPECT_EQ(cloud_of(made).colors, SplatColors::linear);
  made.splatting = R"("kernel":"ellipse")";
  EXPECT_EQ(read(made)->report.assumed.size(), 1u);
  made = {};
  made.scales = {-1, 0, 1, 2, 0, 0};
  const SplatCloud logarithms = cloud_of(made);
  ASSERT_EQ(logarithms.size(), 2u);
  EXPECT_TRUE(logarithms.scale[0].isApprox(Eigen::Vector3f(std::exp(-1.0f), 1, std::exp(1.0f)), 1e-6f));
  EXPECT_NE(read(made)->report.assumed.at(0).find("logarithms"), std::string::npos);
}

TEST(SplatGltfTest, UnknownVariantsAreRefusedByName) {
  const auto refused = [](auto spoil) {
    Made made;
    spoil(made);
    return refusal(made);
  };
  const std::string primitive = "/meshes/0/primitives/0",
                    at = primitive + "/extensions/KHR_gaussian_splatting";
  EXPECT_EQ(refused([](Made&) {}), "none");
  EXPECT_EQ(refused([](Made& m) {
              m.splatting += R"(,"extensions":{"KHR_gaussian_splatting_compression_spz_2":{"bufferView":0}})";
            }),
            at + "/extensions/KHR_gaussian_splatting_compression_spz_2: "
                 "KHR_gaussian_splatting_compression_spz_2 is not known");
  EXPECT_EQ(refused([](Made& m) { m.more = R"(,"KHR_spz_gaussian_splats_compression":{})"; }),
            primitive +
                "/extensions/KHR_spz_gaussian_splats_compression: KHR_spz_gaussian_splats_compression is not "
                "known");
  EXPECT_EQ(refused([](Made& m) { m.asset += R"(,"extensionsRequired":["EXT_meshopt_compression"])"; }),
            "/extensionsRequired/0: the file requires EXT_meshopt_compression, which is not known");
  EXPECT_EQ(refused([](Made& m) { m.splatting = R"("kernel":"customShape")"; }),
            at + "/kernel: \"customShape\" is not known; \"ellipse\" is");
  EXPECT_EQ(refused([](Made& m) { m.splatting = R"("projection":"fisheye")"; }).find(at + "/projection: "),
            0u);
  EXPECT_EQ(refused([](Made& m) { m.splatting = R"("sortingMethod":"none")"; }).find(at + "/sortingMethod: "),
            0u);
  EXPECT_EQ(refused([](Made& m) { m.splatting = R"("colorSpace":"acescg")"; }).find(at + "/colorSpace: "),
            0u);
  EXPECT_EQ(refused([](Made& m) { m.mode = R"("mode":4,)"; }),
            primitive + ": must be of points, mode 0, to hold splats");
  EXPECT_EQ(refused([](Made& m) { m.mode = ""; }), primitive + ": must be of points, mode 0, to hold splats");
}

TEST(SplatGltfTest, WhatIsWrongIsNamed) {
  const auto refused = [](auto spoil) {
    Made made;
    spoil(made);
    return refusal(made);
  };
  const std::string at = "/meshes/0/primitives/0/attributes";
  const auto replace = [](Made& m, const std::string& from, const std::string& to) {
    m.attributes.replace(m.attributes.find(from), from.size(), to);
  };
  EXPECT_EQ(refused([&](Made& m) { replace(m, "KHR_gaussian_splatting:SCALE", "_SCALE"); }),
            at + ": the key \"KHR_gaussian_splatting:SCALE\" is missing");
  EXPECT_EQ(
      refused([&](Made& m) { replace(m, "DEGREE_1_COEF_1", "DEGREE_1_COEF_3"); }).find(at + ": the key"), 0u);
  EXPECT_EQ(refused([&](Made& m) {
              replace(m, "DEGREE_1_COEF_0", "DEGREE_2_COEF_0");
              replace(m, "DEGREE_1_COEF_1", "DEGREE_2_COEF_1");
              replace(m, "DEGREE_1_COEF_2", "DEGREE_2_COEF_2");
            }).find(at + "/KHR_gaussian_splatting:SH_DEGREE_2_COEF_0: is no"),
            0u);
  EXPECT_EQ(refused([](Made& m) { m.opacities = {0.5f}; }),
            at + "/KHR_gaussian_splatting:OPACITY: has 1 elements for 2 splats");
  EXPECT_EQ(refused([](Made& m) { m.opacities[1] = 1.5f; }),
            at + "/KHR_gaussian_splatting:OPACITY: splat 1 is 1.5, must lie in [0, 1]");
  EXPECT_EQ(refused([](Made& m) { m.positions[4] = NAN; }).find(at + "/POSITION: splat 1 is nan"), 0u);
  EXPECT_EQ(
      refused([](Made& m) { m.scales[0] = INFINITY; }).find(at + "/KHR_gaussian_splatting:SCALE: splat 0"),
      0u);
  EXPECT_EQ(refused([](Made& m) { m.rotations = std::vector<float>(8, 0.0f); }),
            at + "/KHR_gaussian_splatting:ROTATION: splat 0 starts a quaternion of length zero");
  EXPECT_EQ(refused([](Made& m) { m.nodes = R"([{"mesh":1}])"; }).find("/nodes/0/mesh: names no element"),
            0u);
  EXPECT_EQ(refused([](Made& m) { m.nodes = R"([{}])"; }), "/nodes: none of the scene shows the splats");
  EXPECT_EQ(refused([](Made& m) {
              m.nodes = R"([{"mesh":0,"scale":[1e300,1,1]}])";
            }).find(at + "/POSITION: splat 0"),
            0u);
}

TEST(SplatGltfTest, ManyNodesDoNotMultiplySplatsWithoutEnd) {
  Made made;
  made.nodes = R"([{"children":[1)";
  const int count = 40'000;
  for (int i = 2; i <= count; ++i) (made.nodes += ',') += std::to_string(i);
  made.nodes += "]}";
  for (int i = 1; i <= count; ++i) made.nodes += R"(,{"mesh":0})";
  made.nodes += "]";
  EXPECT_EQ(refusal(made), "/nodes: show more splats than the buffers have bytes");
}

TEST(SplatGltfTest, EveryTruncationIsRefused) {
  const std::string whole = Made().bytes();
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(io::read_splat_gltf("a.glb", whole.substr(0, size), {}).ok()) << size;
}

}  // namespace
