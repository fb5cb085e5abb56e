// .spz files of every version, written here by the format's description.
#include <sys/resource.h>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "splat/io/read_splats.h"
#include "tests/packed_bytes.h"
#include "tests/point_files.h"

namespace {

using namespace swept;
using namespace swept_test;

struct Splat {
  Eigen::Vector3d position;
  std::array<int, 3> scale, color;  ///< as bytes
  int alpha;                        ///< as a byte
  Eigen::Vector4d rotation;         ///< x y z w
  std::array<int, 72> harmonics{};  ///< as bytes, coefficient by coefficient
};

/// Unlike each other in every number.
std::vector<Splat> some(std::size_t count) {
  std::vector<Splat> splats;
  for (std::size_t i = 0; i < count; ++i) {
    const int n = static_cast<int>(i);
    Splat splat{Eigen::Vector3d(1.25 + n, -2.5 * n, 300.5 - n),
                {100 + n, 160 - n, 7 * n % 256},
                {3 * n % 256, 255 - n, 128},
                40 + n,
                Eigen::Vector4d(0.1 * n - 1.0, 0.3, -0.2 * n, 0.7 - 0.15 * n).normalized()};
    for (std::size_t k = 0; k < 72; ++k) splat.harmonics[k] = static_cast<int>(5 * k + 3 * i) % 256;
    splats.push_back(splat);
  }
  return splats;
}

std::string half(double x) {
  if (x == 0.0) return le16(0);
  int exponent = 0;
  const double mantissa = std::frexp(std::abs(x), &exponent);  // [½, 1)
  const int bits = ((exponent + 14) << 10) + static_cast<int>(std::lround((2.0 * mantissa - 1.0) * 1024.0));
  return le16(static_cast<std::size_t>((x < 0.0 ? 0x8000 : 0) | bits));
}

std::string smallest_three(Eigen::Vector4d q) {
  Eigen::Index largest = 0;
  q.cwiseAbs().maxCoeff(&largest);
  if (q[largest] < 0.0) q = -q;
  auto word = static_cast<std::uint32_t>(largest);
  for (Eigen::Index k = 0; k < 4; ++k) {
    if (k == largest) continue;
    const auto size = static_cast<std::uint32_t>(std::lround(std::abs(q[k]) * std::numbers::sqrt2 * 511.0));
    word = word << 10 | (q[k] < 0.0 ? 512u : 0u) | size;
  }
  return le32(word);
}

struct Made {
  std::uint32_t version = 3;
  int degree = 3, flags = 0;
  std::size_t count = 0;  ///< in the header
  std::vector<std::string> streams;
  std::string extensions;

  explicit Made(std::uint32_t of_version, const std::vector<Splat>& splats, int of_degree = 3)
      : version(of_version), degree(of_degree), count(splats.size()), streams(6) {
    for (const Splat& splat : splats) {
      for (int k = 0; k < 3; ++k) {
        const auto fixed = static_cast<std::int32_t>(std::lround(splat.position[k] * 1024.0));
        streams[0] += version == 1 ? half(splat.position[k]) : bytes_of(fixed).substr(0, 3);
        streams[2] += static_cast<char>(splat.color[static_cast<std::size_t>(k)]);
        streams[3] += static_cast<char>(splat.scale[static_cast<std::size_t>(k)]);
      }
      streams[1] += static_cast<char>(splat.alpha);
      if (version >= 3) {
        streams[4] += smallest_three(splat.rotation);
      } else {
        for (int k = 0; k < 3; ++k)
          streams[4] += static_cast<char>(
              std::lround((splat.rotation[k] * (splat.rotation[3] < 0.0 ? -1.0 : 1.0) + 1.0) * 127.5));
      }
      for (int k = 0; k < 3 * ((degree + 1) * (degree + 1) - 1); ++k)
        streams[5] += static_cast<char>(splat.harmonics[static_cast<std::size_t>(k)]);
    }
  }

  [[nodiscard]] std::string head() const {
    return "NGSP" + le32(version) + le32(count) + static_cast<char>(degree) + '\x0a' +
           static_cast<char>(flags);
  }
  [[nodiscard]] std::string bytes() const {
    if (version <= 3) {
      std::string all = head() + '\0';
      for (const std::string& stream : streams) all += stream;
      return gzip(all + extensions);
    }
    const std::size_t used = degree > 0 ? 6 : 5;
    std::string table, packed;
    for (std::size_t k = 0; k < used; ++k) {
      const std::string stream = zstd(streams[k]);
      table += le64(stream.size()) + le64(streams[k].size());
      packed += stream;
    }
    return head() + static_cast<char>(used) + le32(32 + extensions.size()) + std::string(12, '\0') +
           extensions + table + packed;
  }
};

Result<LoadedSplats> read(const std::string& bytes, SpzAxes axes = SpzAxes::automatic) {
  SplatReadOptions options;
  options.spz_axes = axes;
  return io::read_spz("a.spz", bytes, options);
}

std::string refusal(const std::string& bytes) {
  const Result<LoadedSplats> file = read(bytes);
  if (file.ok()) return "none";
  EXPECT_EQ(file.error().file, "a.spz");
  return file.error().field + ": " + file.error().reason;
}

void expect_splats(const SplatCloud& cloud, const std::vector<Splat>& splats, const Made& made, bool turned) {
  ASSERT_EQ(cloud.size(), splats.size());
  const double sign = turned ? -1.0 : 1.0;
  const int degree = std::min(made.degree, 3);
  ASSERT_EQ(cloud.degree, degree);
  const auto coefficients = static_cast<std::size_t>(SplatCloud::coefficients(degree));
  // Odd in y and z together: the signs of y, z, x, xy, yz, …
  const int odd[16] = {1, -1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1};
  for (std::size_t i = 0; i < splats.size(); ++i) {
    const Splat& splat = splats[i];
    for (int k = 0; k < 3; ++k) {
      const auto channel = static_cast<std::size_t>(k);
      const double position = splat.position[k] * (k > 0 ? sign : 1.0);
      EXPECT_NEAR(cloud.position[i][k], position,
                  made.version == 1 ? std::abs(position) / 2048.0 : 0.5 / 1024.0);
      EXPECT_FLOAT_EQ(cloud.scale[i][k], static_cast<float>(std::exp(splat.scale[channel] / 16.0 - 10.0)));
      EXPECT_FLOAT_EQ(cloud.harmonics[i * 3 * coefficients + channel],
                      static_cast<float>((splat.color[channel] / 255.0 - 0.5) / 0.15));
    }
    EXPECT_FLOAT_EQ(cloud.opacity[i], static_cast<float>(splat.alpha) / 255.0f);
    Eigen::Vector4d q = splat.rotation;
    if (turned) q.segment<2>(1) *= -1.0;
    const double step = made.version < 3 ? 1.0 / 127.5 : std::sqrt(0.5) / 511.0;
    const Eigen::Vector4d found = cloud.rotation[i].coeffs().cast<double>();
    // Of versions 1 and 2 the component left out is w, however small.
    const double most = made.version < 3 ? 0.1 : 3.0 * 0.5 * step;
    EXPECT_LT(std::min((found - q).cwiseAbs().maxCoeff(), (found + q).cwiseAbs().maxCoeff()), most) << i;
    for (std::size_t k = 1; k < coefficients; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_EQ(
            cloud.harmonics[3 * (i * coefficients + k) + c],
            static_cast<float>((turned ? odd[k] : 1) * (splat.harmonics[3 * (k - 1) + c] - 128)) / 128.0f);
  }
}

TEST(SpzTest, EveryVersionAndDegree) {
  const std::vector<Splat> splats = some(9);
  for (const std::uint32_t version : {1u, 2u, 3u, 4u}) {
    for (int degree = 0; degree <= 4; ++degree) {
      SCOPED_TRACE(std::to_string(version) + ", " + std::to_string(degree));
      const Made made(version, splats, degree);
      for (const SpzAxes axes : {SpzAxes::trained, SpzAxes::right_up_back, SpzAxes::automatic}) {
        const Result<LoadedSplats> file = read(made.bytes(), axes);
        ASSERT_TRUE(file.ok()) << file.error().message();
        EXPECT_TRUE(file->splats.validate().ok());
        const bool turned = axes == SpzAxes::right_up_back;
        expect_splats(file->splats, splats, made, turned);
        EXPECT_EQ(file->report.unread.size(), degree == 4 ? 1u : 0u);
      }
    }
  }
}

TEST(SpzTest, FlagsAndExtensions) {
  for (const std::uint32_t version : {3u, 4u}) {
    Made made(version, some(2));
    EXPECT_EQ(read(made.bytes())->splats.filter, SplatFilter::dilated);
    made.flags = 3;
    made.extensions = le32(0xADBE0002) + le32(12) + std::string(12, '\1');
    const Result<LoadedSplats> file = read(made.bytes());
    ASSERT_TRUE(file.ok()) << file.error().message();
    EXPECT_EQ(file->splats.filter, SplatFilter::antialiased);
    EXPECT_EQ(file->report.unread, std::vector<std::string>{"extensions"});
    made.flags = 4;
    EXPECT_EQ(refusal(made.bytes()).find("flags: are 4"), 0u);
    made.flags = 0x80;
    EXPECT_NE(refusal(made.bytes()).find("levels of detail"), std::string::npos);
  }
}

TEST(SpzTest, AFileMaySayItsAxes) {
  Made made(4, some(2));
  made.flags = 2;
  const auto y = [&](std::size_t system) {
    made.extensions = le32(0xADBE0003) + le32(4) + le32(system);
    const Result<LoadedSplats> file = read(made.bytes());
    EXPECT_TRUE(file.ok()) << file.error().message();
    return file.ok() ? file->splats.position[1].y() : 0.0;
  };
  EXPECT_EQ(y(6), -2.5);
  EXPECT_EQ(y(4), 2.5);
  EXPECT_EQ(y(0), 2.5);
  made.extensions = le32(0xADBE0003) + le32(4) + le32(7);
  EXPECT_EQ(refusal(made.bytes()).find("extensions: say that axes are system 7"), 0u);
  made.extensions = le32(0xADBE0003) + le32(5) + le32(6);
  EXPECT_EQ(refusal(made.bytes()), "extensions: end within a record");
}

TEST(SpzTest, EveryTruncationIsRefused) {
  for (const std::uint32_t version : {1u, 2u, 3u, 4u}) {
    const std::string whole = Made(version, some(5)).bytes();
    ASSERT_EQ(refusal(whole), "none");
    for (std::size_t size = 0; size < whole.size(); ++size)
      EXPECT_NE(refusal(whole.substr(0, size)), "none") << version << ", " << size;
    EXPECT_EQ(refusal(whole + "x").find(": goes on after its splats"), 0u);
  }
}

TEST(SpzTest, HeadersThatLieAreRefused) {
  Made made(3, some(3));
  made.count = 4;
  EXPECT_NE(refusal(made.bytes()), "none");
  made.count = 2;
  EXPECT_EQ(refusal(made.bytes()).find(": goes on after its splats"), 0u);
  made.count = 0;
  EXPECT_EQ(refusal(made.bytes()), ": has no splats");
  EXPECT_EQ(io::read_spz("a.spz", made.bytes(), {}).error().kind, ErrorKind::empty);
  made.count = 4000000000;
  EXPECT_EQ(refusal(made.bytes()).find("numPoints: promises 4000000000 splats"), 0u);

  Made four(4, some(3));
  four.count = 4;
  EXPECT_EQ(refusal(four.bytes()), "positions: unpacks to 27 bytes, not the 36 of 4 splats");
  four.count = 3;
  four.degree = 2;
  EXPECT_EQ(refusal(four.bytes()), "harmonics: unpacks to 135 bytes, not the 72 of 3 splats");
  four.degree = 5;
  EXPECT_EQ(refusal(four.bytes()).find("shDegree: is 5"), 0u);
  std::string bytes = Made(4, some(3)).bytes();
  bytes[15] = 7;
  EXPECT_EQ(refusal(bytes), "numStreams: is 7, not 6");
  bytes = Made(4, some(3)).bytes();
  bytes.replace(16, 4, le32(31));
  EXPECT_EQ(refusal(bytes).find("tocByteOffset: is 31"), 0u);
  bytes.replace(16, 4, le32(0xffffffff));
  EXPECT_EQ(refusal(bytes).find("tocByteOffset: is 4294967295"), 0u);
  bytes = Made(4, some(3)).bytes();
  bytes.replace(32, 8, le64(~std::size_t{0}));
  EXPECT_EQ(refusal(bytes).find("positions: promises 18446744073709551615 bytes"), 0u);
}

TEST(SpzTest, OtherVersionsAndContainersAreRefusedByName) {
  Made made(3, some(1));
  made.version = 5;
  EXPECT_EQ(refusal(made.bytes()), "version: is 5; 1 to 4 are known");
  EXPECT_EQ(refusal(gzip("NGSP" + le32(9) + std::string(8, '\0'))), "version: is 9; 1 to 4 are known");
  EXPECT_EQ(refusal(gzip("PLYX" + le32(3) + std::string(8, '\0'))), "header: does not start with NGSP");
  EXPECT_EQ(refusal(gzip(Made(4, some(1)).bytes())), "version: is 4, which is not packed by gzip");
  made.version = 2;
  EXPECT_EQ(refusal(made.head() + '\0'), "version: is 2, which is packed by gzip");
  EXPECT_EQ(refusal(""), "header: the file ends here");
}

/// The most memory this process has held so far.
std::size_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

TEST(SpzTest, BombsAreRefusedBeforeTheyUnpack) {
  constexpr std::size_t mib = std::size_t{1} << 20;
  // 30 million splats would be 7 GB as a cloud.
  Made made(3, {});
  made.count = 30'000'000;
  made.streams[0] = std::string(64 * mib, '\0');
  const std::string bomb = made.bytes();
  EXPECT_LT(bomb.size(), mib);

  // A stream of zstd that does not end where its table says, and a window beyond what it holds.
  Made four(4, some(2));
  std::string bytes = four.bytes();
  const std::string zeros = zstd(std::string(64 * mib, '\0'));
  const std::size_t packed = zstd(four.streams[0]).size(), table = 32 + 6 * 16;
  bytes.replace(table, packed, zeros);
  bytes.replace(32, 8, le64(zeros.size()));
  const std::size_t before = peak_bytes();
  EXPECT_EQ(refusal(bomb).find("numPoints: promises 30000000 splats"), 0u);
  EXPECT_EQ(refusal(bytes).find("positions: its zstd stream goes on after 18 bytes"), 0u) << refusal(bytes);
  EXPECT_LT(peak_bytes() - before, 32 * mib);
}

TEST(SpzTest, FlippedBytesNeverDoHarm) {
  for (const std::uint32_t version : {2u, 4u}) {
    const std::string whole = Made(version, some(3)).bytes();
    for (std::size_t at = 0; at < whole.size(); ++at) {
      for (const int flip : {1, 0x80, 0xff}) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ flip);
        const Result<LoadedSplats> file = read(damaged);
        if (file.ok())
          EXPECT_TRUE(file->splats.validate().ok());
        else
          EXPECT_FALSE(file.error().reason.empty());
      }
    }
  }
}

}  // namespace
