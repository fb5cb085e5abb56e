// Edges of moving triangles (Gribel et al. 2013, Eq. 2 to 4): two solvers that judge each other, and sheets
// without gaps at any time.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "splat/fields.h"
#include "splat/interval/bernstein.h"
#include "splat/interval/edge_function.h"
#include "splat/interval/only_root.h"
#include "tests/oracle/of_roots.h"

namespace swept {
namespace {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_()) / 18446744073709551616.0);
  }
  Eigen::Vector3d vector(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }

 private:
  std::mt19937_64 engine_;
};

/// Below it the sign is not known: coefficients are moved by about so much in cutting, and Ferrari's formula
/// loses some more where three roots or four are one.
double noise_of(const Bernstein& p) { return (p.degree == 4 ? 0x1p-42 : 0x1p-46) * p.largest(); }

struct Agreement {
  std::uint64_t edges = 0, changes = 0, within_noise = 0;
  double worst = 0.0;  ///< in time, of changes that are told from noise
};

/// The two answers have one sign wherever |e| is above noise, and changes at which the polynomial is steep
/// enough for noise to move them less than 1e-9 lie within 1e-9 of each other.
void expect_agreement(const Bernstein& p, Agreement& agreement) {
  const SignChanges a = sign_changes_closed(p), b = sign_changes_by_cutting(p);
  ++agreement.edges;
  const double noise = noise_of(p);
  std::vector<double> times{0.0, 1.0};
  for (const SignChanges* s : {&a, &b})
    for (int k = 0; k < s->count; ++k) times.push_back(s->at[static_cast<std::size_t>(k)]);
  std::sort(times.begin(), times.end());
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    if (!(times[i + 1] - times[i] > 1e-9)) continue;
    // Between two changes of either the signs differ for longer than 1e-9: there e must be noise throughout.
    const double middle = 0.5 * times[i] + 0.5 * times[i + 1];
    if (a.sign_at(middle) == b.sign_at(middle)) {
      if (a.first != 0 && std::abs(p.at(middle)) > noise) {
        ASSERT_EQ(a.sign_at(middle) > 0, p.at(middle) > 0.0) << middle;
      }
      continue;
    }
    ++agreement.within_noise;
    for (int j = 1; j < 16; ++j)
      ASSERT_LE(std::abs(p.at(times[i] + (times[i + 1] - times[i]) * j / 16.0)), noise)
          << "from " << times[i] << " to " << times[i + 1];
  }
  if (a.count != b.count) return;
  Bernstein slope;
  slope.degree = p.degree - 1;
  for (std::size_t k = 0; k < static_cast<std::size_t>(p.degree); ++k)
    slope.c[k] = p.degree * (p.c[k + 1] - p.c[k]);
  for (std::size_t k = 0; k < static_cast<std::size_t>(a.count); ++k) {
    ++agreement.changes;
    if (std::abs(slope.at(a.at[k])) * 1e-9 > noise)
      agreement.worst = std::max(agreement.worst, std::abs(a.at[k] - b.at[k]));
  }
}

TEST(EdgeFunction, TwoSolversAgreeOverAMillionEdges) {
  Random random(1);
  Agreement agreement;
  // Edges of triangles as they come: straight paths and parabolas, far and near, some through the eye.
  for (int i = 0; i < 500000; ++i) {
    const int degree = 1 + i % 2;
    PathPoints p, q;
    const Eigen::Vector3d at = random.vector(3.0);
    const double size = std::pow(10.0, random.uniform(-3.0, 0.5)),
                 motion = std::pow(10.0, random.uniform(-3.0, 0.5));
    for (std::size_t k = 0; k < p.size(); ++k) {
      p[k] = at + static_cast<double>(k) * random.vector(motion);
      q[k] = p[k] + random.vector(size);
    }
    // A ray that comes by: to somewhere near the edge.
    const Eigen::Vector3d seen = at + random.vector(size + motion);
    const EdgeFunction edge(p, q, degree);
    expect_agreement(edge.at({seen.x() / seen.z(), seen.y() / seen.z(), 1.0}), agreement);
    if (HasFatalFailure()) return;
  }
  // Roots as they are hard: double and nearly double ones, at the ends and beyond them.
  for (int i = 0; i < 500000; ++i) {
    std::vector<double> roots;
    const double gap = i % 3 == 0 ? 0.0 : std::pow(10.0, random.uniform(-15.0, -1.0));
    const double first = i % 7 == 0 ? 0.0 : i % 11 == 0 ? 1.0 - gap : random.uniform(-0.2, 1.2);
    roots = {first, first + gap};
    if (i % 2 == 0) {
      roots.push_back(random.uniform(-0.5, 1.5));
      roots.push_back(i % 4 == 0 ? roots.back() + gap : random.uniform(-0.5, 1.5));
    }
    expect_agreement(of_roots(roots, std::pow(10.0, random.uniform(-9.0, 9.0)) * (i % 5 < 2 ? -1.0 : 1.0)),
                     agreement);
    if (HasFatalFailure()) return;
  }
  EXPECT_EQ(agreement.edges, 1000000u);
  EXPECT_GT(agreement.changes, 500000u);
  EXPECT_LE(agreement.worst, 1e-9);
  RecordProperty("changes", std::to_string(agreement.changes));
  RecordProperty("within_noise", std::to_string(agreement.within_noise));
  RecordProperty("worst", shortest_text(agreement.worst));
}

TEST(EdgeFunction, LoneRootsHaveTheSameBitsAtAFixedDegree) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> exponent(-6.0, 3.0);
  std::uniform_int_distribution<std::size_t> positives(1, 4);
  for (int n = 0; n < 20000; ++n) {
    Bernstein p;
    p.degree = 4;
    const std::size_t change = positives(random);
    for (std::size_t k = 0; k < 5; ++k) p.c[k] = (k < change ? 1.0 : -1.0) * std::pow(10.0, exponent(random));
    const double root = only_root<4>(p.c.data(), 4, 1);
    ASSERT_EQ(root, only_root<0>(p.c.data(), 4, 1)) << n;
    ASSERT_GE(p.at(std::max(0.0, root - 1e-12)), 0.0) << n;
    ASSERT_LE(p.at(std::min(1.0, root + 1e-12)), 0.0) << n;
  }
}

TEST(EdgeFunction, SolversFindTheRootsThatArePutIn) {
  for (const bool closed : {false, true})
    for (const std::vector<double>& roots : {std::vector<double>{0.25, 0.75},
                                             {0.1, 0.2, 0.6, 0.9},
                                             {0.5, 0.5 + 1e-5},
                                             {0.3, 1.7},
                                             {0.45, 0.7}}) {
      const Bernstein p = of_roots(roots, 3.0);
      const SignChanges found = closed ? sign_changes_closed(p) : sign_changes_by_cutting(p);
      std::vector<double> expected;
      for (const double root : roots)
        if (root < 1.0) expected.push_back(root);
      ASSERT_EQ(static_cast<std::size_t>(found.count), expected.size()) << closed << roots[0];
      for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(found.at[i], expected[i], 1e-9);
      EXPECT_EQ(found.first, p.at(0.0) > 0.0 ? 1 : -1);
    }
}

TEST(EdgeFunction, CuttingKnowsAnyDegree) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    std::vector<double> roots;
    const int degree = 3 + i % 8;
    for (int k = 0; k < degree; ++k) roots.push_back((k + random.uniform(0.3, 0.7)) / degree);
    const SignChanges found = sign_changes_by_cutting(of_roots(roots, 1.0));
    ASSERT_EQ(found.count, degree);
    for (std::size_t k = 0; k < roots.size(); ++k) ASSERT_NEAR(found.at[k], roots[k], 1e-7);
  }
}

TEST(EdgeFunction, IsTheEdgeOfTheMovedTriangle) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const int degree = 1 + i % 3;
    PathPoints p, q;
    for (std::size_t k = 0; k < p.size(); ++k) p[k] = random.vector(2.0), q[k] = random.vector(2.0);
    const Eigen::Vector3d ray(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 1.0);
    const Bernstein there = EdgeFunction(p, q, degree).at(ray), back = EdgeFunction(q, p, degree).at(ray);
    for (std::size_t k = 0; k <= static_cast<std::size_t>(2 * degree); ++k) ASSERT_EQ(there.c[k], -back.c[k]);
    for (double t = 0.0; t <= 1.0; t += 0.125) {
      const auto at = [&](const PathPoints& path) {
        std::array<Eigen::Vector3d, most_path_degree + 1> points = path;
        for (int level = 0; level < degree; ++level)
          for (std::size_t k = 0; k + static_cast<std::size_t>(level) < static_cast<std::size_t>(degree); ++k)
            points[k] += t * (points[k + 1] - points[k]);
        return points[0];
      };
      ASSERT_NEAR(there.at(t), at(p).cross(at(q)).dot(ray), 1e-12);
    }
  }
}

/// A sheet that is bent, moved and turned covers each ray within it once at any time: no gap and no overlap,
/// at times as dense as they come.
TEST(EdgeFunction, SheetsHaveNoGapsAtAnyTime) {
  for (const int degree : {1, 2, 3}) {
    Random random(7);
    constexpr std::size_t side = 12;
    std::vector<PathPoints> points;
    for (std::size_t i = 0; i <= side; ++i)
      for (std::size_t j = 0; j <= side; ++j) {
        // Inner points wander, the rim stays, whose rays are all hit.
        const bool rim = i == 0 || j == 0 || i == side || j == side;
        PathPoints path;
        for (Eigen::Vector3d& p : path)
          p = Eigen::Vector3d(-1.0 + 2.0 * static_cast<double>(i) / side,
                              -1.0 + 2.0 * static_cast<double>(j) / side, 2.0) +
              (rim ? Eigen::Vector3d::Zero() : Eigen::Vector3d(random.vector(0.025)));
        points.push_back(path);
      }
    std::vector<std::array<std::size_t, 3>> triangles;
    for (std::size_t i = 0; i < side; ++i)
      for (std::size_t j = 0; j < side; ++j) {
        const std::size_t a = i * (side + 1) + j, b = a + 1, c = a + side + 1, d = c + 1;
        triangles.push_back({a, c, b});
        triangles.push_back({b, c, d});
      }
    std::uint64_t looks = 0;
    for (int ray = 0; ray < 400; ++ray) {
      // Every other one through a point of the grid at rest, on whose edges it lies at times.
      Eigen::Vector3d d(random.uniform(-0.45, 0.45), random.uniform(-0.45, 0.45), 1.0);
      if (ray % 2 == 0) d = {std::round(d.x() * 12.0) / 12.0, std::round(d.y() * 12.0) / 12.0, 1.0};
      std::vector<std::array<SignChanges, 3>> sides;
      for (const auto& t : triangles) {
        std::array<SignChanges, 3> s;
        for (std::size_t e = 0; e < 3; ++e)
          s[e] = EdgeFunction(points[t[(e + 1) % 3]], points[t[(e + 2) % 3]], degree).sides(d);
        sides.push_back(s);
      }
      // Dense in time, and right before and after every change there is.
      std::vector<double> times;
      for (int k = 0; k < 500; ++k) times.push_back((k + 0.5) / 500.0);
      for (const auto& s : sides)
        for (const SignChanges& edge : s)
          for (int k = 0; k < edge.count; ++k)
            for (const double off : {-1e-12, 1e-12})
              times.push_back(std::clamp(edge.at[static_cast<std::size_t>(k)] + off, 0.0, 1.0));
      for (const double time : times) {
        int covered = 0;
        for (const auto& s : sides) {
          const int first = s[0].sign_at(time);
          if (first != 0 && first == s[1].sign_at(time) && first == s[2].sign_at(time)) covered += 1;
        }
        ++looks;
        ASSERT_EQ(covered, 1) << degree << " " << d.transpose() << " at " << time;
      }
    }
    EXPECT_GT(looks, 100000u);
  }
}

}  // namespace
}  // namespace swept
