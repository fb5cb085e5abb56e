// Materials of OBJ files: what MTL files say, what is drawn of it, and what is said where something is not.
#include "splat/io/obj_materials.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/stochastic/stochastic.h"
#include "splat/io/image_file.h"
#include "tests/drawn.h"
#include "tests/mesh_scenes.h"
#include "tests/scene_text.h"

namespace swept {
namespace {

TEST(Mtl, SaysColourOpacityAndPicture) {
  const Result<MtlFile> file =
      read_mtl("a.mtl",
               "# made by hand\nnewmtl red paint\nKd 0.5 0.25 0.125\nd 0.75\nTr 0.9\n"
               "Ns 10\nKa 1 1 1\nmap_Kd my wood.png\n\n"
               "newmtl grey\r\nKd 0.5\r\nTr 0.25\r\nillum 2\r\nNs 3\r\n"
               "newmtl plain\n"
               "newmtl b\nTr 1\nd 1\nmap_Kd -s 2 2 1 -clamp on -mm 0 1 -o 0.5 b.exr\n");
  ASSERT_TRUE(file.ok()) << file.error().message();
  ASSERT_EQ(file->materials.size(), 4u);
  EXPECT_EQ(file->materials[0].name, "red paint");
  EXPECT_EQ(file->materials[0].color, Eigen::Vector3d(0.5, 0.25, 0.125));
  EXPECT_EQ(file->materials[0].opacity, 0.75) << "d counts, wherever Tr stands";
  EXPECT_EQ(file->materials[0].color_map, "my wood.png");
  EXPECT_EQ(file->materials[1].color, Eigen::Vector3d::Constant(0.5));
  EXPECT_EQ(file->materials[1].opacity, 0.75);
  EXPECT_EQ(file->materials[2].color, Eigen::Vector3d::Ones());
  EXPECT_EQ(file->materials[2].opacity, 1.0);
  EXPECT_EQ(file->materials[3].opacity, 1.0);
  EXPECT_EQ(file->materials[3].color_map, "b.exr");
  EXPECT_EQ(file->unread,
            (std::vector<std::string>{"1 line Ka", "2 lines Ns", "1 line illum", "1 line map_Kd -clamp",
                                      "1 line map_Kd -mm", "1 line map_Kd -o", "1 line map_Kd -s"}));
}

TEST(Mtl, BadLinesAreNamedByFileAndLine) {
  const auto error = [](const std::string& text) {
    const Result<MtlFile> file = read_mtl("folder/bad.mtl", text);
    EXPECT_FALSE(file.ok()) << text;
    return file ? std::string() : file.error().message();
  };
  EXPECT_NE(error("Kd 1 1 1\n").find("folder/bad.mtl: line 1, Kd: comes before any newmtl"),
            std::string::npos);
  EXPECT_NE(error("newmtl a\n\nKd 1 x 1\n").find("line 3, Kd: 'x' is not a number"), std::string::npos);
  EXPECT_NE(error("newmtl a\nKd 1 1\n").find("line 2, Kd"), std::string::npos);
  EXPECT_NE(error("newmtl a\nKd\n").find("line 2, Kd"), std::string::npos);
  EXPECT_NE(error("newmtl a\nKd nan\n").find("line 2, Kd"), std::string::npos);
  EXPECT_NE(error("newmtl a\nKd 1e31 0 0\n").find("line 2, Kd"), std::string::npos);
  EXPECT_NE(error("newmtl a\nd 1.5\n").find("line 2, d: must lie in [0, 1]"), std::string::npos);
  EXPECT_NE(error("newmtl a\nTr\n").find("line 2, Tr"), std::string::npos);
  EXPECT_NE(error("newmtl a\nmap_Kd -clamp on\n").find("line 2, map_Kd: names no file"), std::string::npos);
}

class MaterialFiles : public test::SceneFiles {
 protected:
  static constexpr const char* camera =
      R"({"swept": 1, "film": {"width": 40, "height": 30}, "shutter": {"open": 0, "close": 1}, "camera": {"fov":
      {"axis": "vertical", "degrees": 53}, "keys": [{"eye": [0, 0, 3], "target": [0, 0, 0]}]}, "objects": [)";
  /// Three quads beside each other, of which the last has no material.
  static constexpr const char* quads =
      "mtllib one.mtl two.mtl\nv -2 -2 0\nv -0.6 -2 0\nv 0.6 -2 0\nv 2 -2 0\nv -2 2 0\nv -0.6 2 0\nv 0.6 2 "
      "0\n"
      "v 2 2 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 3 4 8 7\nusemtl red glass\nf 1 2 6 5\nusemtl wood\n"
      "f 2/1 3/2 7/3 6/4\n";

  void put(const std::string& name, const std::string& text) const { test::put(folder_ / name, text); }
  void put_picture(const std::string& name, bool clear) const {
    Image image{0, 0, 3, 2, 3, 2, {}, {}};
    for (int i = 0; i < 6; ++i) {
      const float alpha = clear ? 0.15f * static_cast<float>(i) : 1.0f;
      for (const float c : {1.0f, 0.5f, 0.2f * static_cast<float>(i % 3)}) image.rgba.push_back(alpha * c);
      image.rgba.push_back(alpha);
    }
    ASSERT_TRUE(write_exr(folder_ / name, image).ok());
  }
  void put_all() const {
    put("quads.obj", quads);
    put("one.mtl", "newmtl red glass\nKd 1 0.5 0\nd 0.5\n");
    put("two.mtl", "newmtl wood\nKd 0.5 1 1\nmap_Kd wood.exr\nnewmtl red glass\nKd 0 0 1\n");
    put_picture("wood.exr", true);
  }
  /// With what is said of it; an error is all that is said.
  Scene load(const std::string& object, std::string& said) const {
    said.clear();
    Result<SceneFile> file = read_scene_file(write(camera + object + "]}"));
    if (!file) {
      said = file.error().message();
      return {};
    }
    const auto scene = file->scene_at(0.0, test::dots);
    if (!scene) {
      said = scene.error().message();
      return {};
    }
    for (const std::string& note : file->notes()) said += note + '\n';
    return **scene;
  }
  Scene load(std::string& said) const {
    return load(R"({"source": {"file": "quads.obj"}, "draw": "triangles"})", said);
  }
  std::string hash() const {
    Result<SceneFile> file = read_scene_file(
        write(std::string(camera) + R"({"source": {"file": "quads.obj"}, "draw": "triangles"}]})"));
    const auto digits = file->hash(0.0);
    return digits ? *digits : digits.error().message();
  }
};

TEST_F(MaterialFiles, AreColoursOpacitiesAndTexturesOfFaces) {
  put_all();
  std::string said;
  const Scene scene = load(said);
  ASSERT_EQ(scene.objects.size(), 1u) << said;
  const Object& object = scene.objects[0];
  EXPECT_EQ(object.material_of, (std::vector<std::uint32_t>{0, 0, 1, 1, 2, 2}));
  ASSERT_EQ(object.materials.size(), 3u);
  EXPECT_EQ(object.materials[1].color, Eigen::Vector3f(1, 0.5f, 0)) << "of two, the first";
  EXPECT_EQ(object.materials[1].opacity, 0.5f);
  EXPECT_FALSE(object.materials[1].texture);
  ASSERT_TRUE(object.materials[2].texture);
  EXPECT_EQ(object.texture_corners[4][1], Eigen::Vector2f(1, 0));
  EXPECT_EQ(said.find("no colours"), std::string::npos) << said;
  EXPECT_NE(said.find("texture 3 x 2"), std::string::npos) << said;

  const Image image = test::sampled(scene, 1);
  const auto pixel = [&](int x) {
    return Eigen::Vector4f(&image.rgba[4 * static_cast<std::size_t>(15 * 40 + x)]);
  };
  EXPECT_LT((pixel(3) - Eigen::Vector4f(0.5f, 0.25f, 0, 0.5f)).norm(), 1e-6f);
  EXPECT_LT((pixel(36) - Eigen::Vector4f::Ones()).norm(), 1e-6f);
}

TEST_F(MaterialFiles, EveryMethodDrawsThemAsTheReference) {
  put_all();
  std::string said;
  Scene scene = load(said);
  ASSERT_EQ(scene.objects.size(), 1u) << said;
  TransformKey a, b;
  b.frame = 1.0;
  b.translate = {0.7, 0.2, 0.5};
  scene.objects[0].transform.keys = {a, b};
  scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
  const Image truth = test::reference(scene, 256);
  EXPECT_GT(test::psnr_db(test::sampled(scene, 256), truth), 90.0);
  EXPECT_GT(test::psnr_db(test::exact(scene).image, test::reference(scene, 2048)), 70.0);
  StochasticOptions many;
  many.samples = 1024;
  const Result<Rendered> stochastic = render_stochastic(scene, many);
  ASSERT_TRUE(stochastic.ok()) << stochastic.error().message();
  EXPECT_GT(test::psnr_db(stochastic->image, truth), 45.0);
  // Other materials would be seen.
  Scene white = scene;
  white.objects[0].materials[2].texture.reset();
  white.objects[0].texture_corners.clear();
  EXPECT_LT(test::psnr_db(test::sampled(white, 16), truth), 20.0);
}

TEST_F(MaterialFiles, AreReadAgainByASequenceWhereTheyChanged) {
  put_all();
  for (const char* n : {"1", "2", "3", "4", "5"}) put(std::string("quads.000") + n + ".obj", quads);
  Result<SceneFile> file = read_scene_file(
      write(std::string(camera) +
            R"({"source": {"sequence": "quads.%04d.obj", "first": 1, "last": 5}, "draw": "triangles"}]})"));
  ASSERT_TRUE(file.ok()) << file.error().message();
  std::vector<std::shared_ptr<const Texture>> textures;  // held, so that no other takes the place of one
  std::vector<float> reds;
  std::vector<std::string> notes;
  const auto look = [&](double frame) {
    const auto scene = file->scene_at(frame, test::dots);
    ASSERT_TRUE(scene.ok()) << scene.error().message();
    ASSERT_EQ((*scene)->objects[0].materials.size(), 3u);
    textures.push_back((*scene)->objects[0].materials[2].texture);
    reds.push_back((*scene)->objects[0].materials[1].color.x());
    notes.push_back("");
    for (const std::string& note : file->notes()) notes.back() += note + '\n';
  };
  look(1.0);
  file->load_ahead(2.0, test::dots);
  look(2.0);
  ASSERT_TRUE(textures[0]);
  EXPECT_EQ(textures[1], textures[0]) << "nothing changed";
  EXPECT_EQ(notes[1], notes[0]) << "and the same is said";
  // The same texels in a file with another time: it is read, as nothing says that it need not be.
  const std::filesystem::path picture(folder_ / "wood.exr");
  std::filesystem::last_write_time(picture,
                                   std::filesystem::last_write_time(picture) + std::chrono::hours(1));
  look(3.0);
  ASSERT_TRUE(textures[2]);
  EXPECT_NE(textures[2], textures[1]);
  EXPECT_EQ(textures[2]->texels, textures[1]->texels);
  put("one.mtl", "newmtl red glass\nKd 0.25 0.5 0\nd 0.5\n");
  look(4.0);
  EXPECT_EQ(reds[3], 0.25f) << "of another size";
  EXPECT_EQ(reds[2], 1.0f);
  EXPECT_EQ(textures[3], textures[2]);
  std::filesystem::remove(picture);
  EXPECT_FALSE(file->scene_at(5.0, test::dots).ok()) << "what is not there any more is not drawn";
}

TEST_F(MaterialFiles, WhatIsNotThereIsSaid) {
  put_all();
  std::string said;
  std::filesystem::remove(folder_ / "one.mtl");
  EXPECT_EQ(load(said).objects.size(), 1u) << said;
  EXPECT_NE(said.find("materials are not read: " + (folder_ / "one.mtl")), std::string::npos) << said;
  std::filesystem::remove(folder_ / "two.mtl");
  const Scene bare = load(said);
  ASSERT_EQ(bare.objects.size(), 1u) << said;
  EXPECT_TRUE(bare.objects[0].materials.empty());
  EXPECT_NE(said.find("there are no colours: white"), std::string::npos) << said;

  put_all();
  put("one.mtl", "newmtl other\nKd 1 0 0\nKs 1 1 1\n");
  put("two.mtl", "newmtl wood\nmap_Kd wood.jpg\n");
  EXPECT_EQ(load(said).objects.size(), 1u) << said;
  EXPECT_NE(said.find("map_Kd of material wood is not read"), std::string::npos) << said;
  EXPECT_NE(said.find("wood.jpg"), std::string::npos) << said;
  EXPECT_NE(said.find("no mtllib has them: materials red glass"), std::string::npos) << said;
  EXPECT_NE(said.find("one.mtl: not read: 1 line Ks"), std::string::npos) << said;
}

TEST_F(MaterialFiles, WhatIsWrongIsAnErrorByName) {
  put_all();
  std::string said;
  put("two.mtl", "newmtl wood\nmap_Kd gone.png\n");
  EXPECT_TRUE(load(said).objects.empty());
  EXPECT_NE(said.find("gone.png"), std::string::npos) << said;
  EXPECT_NE(said.find("material wood of"), std::string::npos) << said;
  put("two.mtl", "newmtl wood\nKd 1 red 0\n");
  EXPECT_TRUE(load(said).objects.empty());
  EXPECT_NE(said.find("two.mtl: line 2, Kd"), std::string::npos) << said;
  put("two.mtl", "newmtl red glass\nmap_Kd wood.exr\n");
  put("one.mtl", "");
  EXPECT_TRUE(load(said).objects.empty()) << "its faces have no vt";
  EXPECT_NE(said.find("quads.obj: face: one of material red glass has corners without a place"),
            std::string::npos)
      << said;
}

TEST_F(MaterialFiles, GiveWayToWhatTheSceneOrVerticesSay) {
  put_all();
  std::string said;
  const auto object = [&](const std::string& more) {
    Scene scene = load(R"({"source": {"file": "quads.obj"}, "draw": "triangles")" + more + "}", said);
    EXPECT_EQ(scene.objects.size(), 1u) << said;
    return scene.objects.empty() ? Object{} : scene.objects[0];
  };
  EXPECT_TRUE(object(R"(, "color": [1, 0, 0])").materials.empty());
  EXPECT_TRUE(object(R"(, "color": "normals")").materials.empty());
  put("quads.obj",
      "mtllib one.mtl\nv 0 0 0 0 1 0\nv 1 0 0 0 1 0\nv 0 1 0 0 1 0\nusemtl red glass\nf 1 2 3\n");
  const Object own = object("");
  ASSERT_EQ(own.materials.size(), 2u);
  EXPECT_EQ(own.materials[1].color, Eigen::Vector3f::Ones());
  EXPECT_EQ(own.materials[1].opacity, 0.5f);
  EXPECT_NE(said.find("vertices have colours"), std::string::npos) << said;
  // As discs the file is what it was.
  const Scene discs = load(R"({"source": {"file": "quads.obj"}})", said);
  ASSERT_EQ(discs.objects.size(), 1u) << said;
  EXPECT_TRUE(discs.objects[0].materials.empty());
}

TEST_F(MaterialFiles, TellPicturesApart) {
  put_all();
  const std::string before = hash();
  EXPECT_EQ(hash(), before);
  put("one.mtl", "newmtl red glass\nKd 1 0.5 0.1\nd 0.5\n");
  const std::string other_color = hash();
  EXPECT_NE(other_color, before);
  put_picture("wood.exr", false);
  EXPECT_NE(hash(), other_color);
}

TEST_F(MaterialFiles, SceneChecksThem) {
  put_all();
  std::string said;
  const Scene good = load(said);
  ASSERT_TRUE(good.validate().ok());
  const auto field = [&](const auto& change) {
    Scene scene = good;
    change(scene.objects[0]);
    const Status status = scene.validate();
    return status.ok() ? std::string() : status.error().field;
  };
  EXPECT_EQ(field([](Object& o) { o.material_of.pop_back(); }), "/objects/0/material_of");
  EXPECT_EQ(field([](Object& o) { o.material_of.clear(); }), "/objects/0/material_of");
  EXPECT_EQ(field([](Object& o) { o.material_of[3] = 3; }), "/objects/0/material_of/3");
  EXPECT_EQ(field([](Object& o) { o.materials[1].opacity = 1.5f; }), "/objects/0/materials/1/opacity");
  EXPECT_EQ(field([](Object& o) { o.materials[1].color.x() = NAN; }), "/objects/0/materials/1/color");
  EXPECT_EQ(field([](Object& o) { o.texture = o.materials[2].texture; }), "/objects/0/materials");
  EXPECT_EQ(field([](Object& o) { o.texture_corners.pop_back(); }), "/objects/0/texture_corners");
}

}  // namespace
}  // namespace swept
