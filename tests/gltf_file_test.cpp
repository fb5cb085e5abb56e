// The container of glTF: where its bytes may be, what its accessors promise, how its nodes hang together.
#include "splat/io/gltf_file.h"
#include "splat/io/guarded.h"
#include "tests/gltf_files.h"
#include "tests/point_files.h"

namespace {

using namespace swept;
using swept::io::GltfAccessor;
using swept::io::GltfFile;
using swept_test::base64;
using swept_test::glb;
using swept_test::raw;

class GltfFileTest : public swept_test::PointFiles {};

const std::string kAsset = R"("asset":{"version":"2.0"},)";

/// A document with one buffer of `bytes` and one view of all of it.
std::string document(std::size_t bytes, const std::string& accessors, const std::string& uri = "") {
  const std::string length = std::to_string(bytes);
  return "{" + kAsset + R"("buffers":[{"byteLength":)" + length + uri +
         R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + length + R"(}],"accessors":[)" + accessors +
         R"(],"wanted":0})";
}

std::string accessor(int component, const char* type, int count, const std::string& more = "") {
  return R"({"bufferView":0,"componentType":)" + std::to_string(component) + R"(,"type":")" + type +
         R"(","count":)" + std::to_string(count) + more + "}";
}

/// What the accessor holds, or the Error that stood in the way.
Result<std::vector<double>> numbers(const std::string& path, const std::string& bytes,
                                    std::string_view type) {
  return io::guarded(path, [&]() -> Result<std::vector<double>> {
    const GltfFile file(path, bytes);
    const GltfAccessor found = file.accessor(file.root().require("wanted"), type);
    std::vector<double> all;
    for (std::size_t i = 0; i < found.count(); ++i)
      for (std::size_t k = 0; k < found.components(); ++k) all.push_back(found.number(i, k));
    return all;
  });
}

/// Field and reason of the refusal.
std::string refusal(const std::string& bytes, std::string_view type = "SCALAR") {
  const Result<std::vector<double>> all = numbers("a.gltf", bytes, type);
  if (all) return "none";
  EXPECT_EQ(all.error().file, "a.gltf");
  return all.error().field + ": " + all.error().reason;
}

TEST_F(GltfFileTest, BuffersAreChunksDataAndFiles) {
  const std::string data = raw({1.5f, -2.0f, 3.0f, 4.0f, 5.0f, 6.0f});
  const std::string vectors = accessor(5126, "VEC3", 2);
  const std::vector<double> expected{1.5, -2, 3, 4, 5, 6};
  write("my data.bin", data + "more");
  const auto expect = [&](const std::string& bytes) {
    const auto found = numbers(folder_ / "a.gltf", bytes, "VEC3");
    ASSERT_TRUE(found.ok()) << found.error().message();
    EXPECT_EQ(*found, expected);
  };
  expect(glb(document(24, vectors), data));
  expect(document(24, vectors, R"(,"uri":"data:application/octet-stream;base64,)" + base64(data) + '"'));
  expect(document(24, vectors, R"(,"uri":"my%20data.bin")"));
}

TEST_F(GltfFileTest, Base64OfEveryLength) {
  for (int size = 1; size < 8; ++size) {
    const std::string data =
        std::string("\xfb\xff\x3e\x80\x01\x7f\x10").substr(0, static_cast<std::size_t>(size));
    const auto found = numbers("a.gltf",
                               document(data.size(), accessor(5121, "SCALAR", size),
                                        R"(,"uri":"data:;base64,)" + base64(data) + '"'),
                               "SCALAR");
    ASSERT_TRUE(found.ok()) << found.error().message();
    for (std::size_t k = 0; k < data.size(); ++k) EXPECT_EQ((*found)[k], static_cast<unsigned char>(data[k]));
  }
}

TEST_F(GltfFileTest, EveryTypeOfComponent) {
  const auto first = [&](int component, const std::string& data, bool normalized) {
    const auto found = numbers("a.glb",
                               glb(document(data.size(), accessor(component, "SCALAR", 1,
                                                                  normalized ? R"(,"normalized":true)" : "")),
                                   data),
                               "SCALAR");
    EXPECT_TRUE(found.ok()) << found.error().message();
    return found.ok() ? found->at(0) : -99.0;
  };
  EXPECT_EQ(first(5120, raw(std::int8_t{-128}), false), -128.0);
  EXPECT_EQ(first(5120, raw(std::int8_t{-128}), true), -1.0);
  EXPECT_EQ(first(5121, raw(std::uint8_t{255}), true), 1.0);
  EXPECT_EQ(first(5122, raw(std::int16_t{-300}), false), -300.0);
  EXPECT_EQ(first(5122, raw(std::int16_t{16384}), true), 16384.0 / 32767.0);
  EXPECT_EQ(first(5123, raw(std::uint16_t{65535}), true), 1.0);
  EXPECT_EQ(first(5125, raw(std::uint32_t{4000000000u}), false), 4e9);
  EXPECT_EQ(first(5126, raw(0.1f), false), static_cast<double>(0.1f));
}

TEST_F(GltfFileTest, StridesAndSparseElements) {
  std::string data;
  for (int i = 0; i < 4; ++i) data += raw({static_cast<float>(i), 99.0f});
  const std::size_t values_at = data.size();
  data += raw({-1.0f, -2.0f}) + raw({std::uint8_t{0}, std::uint8_t{3}});
  const std::string length = std::to_string(data.size());
  const std::string json =
      "{" + kAsset + R"("buffers":[{"byteLength":)" + length +
      R"(}],"bufferViews":[{"buffer":0,"byteLength":32,"byteStride":8},{"buffer":0,"byteOffset":)" +
      std::to_string(values_at) + R"(,"byteLength":10}],"accessors":[)" +
      accessor(5126, "SCALAR", 4,
               R"(,"sparse":{"count":2,"indices":{"bufferView":1,"byteOffset":8,"componentType":5121},)"
               R"("values":{"bufferView":1}})") +
      R"(],"wanted":0})";
  const auto found = numbers("a.glb", glb(json, data), "SCALAR");
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_EQ(*found, (std::vector<double>{-1, 1, 2, -2}));
  std::string beyond = data;
  beyond.back() = '\4';
  EXPECT_NE(refusal(glb(json, beyond)).find("has 4 among them, of 4"), std::string::npos);
}

TEST_F(GltfFileTest, WhatDoesNotFitIsRefused) {
  const std::string data = raw({1.0f, 2.0f, 3.0f});
  const auto refused = [&](const std::string& accessors, const std::string& type = "SCALAR") {
    return refusal(glb(document(12, accessors), data), type);
  };
  EXPECT_EQ(refused(accessor(5126, "SCALAR", 3)), "none");
  EXPECT_EQ(refused(accessor(5126, "SCALAR", 4)),
            "/accessors/0/count: is 4, which a bufferView of 12 bytes does not hold");
  EXPECT_EQ(refused(accessor(5126, "SCALAR", 3, R"(,"byteOffset":1)")).find("/accessors/0/count"), 0u);
  EXPECT_EQ(
      refused(accessor(5126, "SCALAR", 1, R"(,"byteOffset":9007199254740991)")).find("/accessors/0/count"),
      0u);
  EXPECT_EQ(refused(accessor(5126, "SCALAR", 0)).find("/accessors/0/count"), 0u);
  EXPECT_EQ(refused(accessor(5124, "SCALAR", 1)).find("/accessors/0/componentType"), 0u);
  EXPECT_EQ(refused(accessor(5126, "VEC2", 1)), "/accessors/0/type: is \"VEC2\", not SCALAR");
  EXPECT_EQ(refused(accessor(5126, "SCALAR", 1, R"(,"normalized":true)")).find("/accessors/0: "), 0u);
  EXPECT_EQ(refused(accessor(5121, "MAT2", 1), "MAT2").find("/accessors/0: "), 0u);
  EXPECT_EQ(refused(R"({"componentType":5126,"type":"SCALAR","count":9007199254740992})"),
            "/accessors/0/count: is 9007199254740992, and no bufferView holds them");
  EXPECT_EQ(refused("").find("/wanted: names no element of accessors"), 0u);
  EXPECT_EQ(
      refusal(glb(document(13, accessor(5126, "SCALAR", 1)), data)).find("/buffers/0/byteLength: is 13"), 0u);
  EXPECT_EQ(refusal(document(12, accessor(5126, "SCALAR", 1))),
            "/buffers/0: has no uri, and the file no binary chunk for it");
  for (const char* uri : {"http://somewhere/a.bin", "/etc/hostname", "file:a.bin", "", "data:,abc",
                          "data:;base64,A", "data:;base64,A*BB", "a%00.bin"})
    EXPECT_EQ(refusal(document(12, accessor(5126, "SCALAR", 1), R"(,"uri":")" + std::string(uri) + '"'))
                  .find("/buffers/0/uri: "),
              0u)
        << uri;
}

TEST_F(GltfFileTest, EveryTruncationAndVersionIsRefused) {
  const std::string whole = glb(document(4, accessor(5126, "SCALAR", 1)), raw(1.0f));
  ASSERT_EQ(refusal(whole), "none");
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(refusal(whole.substr(0, size)), "none") << size;
  EXPECT_NE(refusal(whole + "x"), "none");
  std::string old = whole;
  old[4] = 1;
  EXPECT_EQ(refusal(old).find("header: has version 1"), 0u);
  EXPECT_EQ(refusal(R"({"asset":{"version":"1.0"}})"), "/asset/version: is 1.0, not 2.0");
  EXPECT_EQ(refusal(R"({"asset":{"version":"2.0","minVersion":"2.1"}})"),
            "/asset/minVersion: is 2.1, not 2.0");
  EXPECT_NE(refusal(std::string(100000, '[')), "none");
}

std::string nodes_refusal(const std::string& nodes) {
  const std::string text = "{" + kAsset + "\"nodes\":" + nodes + "}";
  const Result<Done> done = io::guarded("a.gltf", [&]() -> Result<Done> {
    static_cast<void>(GltfFile("a.gltf", text).nodes());
    return Done{};
  });
  return done ? "none" : done.error().field + ": " + done.error().reason;
}

TEST_F(GltfFileTest, NodesCarryTheirChildrenAlong) {
  const std::string text = "{" + kAsset + R"("scene":1,"scenes":[{},{"nodes":[1]}],"nodes":[
      {"translation":[1,0,0]},
      {"children":[2],"rotation":[0,0,2,2],"scale":[2,2,2]},
      {"children":[0],"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,3,0,1]},
      {"translation":[9,9,9]}]})";
  const GltfFile file("a.gltf", text);
  const auto nodes = file.nodes();
  ASSERT_EQ(nodes.size(), 4u);
  const auto transforms = scene_from_nodes(nodes);
  // (1, 0, 0) up by 3, twice as large, a quarter turn about z.
  EXPECT_TRUE((transforms[0] * Eigen::Vector4d(0, 0, 0, 1)).isApprox(Eigen::Vector4d(-6, 2, 0, 1), 1e-15));
  EXPECT_EQ(file.nodes_in_scene(), (std::vector<std::size_t>{0, 1, 2}));
}

TEST_F(GltfFileTest, NodesThatAreNoTreeAreRefused) {
  EXPECT_EQ(nodes_refusal(R"([{"children":[1]},{}])"), "none");
  EXPECT_EQ(nodes_refusal(R"([{"children":[0]}])"), "/nodes/0: is its own ancestor");
  EXPECT_EQ(nodes_refusal(R"([{},{"children":[2]},{"children":[1]}])"), "/nodes/1: is its own ancestor");
  EXPECT_EQ(nodes_refusal(R"([{"children":[2]},{"children":[2]},{}])"),
            "/nodes/1/children/0: already has a parent, node 0");
  EXPECT_EQ(nodes_refusal(R"([{"children":[7]}])").find("/nodes/0/children/0: names no element"), 0u);
  EXPECT_EQ(nodes_refusal(R"([{"rotation":[0,0,0,0]}])"),
            "/nodes/0/rotation: is a quaternion of length zero");
  EXPECT_EQ(nodes_refusal(R"([{"matrix":[1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]}])"),
            "/nodes/0/matrix: is no affine transform");
}

TEST_F(GltfFileTest, ALongChainOfNodesTakesNoTime) {
  std::string nodes = "[";
  const int count = 100'000;
  for (int i = 0; i + 1 < count; ++i)
    nodes += R"({"translation":[1,0,0],"children":[)" + std::to_string(i + 1) + "]},";
  const std::string text = "{" + kAsset + "\"nodes\":" + nodes + "{}]}";
  const GltfFile file("a.gltf", text);
  const auto transforms = scene_from_nodes(file.nodes());
  EXPECT_EQ(transforms.back()(0, 3), count - 1);
  EXPECT_EQ(file.nodes_in_scene().size(), static_cast<std::size_t>(count));
}

}  // namespace
