// Pictures laid over triangles (model section 15): how they are looked up, read, drawn and refused.
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/simd/mesh_math.h"
#include "abuffer/stochastic/stochastic.h"
#include "splat/interval/pixel_places.h"
#include "splat/io/file_bytes.h"
#include "splat/io/image_file.h"
#include "splat/io/point_file.h"
#include "splat/io/texture_file.h"
#include "splat/srgb.h"
#include "tests/drawn.h"
#include "tests/mesh_scenes.h"
#include "tests/scene_text.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

using test::add_point;
using test::psnr_db;
using test::put;
using test::sampled;
using test::SceneFiles;

Texture striped() {
  Texture texture;
  texture.width = 3;
  texture.height = 2;
  texture.texels = {{1, 0, 0, 1},          {0, 1, 0, 1}, {0, 0, 1, 1},
                    {0.5f, 0.5f, 0, 0.5f}, {0, 0, 0, 0}, {1, 1, 1, 1}};
  return texture;
}

void expect_near(const Eigen::Vector4f& a, const Eigen::Vector4f& b) {
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-6f) << a.transpose() << " and " << b.transpose();
}

TEST(Texture, HasItsTexelsInTheirMiddlesTheTopRowAbove) {
  const Texture texture = striped();
  for (int x = 0; x < 3; ++x) {
    const float u = (static_cast<float>(x) + 0.5f) / 3.0f;
    expect_near(texture.at(u, 0.75f), texture.texels[static_cast<std::size_t>(x)]);
    expect_near(texture.at(u, 0.25f), texture.texels[static_cast<std::size_t>(3 + x)]);
  }
  expect_near(texture.at(2.0f / 6.0f, 0.75f), {0.5f, 0.5f, 0.0f, 1.0f});
  expect_near(texture.at(1.0f / 6.0f, 0.5f), {0.75f, 0.25f, 0.0f, 0.75f});
}

TEST(Texture, Repeats) {
  const Texture texture = striped();
  // Between the last column and the first, between the bottom row and the top one.
  expect_near(texture.at(0.0f, 0.75f), {0.5f, 0.0f, 0.5f, 1.0f});
  expect_near(texture.at(0.5f / 3.0f, 0.0f), {0.75f, 0.25f, 0.0f, 0.75f});
  for (const float turns : {-7.0f, -1.0f, 1.0f, 12.0f})
    expect_near(texture.at(0.5f + turns, 0.6f - turns), texture.at(0.5f, 0.6f));
  // Rounding may not lead beyond the last texel.
  for (const float edge : {-1e-9f, 1.0f, std::nextafter(1.0f, 0.0f), -0.0f, 1e6f, -1e6f})
    EXPECT_TRUE(texture.at(edge, edge).allFinite()) << edge;
}

Scene stage(int width = 64, int height = 48) { return test::mesh_stage(width, height, 0.5 * height / 64.0); }

/// Triangles at random, some of them through the near plane, with a texture that is transparent in places.
Scene soup(unsigned seed) {
  Scene scene = stage();
  scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  const auto channel = [&] { return static_cast<float>(uniform(0.0, 1.0)); };
  Object& object = scene.objects.emplace_back();
  Texture texture;
  texture.width = 5;
  texture.height = 4;
  for (int i = 0; i < 20; ++i) {
    const float alpha = i % 3 == 0 ? 1.0f : channel();
    texture.texels.emplace_back(alpha * channel(), alpha * channel(), alpha * channel(), alpha);
  }
  object.texture = std::make_shared<const Texture>(texture);
  for (std::uint32_t t = 0; t < 80; ++t) {
    const Eigen::Vector3d middle(uniform(-2.0, 2.0), uniform(-1.5, 1.5), uniform(-0.2, 6.0));
    const double size = std::pow(10.0, uniform(-1.5, 0.3)), reach = std::pow(10.0, uniform(-1.0, 0.5));
    TextureCorners corners;
    for (std::size_t i = 0; i < 3; ++i) {
      add_point(object,
                middle + Eigen::Vector3d(uniform(-size, size), uniform(-size, size), uniform(-size, size)),
                {channel(), channel(), channel()});
      object.cloud.velocity.emplace_back(channel() - 0.5f, channel() - 0.5f, channel() - 0.5f);
      object.cloud.opacity.push_back(channel());
      corners[i] = Eigen::Vector2d(uniform(-reach, reach), uniform(-reach, reach)).cast<float>();
    }
    object.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    object.texture_corners.push_back(corners);
  }
  return scene;
}

TEST(Textures, AreTheReference) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Scene scene = soup(seed);
    Result<Rendered> truth = render_reference(scene, {4, ReferenceMotion::smooth});
    ASSERT_TRUE(truth.ok()) << truth.error().message();
    EXPECT_GT(psnr_db(sampled(scene, 4), truth->image), 105.0) << seed;
  }
}

/// In the exact method what a place sees is integrated from texel to texel.
TEST(Textures, AreExactOverTime) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Scene scene = soup(seed);
    scene.film = {32, 24, 0, 0, 0, 0};
    // Among others every place is looked at many times.
    if (seed >= 3) scene.film = {16, 12, 0, 0, 0, 0};
    if (seed == 3) scene.objects.push_back(soup(9).objects[0]);
    if (seed == 4) {
      Object& discs = scene.objects.emplace_back();
      for (int i = 0; i < 60; ++i)
        add_point(discs, {0.1 * (i % 10) - 0.5, 0.1 * (i / 10) - 0.3, 3.0}, {0.2f, 0.9f, 0.4f});
      discs.cloud.velocity.assign(60, {0.3f, 0.1f, 0.0f});
    }
    const Result<Rendered> exact = render_abuffer(scene, {});
    ASSERT_TRUE(exact.ok()) << exact.error().message();
    const double db = psnr_db(exact->image, sampled(scene, 256));
    std::printf("seed %u: %.1f dB\n", seed, db);
    EXPECT_GT(db, 70.0) << seed;
  }
}

/// Hundreds of texels pass every pixel while the shutter is open: black and white in turn are grey.
TEST(Textures, AreFilteredAlongTheWay) {
  Scene scene = stage(16, 12);
  Object& object = scene.objects.emplace_back();
  for (const auto& [x, y] : {std::pair{-30.0, -30.0}, {30.0, -30.0}, {30.0, 30.0}, {-30.0, 30.0}})
    add_point(object, {x, y, 4.0}, {1, 1, 1});
  object.cloud.velocity.assign(4, {10.0f, 0.0f, 0.0f});
  object.triangles = {{0, 1, 2}, {0, 2, 3}};
  Texture texture;
  texture.width = 2, texture.height = 1;
  texture.texels = {{0, 0, 0, 1}, {1, 1, 1, 1}};
  object.texture = std::make_shared<const Texture>(texture);
  // 25 pairs of texels to a unit of length, and 10 units pass.
  for (const Triangle& t : object.triangles) {
    TextureCorners& corners = object.texture_corners.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d& p = object.cloud.keys[0].pose.position[t[i]];
      corners[i] = Eigen::Vector2f(static_cast<float>(25.0 * p.x()), 0.5f);
    }
  }
  const Result<Rendered> exact = render_abuffer(scene, {});
  ASSERT_TRUE(exact.ok()) << exact.error().message();
  for (std::size_t i = 0; i < exact->image.pixel_count(); ++i)
    ASSERT_NEAR(exact->image.rgba[4 * i], 0.5f, 1e-5f) << i;
}

TEST(Textures, HaveTheSameBitsWithEveryInstructionSet) {
  const Scene scene = soup(9);
  const Image first = sampled(scene, 3, 0);
  for (std::size_t i = 1; i < mesh_maths().count; ++i)
    EXPECT_EQ(sampled(scene, 3, static_cast<int>(i)).rgba, first.rgba) << mesh_maths().first[i].name;
}

/// A wall that goes back from z = 2 on the left to z = 6 on the right, with u along it: what is seen of a
/// ramp is the u at which the ray meets it, and that is not even across the film.
TEST(Textures, AreSeenInPerspective) {
  Scene scene = stage();
  scene.shutter = {0.0, 0.0};
  Object& wall = scene.objects.emplace_back();
  const Eigen::Vector3d left(-1.5, 0, 2), right(1.5, 0, 6);
  for (const auto& [at, y] : {std::pair{left, 9.0}, {right, 9.0}, {right, -9.0}, {left, -9.0}})
    add_point(wall, at + Eigen::Vector3d(0, y, 0), Eigen::Vector3f::Ones());
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  wall.texture_corners = {{Eigen::Vector2f(0, 0), Eigen::Vector2f(1, 0), Eigen::Vector2f(1, 1)},
                          {Eigen::Vector2f(0, 0), Eigen::Vector2f(1, 1), Eigen::Vector2f(0, 1)}};
  Texture ramp;
  ramp.width = 512;
  ramp.height = 1;
  for (int i = 0; i < ramp.width; ++i) {
    const float value = (static_cast<float>(i) + 0.5f) / 512.0f;
    ramp.texels.emplace_back(value, value, value, 1.0f);
  }
  wall.texture = std::make_shared<const Texture>(ramp);
  const Image image = sampled(scene, 1);
  ASSERT_EQ(image.rgba.size(), 4u * 64u * 48u);
  int seen = 0;
  for (int x = 2; x < 62; ++x) {
    double mean = 0.0;
    bool inside = true;
    for (int k = 0; k < pixel_places; ++k) {
      const double slope = (x + 0.5 + double{places_in_pixel.x[k]} - 32.0) / 64.0;
      // left + u (right − left) on the ray: x = slope · z.
      const double u =
          (slope * left.z() - left.x()) / ((right.x() - left.x()) - slope * (right.z() - left.z()));
      inside = inside && u > 0.01 && u < 0.99;
      mean += u / pixel_places;
    }
    if (!inside) continue;
    ++seen;
    EXPECT_NEAR(image.rgba[4 * static_cast<std::size_t>(24 * 64 + x)], mean, 2e-6) << x;
  }
  EXPECT_GT(seen, 20);
}

TEST(Textures, AreRefusedWhereTheyDoNotFit) {
  const auto field_of = [](const Scene& scene) {
    const Status valid = scene.validate();
    return valid ? std::string() : valid.error().field;
  };
  Scene scene = soup(1);
  EXPECT_EQ(field_of(scene), "");
  scene.objects[0].texture_corners.pop_back();
  EXPECT_EQ(field_of(scene), "/objects/0/texture_corners");
  scene = soup(1);
  scene.objects[0].texture_corners[2][1].x() = std::nanf("");
  EXPECT_EQ(field_of(scene), "/objects/0/texture_corners/2");
  scene = soup(1);
  scene.objects[0].triangles.clear();
  EXPECT_EQ(field_of(scene), "/objects/0/texture");
  scene = soup(1);
  scene.objects[0].texture = nullptr;
  EXPECT_EQ(field_of(scene), "/objects/0/texture_corners");
  scene = soup(1);
  Texture broken = *scene.objects[0].texture;
  broken.texels[3].w() = 1.5f;
  scene.objects[0].texture = std::make_shared<const Texture>(broken);
  EXPECT_EQ(field_of(scene), "/objects/0/texture/texels/3");
}

class TextureFiles : public SceneFiles {
 protected:
  std::string put_picture(const std::string& name, int width = 4, int height = 2) const {
    Image image;
    image.width = image.film_width = width;
    image.height = image.film_height = height;
    for (int i = 0; i < width * height; ++i) {
      const float alpha = i % 2 == 0 ? 1.0f : 0.5f,
                  light = static_cast<float>(i) / static_cast<float>(width * height);
      for (const float value : {alpha * light, alpha * 0.25f, alpha, alpha}) image.rgba.push_back(value);
    }
    const std::string path = folder_ / name;
    const Status written = name.ends_with("exr") ? write_exr(path, image) : write_png(path, image);
    EXPECT_TRUE(written.ok()) << written.error().message();
    return path;
  }
};

TEST_F(TextureFiles, AreReadFromPngAndExr) {
  const Result<Texture> exact = read_texture(put_picture("a.exr")),
                        bytes = read_texture(put_picture("a.png"));
  ASSERT_TRUE(exact.ok()) << exact.error().message();
  ASSERT_TRUE(bytes.ok()) << bytes.error().message();
  EXPECT_EQ(exact->width, 4);
  EXPECT_EQ(exact->height, 2);
  ASSERT_EQ(bytes->texels.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    const float alpha = i % 2 == 0 ? 1.0f : 0.5f;
    expect_near(exact->texels[i], {alpha * static_cast<float>(i) / 8.0f, alpha * 0.25f, alpha, alpha});
    for (int c = 0; c < 3; ++c) {
      const float stored = linear_to_srgb(exact->texels[i][c] / alpha),
                  read = linear_to_srgb(bytes->texels[i][c] / bytes->texels[i].w());
      EXPECT_NEAR(read, stored, 0.51f / 255.0f) << i << ' ' << c;
    }
    EXPECT_NEAR(bytes->texels[i].w(), alpha, 0.51f / 255.0f);
  }
}

TEST_F(TextureFiles, ThatCannotBeReadSayWhich) {
  const std::string good = read_bytes(put_picture("a.png", 40, 30)).value();
  for (std::size_t size = 0; size < good.size(); size += 7) {
    put(folder_ / "cut.png", good.substr(0, size));
    const Result<Texture> cut = read_texture(folder_ / "cut.png");
    // What ends after the last row is whole.
    EXPECT_TRUE(!cut.ok() || size + 16 >= good.size()) << size;
    if (!cut.ok()) {
      EXPECT_EQ(cut.error().file, folder_ / "cut.png");
    }
  }
  put(folder_ / "a.jpg", "x");
  EXPECT_NE(read_texture(folder_ / "a.jpg").error().message().find(".png and .exr"), std::string::npos);
  EXPECT_EQ(read_texture(folder_ / "none.png").error().kind, ErrorKind::not_found);
  // 65,535 x 65,535 pixels in a few bytes.
  std::string bomb = good;
  bomb.replace(16, 8, std::string("\0\0\xff\xff\0\0\xff\xff", 8));
  put(folder_ / "bomb.png", bomb);
  EXPECT_FALSE(read_texture(folder_ / "bomb.png").ok());
}

ReadOptions with_texture() {
  ReadOptions options;
  options.texture = true;
  return options;
}

constexpr const char* square_obj =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.25 0.5 0\n"
    "f 1/1 2/2 3/3/1 4/-1\nf 1/5/1 3/3 4/4\n";

TEST_F(TextureFiles, ObjNamesAPlaceForEachCorner) {
  put(folder_ / "a.obj", square_obj);
  const Result<PointSet> set = read_points(folder_ / "a.obj", with_texture());
  ASSERT_TRUE(set.ok()) << set.error().message();
  ASSERT_EQ(set->texture_corners.size(), 3u);
  const Eigen::Vector2f origin(0, 0), right(1, 0), both(1, 1), top(0, 1), last(0.25f, 0.5f);
  EXPECT_EQ(set->texture_corners[0], (TextureCorners{origin, right, both}));
  EXPECT_EQ(set->texture_corners[1], (TextureCorners{origin, both, last}));
  EXPECT_EQ(set->texture_corners[2], (TextureCorners{last, both, top}));
  EXPECT_EQ(set->report.properties_of("texture coordinates"), std::vector<std::string>{"vt"});
  // Not asked for, they are left, and that is said.
  const Result<PointSet> plain = read_points(folder_ / "a.obj");
  ASSERT_TRUE(plain.ok());
  EXPECT_TRUE(plain->texture_corners.empty());
  EXPECT_EQ(plain->report.unread, std::vector<std::string>{"5 lines vt"});
}

TEST_F(TextureFiles, BadPlacesOfObjAreErrors) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\n";
  for (const auto& [rest, reason] :
       {std::pair<std::string, std::string>{"f 1/1 2 3/1\n", "corner 2 has no place"},
        {"f 1/1 2/2 3/1\n", "names none of the 1 vt"},
        {"f 1/1 2/x 3/1\n", "'x' is not a number"},
        {"f 1/1 2/-2 3/1\n", "index -2 names no vt"},
        {"vt nan 0\nf 1/1 2/1 3/1\n", "between -1e6 and 1e6"},
        {"vt\nf 1/1 2/1 3/1\n", "not a number"}}) {
    put(folder_ / "a.obj", points + rest);
    const Result<PointSet> set = read_points(folder_ / "a.obj", with_texture());
    ASSERT_FALSE(set.ok()) << rest;
    EXPECT_NE(set.error().message().find(reason), std::string::npos) << set.error().message();
    EXPECT_EQ(set.error().file, folder_ / "a.obj");
  }
}

TEST_F(TextureFiles, PlyNamesPlacesOfVerticesOrOfFaces) {
  for (const char* names : {"s t", "u v", "texture_u texture_v"}) {
    const std::string u(names, std::string(names).find(' ')), v(std::string(names).substr(u.size() + 1));
    put(folder_ / "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "property float " +
            u + "\nproperty float " + v +
            "\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0 0.5 0.25\n1 0 0 1 0\n0 1 0 0 2\n3 0 1 2\n");
    const Result<PointSet> set = read_points(folder_ / "a.ply", with_texture());
    ASSERT_TRUE(set.ok()) << set.error().message();
    ASSERT_EQ(set->texture_corners.size(), 1u);
    EXPECT_EQ(set->texture_corners[0][0], Eigen::Vector2f(0.5f, 0.25f));
    EXPECT_EQ(set->texture_corners[0][2], Eigen::Vector2f(0.0f, 2.0f));
    EXPECT_TRUE(set->report.unread.empty());
    EXPECT_EQ(read_points(folder_ / "a.ply").value().report.unread, (std::vector<std::string>{u, v}));
  }
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar float "
      "texcoord\nend_header\n"
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  put(folder_ / "b.ply", head + "4 0 1 2 3 8 0 0 1 0 1 1 0 1\n");
  const Result<PointSet> faces = read_points(folder_ / "b.ply", with_texture());
  ASSERT_TRUE(faces.ok()) << faces.error().message();
  ASSERT_EQ(faces->texture_corners.size(), 2u);
  EXPECT_EQ(faces->texture_corners[1][2], Eigen::Vector2f(0.0f, 1.0f));
  EXPECT_TRUE(faces->report.unread.empty());
  put(folder_ / "c.ply", head + "4 0 1 2 3 6 0 0 1 0 1 1\n");
  const Result<PointSet> few = read_points(folder_ / "c.ply", with_texture());
  ASSERT_FALSE(few.ok());
  EXPECT_NE(few.error().message().find("4 corners, and has 6"), std::string::npos) << few.error().message();
}

TEST_F(TextureFiles, ScenesLayThemOverMeshes) {
  put(folder_ / "a.obj", square_obj);
  put_picture("a.png");
  const std::string text =
      R"({"swept": 1, "film": {"width": 32, "height": 32}, "camera": {"fov": {"axis": "vertical",
    "degrees": 40}, "keys": [{"eye": [0.5, 0.5, 2], "target": [0.5, 0.5, 0]}]}, "objects": [{"source": {"file": "a.obj"},
    "draw": "triangles", "texture": "a.png"}]})";
  const auto none = [](const std::string&, std::size_t, const std::map<std::string, double>&) {
    return Result<SurfelCloud>(Error{"", "", "none"});
  };
  Result<SceneFile> file = read_scene_file(write(text));
  ASSERT_TRUE(file.ok()) << file.error().message();
  const Result<const Scene*> scene = file->scene_at(0.0, none);
  ASSERT_TRUE(scene.ok()) << scene.error().message();
  ASSERT_TRUE((*scene)->objects[0].texture);
  EXPECT_EQ((*scene)->objects[0].texture->width, 4);
  EXPECT_EQ((*scene)->objects[0].texture_corners.size(), 3u);

  // All methods that draw triangles draw it.
  EXPECT_TRUE(render_abuffer(**scene, {}).ok());
  EXPECT_TRUE(render_stochastic(**scene, {}).ok());

  const std::string before = file->hash(0.0).value();
  put_picture("a.png", 5, 3);
  EXPECT_NE(read_scene_file(folder_ / "scene.json").value().hash(0.0).value(), before);

  const auto error_of = [&](const std::string& changed) {
    Result<SceneFile> read = read_scene_file(write(changed, "changed.json"));
    if (!read) return read.error().message();
    const Result<const Scene*> drawn = read->scene_at(0.0, none);
    return drawn ? std::string() : drawn.error().message();
  };
  using test::replaced;
  EXPECT_NE(error_of(replaced(text, "a.png", "none.png")).find("none.png"), std::string::npos);
  EXPECT_NE(error_of(replaced(text, "\"draw\": \"triangles\", ", "")).find("/objects/0/texture"),
            std::string::npos);
  put(folder_ / "bare.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
  EXPECT_NE(error_of(replaced(text, "a.obj", "bare.obj")).find("corner 1 has no place"), std::string::npos);
  put(folder_ / "bare.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n");
  EXPECT_NE(error_of(replaced(text, "a.obj", "bare.off")).find("no texture coordinates"), std::string::npos);
}

}  // namespace
}  // namespace swept
