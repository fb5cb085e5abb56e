// .sog bundles, written here by the format's description.
#include <sys/resource.h>

#include <cmath>

#include <gtest/gtest.h>

#include "splat/io/cloud_scene.h"
#include "splat/io/read_splats.h"
#include "tests/packed_bytes.h"
#include "tests/temporary_folder.h"

namespace {

using namespace swept;
using namespace swept_test;

/// The parts of a bundle, for tests to spoil.
struct Made {
  std::string count = "3", version = "\"version\":2,", more, shn;
  std::string scale_book = book(-3.0, 0.02), color_book = book(-2.0, 0.015),
              harmonic_book = book(-0.5, 0.004);
  std::string low = image(2, 2, 10), high = image(2, 2, 90), quats = image(2, 2, 40, 252),
              scales = image(2, 2, 3), colors = image(2, 2, 77, 200), centroids = image(192, 1, 5),
              labels = pixels({0, 1, 2, 63});
  bool pack = false;

  /// Bytes that go up by one from `first`, but for alpha, if it is given.
  static std::string raw(int width, int height, int first, int alpha = -1) {
    std::string rgba;
    for (int k = 0; k < 4 * width * height; ++k)
      rgba += static_cast<char>(alpha >= 0 && k % 4 == 3 ? alpha + k / 4 % 4 : first + k);
    return rgba;
  }
  static std::string image(int width, int height, int first, int alpha = -1) {
    return webp(width, height, raw(width, height, first, alpha));
  }
  static std::string pixels(const std::vector<int>& labels) {
    std::string rgba;
    for (const int label : labels) rgba += le16(static_cast<std::size_t>(label)) + std::string("\0\xff", 2);
    return webp(static_cast<int>(labels.size()) / 2, 2, rgba);
  }
  static std::string book(double first, double step) {
    std::string numbers;
    for (int k = 0; k < 256; ++k) (numbers += k > 0 ? "," : "") += std::to_string(first + step * k);
    return '[' + numbers + ']';
  }
  Made& with_harmonics() {
    shn = R"(,"shN":{"count":64,"bands":1,"codebook":)" + harmonic_book +
          R"(,"files":["shN_centroids.webp","shN_labels.webp"]})";
    return *this;
  }

  [[nodiscard]] std::string meta() const {
    return "{" + version + "\"count\":" + count + more +
           R"(,"means":{"mins":[-1,-2,0],"maxs":[1,2,3],"files":["means_l.webp","means_u.webp"]},)"
           R"("scales":{"codebook":)" +
           scale_book +
           R"(,"files":["scales.webp"]},"quats":{"files":["quats.webp"]},)"
           R"("sh0":{"codebook":)" +
           color_book + R"(,"files":["sh0.webp"]})" + shn + "}";
  }
  [[nodiscard]] std::string bytes() const {
    return zip({{"means_l.webp", low},
                {"means_u.webp", high},
                {"quats.webp", quats},
                {"scales.webp", scales},
                {"sh0.webp", colors},
                {"shN_centroids.webp", centroids},
                {"shN_labels.webp", labels},
                {"meta.json", meta()}},
               pack);
  }
};

std::string refusal(const std::string& bytes) {
  const Result<LoadedSplats> file = io::read_sog("a.sog", bytes, {});
  if (file.ok()) return "none";
  EXPECT_EQ(file.error().file, "a.sog");
  return file.error().field + ": " + file.error().reason;
}

TEST(SogTest, EveryNumberIsWhereItBelongs) {
  for (const bool pack : {false, true}) {
    Made made;
    made.pack = pack;
    made.with_harmonics();
    const Result<LoadedSplats> file = io::read_sog("a.sog", made.bytes(), {});
    ASSERT_TRUE(file.ok()) << file.error().message();
    const SplatCloud& cloud = file->splats;
    EXPECT_TRUE(cloud.validate().ok());
    ASSERT_EQ(cloud.size(), 3u);
    ASSERT_EQ(cloud.degree, 1);
    for (int i = 0; i < 3; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double low[3] = {-1, -2, 0}, high[3] = {1, 2, 3};
      for (int k = 0; k < 3; ++k) {
        const double t = (256.0 * (90 + 4 * i + k) + 10 + 4 * i + k) / 65535.0,
                     n = low[k] + (high[k] - low[k]) * t;
        EXPECT_NEAR(cloud.position[at][k], (n < 0.0 ? -1.0 : 1.0) * (std::exp(std::abs(n)) - 1.0), 1e-12);
        EXPECT_FLOAT_EQ(cloud.scale[at][k], static_cast<float>(std::exp(-3.0 + 0.02 * (3 + 4 * i + k))));
        EXPECT_FLOAT_EQ(cloud.harmonics[12 * at + static_cast<std::size_t>(k)],
                        static_cast<float>(-2.0 + 0.015 * (77 + 4 * i + k)));
        // Labels are 0, 1, 2: three pixels each.
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(cloud.harmonics[12 * at + 3 + static_cast<std::size_t>(3 * k + c)],
                      -0.5 + 0.004 * ((5 + 4 * (3 * i + k) + c) % 256), 1e-6);
      }
      EXPECT_FLOAT_EQ(cloud.opacity[at], static_cast<float>(200 + i) / 255.0f);
      // w, x and y are left out in turn.
      Eigen::Vector4d q;  // w x y z
      double sum = 0.0;
      for (int k = 0, from = 0; k < 4; ++k) {
        q[k] = k == i ? 0.0 : ((40 + 4 * i + from++) / 255.0 - 0.5) * std::sqrt(2.0);
        sum += q[k] * q[k];
      }
      q[i] = std::sqrt(std::max(0.0, 1.0 - sum));
      q.normalize();
      EXPECT_LT((cloud.rotation[at].coeffs().cast<double>() - Eigen::Vector4d(q[1], q[2], q[3], q[0])).norm(),
                1e-6);
    }
    EXPECT_EQ(cloud.filter, SplatFilter::dilated);
  }
}

TEST(SogTest, UnpackedItIsTheSame) {
  const test::TemporaryFolder folder;
  const Made made = Made().with_harmonics();
  const auto put = [&](const std::string& name, const std::string& bytes) {
    test::put(folder / name, bytes);
  };
  put("means_l.webp", made.low);
  put("means_u.webp", made.high);
  put("quats.webp", made.quats);
  put("scales.webp", made.scales);
  put("sh0.webp", made.colors);
  put("shN_centroids.webp", made.centroids);
  put("shN_labels.webp", made.labels);
  put("meta.json", made.meta());
  const std::string meta = folder / "meta.json";
  const Result<LoadedSplats> bundle = io::read_sog("a.sog", made.bytes(), {}), loose = read_splats(meta);
  ASSERT_TRUE(loose.ok()) << loose.error().message();
  EXPECT_EQ(loose->splats.position, bundle->splats.position);
  EXPECT_EQ(loose->splats.opacity, bundle->splats.opacity);
  EXPECT_EQ(loose->splats.harmonics, bundle->splats.harmonics);
  EXPECT_TRUE(holds_splats(meta));

  // It stands for all of its images.
  Result<SceneFile> scene = read_scene_or_points(meta, {});
  ASSERT_TRUE(scene.ok()) << scene.error().message();
  const std::string before = *scene->hash(1.0);
  put("sh0.webp", Made::image(2, 2, 78, 200));
  EXPECT_NE(*read_scene_or_points(meta, {})->hash(1.0), before);

  // Only what lies beside it is opened.
  for (const char* name : {"../sh0.webp", "/etc/passwd", "..", ""}) {
    std::string elsewhere = made.meta();
    elsewhere.replace(elsewhere.find("sh0.webp"), 8, name);
    put("meta.json", elsewhere);
    const Result<LoadedSplats> refused = read_splats(meta);
    ASSERT_FALSE(refused.ok()) << name;
    EXPECT_EQ(refused.error().file, meta);
    EXPECT_EQ(refused.error().reason, "must be the name of a file beside meta.json") << name;
  }
  std::string missing = made.meta();
  missing.replace(missing.find("sh0.webp"), 8, "sh1.webp");
  put("meta.json", missing);
  EXPECT_EQ(read_splats(meta).error().field, "sh1.webp");
  // A scene may have that name.
  put("meta.json", R"({"swept": 1, "means": 3})");
  EXPECT_FALSE(holds_splats(meta));
}

TEST(SogTest, WhatMayBeThere) {
  Made made;
  made.more = R"(,"antialias":true,"asset":{"generator":"someone"})";
  const Result<LoadedSplats> file = io::read_sog("a.sog", made.bytes(), {});
  ASSERT_TRUE(file.ok()) << file.error().message();
  EXPECT_EQ(file->splats.filter, SplatFilter::antialiased);
  EXPECT_EQ(file->splats.degree, 0);
  // A codebook that lost its first number.
  made.scales = Made::image(2, 2, 0);
  made.scale_book.replace(1, made.scale_book.find(',') - 1, "null");
  const Result<LoadedSplats> lost = io::read_sog("a.sog", made.bytes(), {});
  ASSERT_TRUE(lost.ok()) << lost.error().message();
  EXPECT_NEAR(std::log(lost->splats.scale[0].x()), -2.98f - 5.08f / 255.0f, 1e-5f);
  EXPECT_EQ(lost->report.assumed.size(), 2u);
}

TEST(SogTest, BundlesThatLieAreRefused) {
  const auto refused = [](auto spoil) {
    Made made;
    made.with_harmonics();
    spoil(made);
    return refusal(made.bytes());
  };
  EXPECT_EQ(refused([](Made&) {}), "none");
  EXPECT_EQ(refused([](Made& m) { m.count = "0"; }), ": has no splats");
  EXPECT_EQ(refused([](Made& m) { m.count = "-1"; }).find("/count: "), 0u);
  EXPECT_EQ(refused([](Made& m) { m.count = "5"; }), "means_l.webp: has 2 x 2 pixels, not 5 to 65546");
  EXPECT_EQ(refused([](Made& m) { m.count = "4000000000"; }).find("/count: promises 4000000000 splats"), 0u);
  EXPECT_EQ(refused([](Made& m) { m.version = "\"version\":3,"; }),
            "/version: is not 2, the one that is known");
  EXPECT_EQ(refused([](Made& m) { m.version = ""; }),
            ": has no \"version\", as version 1 of SOG, which is not known");
  EXPECT_EQ(refused([](Made& m) { m.scale_book = "[1,2,3]"; }), "/scales/codebook: has 3 numbers, not 256");
  EXPECT_EQ(refused([](Made& m) { m.color_book = "[]"; }), "/sh0/codebook: has 0 numbers, not 256");
  EXPECT_EQ(
      refused([](Made& m) { m.scale_book = Made::book(100, 0.1); }).find("/scales/codebook: splat 0 gives"),
      0u);
  EXPECT_EQ(refused([](Made& m) { m.quats = Made::image(2, 2, 40, 251); }),
            "quats: splat 0 has a rotation of kind 251; 252 to 255 are known");
  EXPECT_EQ(
      refused([](Made& m) { m.quats = Made::image(1, 1, 40, 252); }).find("quats.webp: has 1 x 1 pixels"),
      0u);
  EXPECT_EQ(refused([](Made& m) {
              m.labels = Made::pixels({0, 64, 2, 3});
            }),
            "shN: splat 1 has entry 64 of a palette of 64");
  EXPECT_EQ(
      refused([](Made& m) { m.centroids = Made::image(191, 1, 5); }).find("/shN/files/0: is 191 pixels wide"),
      0u);
  EXPECT_EQ(refused([](Made& m) { m.centroids = Made::image(512, 1, 5); }).find("/shN/bands: "), 0u);
  EXPECT_EQ(refused([](Made& m) { m.shn.replace(m.shn.find("64"), 2, "65"); }).find("/shN/count: is 65"), 0u);
  EXPECT_EQ(refused([](Made& m) {
              m.scales = webp(2, 2, Made::raw(2, 2, 3), false);
            }).find("scales.webp: is no lossless"),
            0u);
  EXPECT_EQ(refused([](Made& m) { m.scales = "RIFF"; }), "scales.webp: is no WebP image");
  EXPECT_EQ(refused([](Made& m) { m.scales.resize(m.scales.size() - 4); }).find("scales.webp: is"), 0u);
  EXPECT_EQ(refusal(zip({{"a.txt", "b"}})).find("meta.json: cannot be read from the zip archive"), 0u);
  EXPECT_EQ(refusal(zip({{"meta.json", "{"}})).find("line 1"), 0u);
  EXPECT_EQ(refusal(zip({{"meta.json", "{}"}})),
            ": has no \"version\", as version 1 of SOG, which is not known");
}

TEST(SogTest, EveryTruncationIsRefused) {
  for (const bool pack : {false, true}) {
    Made made;
    made.pack = pack;
    const std::string whole = made.with_harmonics().bytes();
    for (std::size_t size = 0; size < whole.size(); ++size)
      EXPECT_NE(refusal(whole.substr(0, size)), "none") << size;
  }
  // Of each image in it.
  Made made;
  const std::string whole = made.scales;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    made.scales = whole.substr(0, size);
    EXPECT_EQ(refusal(made.bytes()).find("scales.webp: is"), 0u) << size;
  }
}

std::size_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

TEST(SogTest, BombsAreRefusedBeforeTheyUnpack) {
  constexpr std::size_t mib = std::size_t{1} << 20;
  const std::string zeros = zip({{"meta.json", std::string(100 * mib, ' ')}}, true);
  // 4096 × 4096 pixels in a few bytes, for three splats.
  Made huge;
  huge.low = webp(4096, 4096, std::string(64 * mib, '\1'));
  const std::string image = huge.bytes();
  // Sizes in the directory that are not those of what is packed.
  Made made;
  made.pack = true;
  std::string lies = made.bytes();
  const std::size_t entry = lies.rfind("PK\1\2");
  lies.replace(entry + 24, 4, le32(1000));
  const std::size_t before = peak_bytes();
  EXPECT_EQ(refusal(zeros).find("meta.json: has 104857600 bytes"), 0u) << refusal(zeros);
  EXPECT_EQ(refusal(image), "means_l.webp: has 4096 x 4096 pixels, not 3 to 65542");
  EXPECT_NE(refusal(lies), "none");
  EXPECT_LT(peak_bytes() - before, 32 * mib);
}

TEST(SogTest, FlippedBytesNeverDoHarm) {
  Made made;
  const std::string whole = made.with_harmonics().bytes();
  for (std::size_t at = 0; at < whole.size(); at += 3) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0xff);
    const Result<LoadedSplats> file = io::read_sog("a.sog", damaged, {});
    if (file.ok())
      EXPECT_TRUE(file->splats.validate().ok());
    else
      EXPECT_FALSE(file.error().reason.empty());
  }
}

}  // namespace
