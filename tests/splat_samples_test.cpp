// One trained cloud in every container that a converter wrote of it: each is the same cloud, within the steps
// of its numbers.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "splat/io/read_splats.h"
#include "tests/point_files.h"

namespace {

using namespace swept;

/// The most that numbers may differ by.
struct Steps {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double position_share = 0.0;  ///< of 1 + |x|, besides
  double log_scale = 0.0, rotation = 0.0, opacity = 0.0, color = 0.0;
  double most_color = INFINITY;             ///< what is beyond was clamped
  double harmonic_1 = 0.0, harmonic = 0.0;  ///< of degree 1, and of others
};

/// Three components in steps of 2δ, and one that they determine: largest where all four are alike, 3δ.
constexpr double rotation_of(double step) { return 3.0 * 0.5 * step; }

bool alike(const SplatCloud& a, std::size_t i, const SplatCloud& b, std::size_t j, const Steps& steps) {
  constexpr double rounding = 2e-6;  // of both to float, and of exp and log
  const auto near = [](double x, double y, double step) { return std::abs(x - y) <= step + rounding; };
  for (int k = 0; k < 3; ++k) {
    const double x = a.position[i][k], size = 1.0 + std::abs(x);
    if (std::abs(x - b.position[j][k]) > steps.position[k] + (steps.position_share + 2e-7) * size)
      return false;
    const auto log_of = [k](const SplatCloud& c, std::size_t at) {
      return std::log(static_cast<double>(c.scale[at][k]));
    };
    if (!near(log_of(a, i), log_of(b, j), steps.log_scale)) return false;
  }
  const Eigen::Vector4f p = a.rotation[i].coeffs(), q = b.rotation[j].coeffs();
  if (std::min((p - q).cwiseAbs().maxCoeff(), (p + q).cwiseAbs().maxCoeff()) > steps.rotation + rounding)
    return false;
  if (!near(static_cast<double>(a.opacity[i]), static_cast<double>(b.opacity[j]), steps.opacity))
    return false;
  const std::size_t numbers = 3 * static_cast<std::size_t>(SplatCloud::coefficients(a.degree));
  for (std::size_t k = 0; k < numbers; ++k) {
    const double step = k < 3 ? steps.color : k < 12 ? steps.harmonic_1 : steps.harmonic;
    double x = static_cast<double>(a.harmonics[i * numbers + k]);
    if (k < 3) x = std::clamp(x, -steps.most_color, steps.most_color);
    if (!near(x, static_cast<double>(b.harmonics[j * numbers + k]), step)) return false;
  }
  return true;
}

/// How many splats of `a` have one of `b` to themselves that is like them: a largest matching, by augmenting
/// paths.
std::size_t matched(const SplatCloud& a, const SplatCloud& b, const Steps& steps) {
  std::vector<std::size_t> by_x(b.size());
  std::iota(by_x.begin(), by_x.end(), std::size_t{0});
  std::sort(by_x.begin(), by_x.end(),
            [&](std::size_t i, std::size_t j) { return b.position[i].x() < b.position[j].x(); });
  std::vector<std::vector<std::size_t>> candidates(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = a.position[i].x(),
                 reach = steps.position.x() + (steps.position_share + 1e-6) * (1.0 + std::abs(x));
    auto from = std::lower_bound(by_x.begin(), by_x.end(), x - reach,
                                 [&](std::size_t j, double low) { return b.position[j].x() < low; });
    for (; from != by_x.end() && b.position[*from].x() <= x + reach; ++from)
      if (alike(a, i, b, *from, steps)) candidates[i].push_back(*from);
  }
  std::vector<std::size_t> partner(b.size(), a.size());
  std::vector<std::size_t> seen(b.size(), a.size());
  const std::function<bool(std::size_t, std::size_t)> place = [&](std::size_t i, std::size_t round) {
    for (const std::size_t j : candidates[i]) {
      if (seen[j] == round) continue;
      seen[j] = round;
      if (partner[j] != a.size() && !place(partner[j], round)) continue;
      partner[j] = i;
      return true;
    }
    return false;
  };
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += place(i, i);
  return count;
}

class SplatSamplesTest : public ::testing::Test {
 protected:
  static SplatCloud read(const std::string& path) {
    Result<LoadedSplats> file = read_splats(path);
    EXPECT_TRUE(file.ok()) << file.error().message();
    if (!file.ok()) return {};
    EXPECT_TRUE(file->splats.validate().ok()) << file->splats.validate().error().message();
    EXPECT_TRUE(file->notes.empty());
    EXPECT_TRUE(holds_splats(path));
    return std::move(file->splats);
  }

  static void expect_same(const std::string& data, const std::string& name, const Steps& steps) {
    const SplatCloud trained = read(data + "gaussians/try_it7000.ply"),
                     packed = read(data + "gaussians/" + name);
    ASSERT_EQ(packed.size(), trained.size());
    ASSERT_EQ(packed.degree, 3);
    EXPECT_EQ(packed.filter, SplatFilter::dilated);
    EXPECT_EQ(packed.colors, SplatColors::srgb);
    EXPECT_EQ(matched(trained, packed, steps), trained.size());
    // A test that can fail: half the steps are too few for some.
    Steps half = steps;
    half.opacity *= 0.5;
    half.color *= 0.5;
    EXPECT_LT(matched(trained, packed, half), steps.opacity > 0.0 ? trained.size() : trained.size() + 1);
  }
};

TEST_F(SplatSamplesTest, CutShortTheyAreRefusedAtOnce) {
  SWEPT_DATA_OR_SKIP(data);
  const auto refuse = [&](const std::string& name, auto reader) {
    const std::string whole = test::content_of(data + "gaussians/" + name);
    ASSERT_TRUE(reader(name, whole, {}).ok());
    for (std::size_t k = 0; k < 80; ++k) {
      // Evenly, and the last bytes one by one.
      const std::size_t size = k < 64 ? whole.size() / 64 * k : whole.size() - 1 - (k - 64);
      const Result<LoadedSplats> file =
          reader(name, std::string_view(whole).substr(0, size), SplatReadOptions{});
      ASSERT_FALSE(file.ok()) << name << ", " << size;
      EXPECT_EQ(file.error().file, name);
      EXPECT_EQ(file.error().message().find('\n'), std::string::npos);
    }
  };
  refuse("try_it7000.ply", io::read_splat_ply);
  refuse("try_it7000.compressed.ply", io::read_splat_ply);
  refuse("try_it7000.spz", io::read_spz);
  refuse("try_it7000.glb", io::read_splat_gltf);
  refuse("try_it7000.sog", io::read_sog);
}

TEST_F(SplatSamplesTest, GltfIsExact) {
  SWEPT_DATA_OR_SKIP(data);
  expect_same(data, "try_it7000.glb", {});
}

TEST_F(SplatSamplesTest, PackedPly) {
  SWEPT_DATA_OR_SKIP(data);
  // A chunk's range is divided by 2047, 1023 and 2047 (position, scale) or by 255 (colour), and none is wider
  // than that of the whole cloud: 881 × 742.5 × 1295.5 units, 10.73 of log scale, 7 of f_dc.
  Steps steps;
  steps.position = Eigen::Vector3d(0.5 * 881.1 / 2047.0, 0.5 * 742.5 / 1023.0, 0.5 * 1295.6 / 2047.0);
  steps.log_scale = 0.5 * 10.8 / 1023.0;
  steps.rotation = rotation_of(std::sqrt(2.0) / 1023.0);
  steps.opacity = 0.5 / 255.0;
  steps.color = 0.5 * 7.0 / 255.0;
  steps.harmonic_1 = steps.harmonic = 0.5 * 8.0 / 256.0;
  expect_same(data, "try_it7000.compressed.ply", steps);
}

TEST_F(SplatSamplesTest, Spz) {
  SWEPT_DATA_OR_SKIP(data);
  Steps steps;
  steps.position = Eigen::Vector3d::Constant(0.5 / 4096.0);
  steps.log_scale = 0.5 / 16.0;
  steps.rotation = rotation_of(std::sqrt(0.5) / 511.0);
  steps.opacity = 0.5 / 255.0;
  steps.color = 0.5 / 255.0 / 0.15;
  steps.most_color = 0.5 / 0.15;
  // To 1/128 first, then to 5 and 4 bits.
  steps.harmonic_1 = (0.5 + 4.0) / 128.0;
  steps.harmonic = (0.5 + 8.0) / 128.0;
  expect_same(data, "try_it7000.spz", steps);
}

TEST_F(SplatSamplesTest, Sog) {
  SWEPT_DATA_OR_SKIP(data);
  Steps steps;
  // This converter cuts off instead of rounding. d(e^n − 1) = (1 + |x|) dn, and the logarithms span 12.6.
  steps.position_share = 12.6 / 65535.0 * 1.001;
  steps.log_scale = 0.1;  // entries of the codebook are up to 0.2 apart
  steps.rotation = rotation_of(2.0 * std::sqrt(2.0) / 255.0);
  steps.opacity = 1.0 / 255.0;
  steps.color = 0.055;                       // entries of the codebook are up to 0.11 apart
  steps.harmonic_1 = steps.harmonic = 0.02;  // a palette of vectors: what was measured
  expect_same(data, "try_it7000.sog", steps);
}

}  // namespace
