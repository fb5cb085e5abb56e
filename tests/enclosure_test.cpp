// Bounds of moving triangles and discs contain: curves by their enclosures, and by dense sampling all that
// tiles and boxes have to leave in.
#include "abuffer/stochastic/enclosure.h"

#include <cmath>
#include <optional>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/sources/moving_mesh.h"
#include "abuffer/stochastic/mesh_paths.h"
#include "abuffer/stochastic/moving_triangle.h"
#include "splat/motion/instant.h"
#include "tests/small_scenes.h"

namespace swept::stochastic {
namespace {

double value_of(const double* coefficients, int degree, double t) {
  double sum = 0.0;
  for (int k = 0; k <= degree; ++k) {
    double binomial = 1.0;
    for (int i = 0; i < k; ++i) binomial = binomial * (degree - i) / (i + 1);
    sum += binomial * std::pow(t, k) * std::pow(1.0 - t, degree - k) * coefficients[k];
  }
  return sum;
}

double value_of(const Polyline& line, double t) {
  int i = 0;
  while (i + 2 < line.count && t > line.t[i + 1]) ++i;
  return line.v[i] + (t - line.t[i]) / (line.t[i + 1] - line.t[i]) * (line.v[i + 1] - line.v[i]);
}

TEST(Enclosure, LiesBelowTheCurve) {
  test::Random random(3);
  for (const int degree : {1, 2, 4}) {
    double gap[2] = {0.0, 0.0};
    for (int trial = 0; trial < 2000; ++trial) {
      double b[most_degree + 1];
      for (double& v : b) v = random(-1.0, 1.0);
      for (const CurveBounds bounds : {CurveBounds::slefes, CurveBounds::hulls}) {
        const Polyline line = below(b, degree, bounds);
        ASSERT_EQ(line.t[0], 0.0);
        ASSERT_EQ(line.t[line.count - 1], 1.0);
        const Span span = where_not_above(line);
        for (int i = 0; i <= 200; ++i) {
          const double t = i / 200.0, curve = value_of(b, degree, t), bound = value_of(line, t);
          ASSERT_LE(bound, curve + 1e-12) << degree << ' ' << t;
          gap[bounds == CurveBounds::hulls] += curve - bound;
          if (curve <= 0.0) {
            ASSERT_LE(span.begin, t + 1e-12);
            ASSERT_GE(span.end, t - 1e-12);
          }
        }
      }
    }
    std::printf("degree %d: slefes %.4f below on average, hulls %.4f\n", degree, gap[0] / 402000,
                gap[1] / 402000);
    if (degree == 1) {
      EXPECT_LT(gap[0], 1e-6);
    } else {
      EXPECT_LT(gap[0], gap[1]);
    }
  }
}

/// The slefe of a parabola is known: half of its bulge on either side.
TEST(Enclosure, OfAParabolaIsTheBestThereIs) {
  const double b[3] = {0.0, -1.0, 0.0};  // 2t² − 2t
  double values[3];
  slefe_below(b, 2, values);
  for (const double v : {values[0], values[2]}) EXPECT_NEAR(v, -0.125, 1e-9);
  EXPECT_NEAR(values[1], -0.625, 1e-9);
}

TEST(Enclosure, SaysWhenNothingIsBelow) {
  const double above[3] = {1.0, 0.9, 1.0}, crossing[2] = {1.0, -1.0};
  EXPECT_TRUE(where_not_above(below(above, 2, CurveBounds::slefes)).empty());
  const Span span = where_not_above(below(crossing, 1, CurveBounds::slefes));
  EXPECT_NEAR(span.begin, 0.5, 1e-12);
  EXPECT_EQ(span.end, 1.0);
  EXPECT_TRUE(join(Span{1, 0}, Span{1, 0}).empty());
}

Scene random_scene(unsigned seed) {
  test::Random random(seed);
  Scene scene = test::stage();
  scene.film = {32, 24, 0, 0, 0, 0};
  scene.camera.near = 0.1;
  if (seed % 2 == 0) {
    scene.camera.aperture.radius = 0.2;
    scene.camera.look_ats[0].lens.focus = random(2.0, 8.0);
  }
  if (seed % 4 == 0) {
    scene.camera.look_ats.push_back(scene.camera.look_ats[0]);
    scene.camera.look_ats[1].frame = 1.0;
    scene.camera.look_ats[1].lens.focus *= 0.7;
  }
  Object object;
  for (int i = 0; i < 9; ++i) {
    const double size = std::pow(10.0, random(-1.5, 0.5));
    const Eigen::Vector3d middle(random(-1.5, 1.5), random(-1.0, 1.0), random(-3.0, 4.9));
    test::add_disc(object,
                   i % 3 == 0 ? middle
                              : object.cloud.keys[0].pose.position[static_cast<std::size_t>(i - i % 3)] +
                                    random.vector(-size, size),
                   {0, 0, 1}, 0.1);
    object.cloud.velocity.push_back(random.vector(-2.0, 2.0).cast<float>());
    if (seed % 3 != 0) object.cloud.acceleration.push_back(random.vector(-4.0, 4.0).cast<float>());
  }
  object.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
  object.two_sided = seed % 5 != 0;
  scene.objects = {object};
  if (seed % 3 == 1) test::move(scene.objects[0], {0, 0, 0}, {0.3, -0.2, 0.1}, random(0.0, 3.0));
  return scene;
}

/// Where the ray o + z d meets the triangle, by Möller and Trumbore; nothing behind `near`.
std::optional<double> meet_triangle(const Eigen::Vector3d (&p)[3], const Eigen::Vector3d& o,
                                    const Eigen::Vector3d& d, double near) {
  const Eigen::Vector3d e1 = p[1] - p[0], e2 = p[2] - p[0], h = d.cross(e2);
  const double a = e1.dot(h);
  if (std::abs(a) < 1e-12) return std::nullopt;
  const Eigen::Vector3d from = o - p[0], q = from.cross(e1);
  const double u = from.dot(h) / a, v = d.dot(q) / a, z = e2.dot(q) / a;
  if (u < 1e-9 || v < 1e-9 || u + v > 1.0 - 1e-9 || z < near) return std::nullopt;
  return z;
}

/// Whatever a dense set of rays meets on the curves lies in the boxes and the tiles' times that bounds give.
TEST(Enclosure, TilesAndBoxesLeaveInWhatIsMet) {
  std::size_t met = 0, kept_slefes = 0, kept_hulls = 0;
  for (unsigned seed = 1; seed <= 24; ++seed) {
    const Scene scene = random_scene(seed);
    const SampleSource source(scene, scene.exposure(), 48, 0);
    const FilmView view{projection_of(scene.film, scene.camera.at(scene.exposure().middle())),
                        scene.camera.near, source.reach()};
    const auto followed = MeshPaths::follow(scene, scene.objects[0], scene.exposure(), {});
    ASSERT_TRUE(followed.ok());
    const MeshPaths& paths = *followed;
    const PixelRange film{0, 0, scene.film.width, scene.film.height};
    BlockSamples samples;
    source.fill({0, 0, scene.film.width, scene.film.height}, samples);
    for (std::uint32_t t = 0; t < 3; ++t) {
      MovingTriangle triangle(paths, t, view);
      for (int p = 0; p < paths.pieces(); ++p)
        for (const int tile_px : {1, 2, 4}) {
          const PixelRange range = triangle.pixels(triangle.piece(p), film);
          for (const CurveBounds bounds : {CurveBounds::slefes, CurveBounds::hulls}) {
            if (!range.empty()) triangle.begin_tiles(p, range, tile_px, bounds);
            for (int y = 0; y < scene.film.height; ++y)
              for (int x = 0; x < scene.film.width; ++x) {
                const bool in_range = x >= range.x0 && x < range.x1 && y >= range.y0 && y < range.y1;
                const Span span = in_range ? triangle.tile(x - x % tile_px, y - y % tile_px) : Span{1, 0};
                for (std::size_t i = 0; i < 48; ++i) {
                  const std::size_t k = static_cast<std::size_t>(y * scene.film.width + x) * 48 + i;
                  const double time = double{samples.time[k]};
                  if (paths.piece_of(time) != p) continue;
                  const bool kept = time >= span.begin && time <= span.end;
                  (bounds == CurveBounds::slefes ? kept_slefes : kept_hulls) += kept;
                  Eigen::Vector3d corner[3];
                  for (std::size_t c = 0; c < 3; ++c)
                    corner[c] = paths.at(scene.objects[0].triangles[t][c], p, paths.weights(p, time));
                  const SampleRay ray =
                      ray_of(samples, k, x, y, view.projection, 1.0 / view.projection.focal_px);
                  const Eigen::Vector3d o(ray.from_x, ray.from_y, 0.0), d(ray.x, ray.y, 1.0);
                  if (!meet_triangle(corner, o, d, view.near)) continue;
                  const bool front =
                      (corner[1] - corner[0]).cross(corner[2] - corner[0]).dot(corner[0] - o) < 0.0;
                  if (!scene.objects[0].two_sided && !front) continue;
                  ++met;
                  ASSERT_TRUE(in_range) << seed << ' ' << t << ' ' << p << ' ' << x << ' ' << y;
                  ASSERT_TRUE(kept) << seed << ' ' << t << ' ' << p << ' ' << x << ' ' << y << ' ' << time
                                    << " not in " << span.begin << ' ' << span.end;
                  const PixelRange briefly = triangle.pixels({time, time}, film);
                  ASSERT_TRUE(x >= briefly.x0 && x < briefly.x1 && y >= briefly.y0 && y < briefly.y1);
                }
              }
          }
        }
    }
  }
  EXPECT_GT(met, 100000u);
  EXPECT_LT(kept_slefes, kept_hulls);
  std::printf("%zu met, %zu kept by slefes, %zu by hulls\n", met, kept_slefes, kept_hulls);
}

/// Curves are where the true path is.
TEST(Enclosure, CurvesFollowThePath) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Scene scene = random_scene(seed);
    const Object& object = scene.objects[0];
    const auto followed = MeshPaths::follow(scene, object, scene.exposure(), {});
    ASSERT_TRUE(followed.ok());
    const MeshPaths& paths = *followed;
    const double focal_px = projection_of(scene.film, scene.camera.at(0.5)).focal_px;
    for (int i = 0; i <= 1000; ++i) {
      const double time = i / 1000.0;
      const Instant instant = instant_at(scene, object, scene.exposure(), time);
      const int piece = paths.piece_of(time);
      for (std::uint32_t point = 0; point < 9; ++point) {
        const Eigen::Vector3d truth =
                                  instant.to_camera(surfel_at(object.cloud, point, instant.frame).position),
                              at = paths.at(point, piece, paths.weights(piece, time));
        if (truth.z() < 0.1) continue;
        const double off = focal_px * (at.head<2>() / at.z() - truth.head<2>() / truth.z()).norm();
        // Looked for in two places: a cubic's error is largest 0.21 and 0.79 of the way along, 1.03 of those.
        ASSERT_LT(off, 3.0 * path_tolerance_px) << seed << ' ' << time;
      }
    }
  }
}

/// What a curve may be off by bounds what it is off by, and without the share of depth it would not.
TEST(MovingMeshes, OffThePathIsNoMoreThanItsBoundOnTheFilm) {
  test::Random random(5);
  const Projection film{700.0, 0.0, 0.0};
  std::size_t naive_fails = 0;
  for (int i = 0; i < 100000; ++i) {
    const double z = std::pow(10.0, random(-1.0, 1.0));
    const Eigen::Vector3d truth(z * random(-3.0, 3.0), z * random(-3.0, 3.0), z);
    const Eigen::Vector3d curve = truth + z * std::pow(10.0, random(-6.0, -0.7)) * random.vector(-1.0, 1.0);
    const double off = 700.0 * (curve.head<2>() / curve.z() - truth.head<2>() / truth.z()).norm();
    ASSERT_LE(off, off_path_px(curve, truth, film, 0.01, 1e9) * (1.0 + 1e-6) + 1e-9) << i;
    naive_fails += off > 1.01 * 700.0 * (curve - truth).norm() / truth.z() ? 1 : 0;
  }
  EXPECT_GT(naive_fails, 10000u);
  const Projection parallel{700.0, 0.0, 0.0, true};
  EXPECT_DOUBLE_EQ(off_path_px({1, 2, 3.5}, {1, 2, 3}, parallel, 0.01, 1.0), 350.0);
}

/// Not in two places alone, but at every instant: the curves of the A-buffer on its film, and those of
/// samples beside it too.
TEST(MovingMeshes, StayOnTheirPathsAtEveryInstant) {
  std::size_t on_film = 0, stretches = 0;
  double worst = 0.0, worst_beside = 0.0;
  for (unsigned seed = 1; seed <= 24; ++seed) {
    Scene scene = random_scene(seed);
    // Turned by up to two rounds, and the camera too.
    test::move(scene.objects[0], {0, 0, 0}, {0.3, -0.2, 0.1}, 0.5 * seed);
    const Object& object = scene.objects[0];
    const Exposure even{scene.exposure().open, scene.exposure().close};
    const auto mesh = MovingMesh::follow(scene, object, even, path_tolerance_px, {});
    const auto paths = MeshPaths::follow(scene, object, even, {});
    ASSERT_TRUE(mesh.ok() && paths.ok());
    stretches += mesh->stretches();
    const Projection film = projection_of(scene.film, scene.camera.at(even.middle()));
    const double right = largest_tangent(scene.film, film, 0), top = largest_tangent(scene.film, film, 1);
    std::size_t s = 0;
    for (int i = 0; i <= 2000; ++i) {
      const double time = i / 2000.0;
      while (s + 1 < mesh->stretches() && time >= mesh->time(s + 1)) ++s;
      const double t = (time - mesh->time(s)) / (mesh->time(s + 1) - mesh->time(s));
      const Instant instant = instant_at(scene, object, even, time);
      const int piece = paths->piece_of(time);
      for (std::uint32_t point = 0; point < 9; ++point) {
        const Eigen::Vector3d truth =
            instant.to_camera(surfel_at(object.cloud, point, instant.frame).position);
        if (truth.z() < 0.1) continue;
        const Eigen::Vector2d seen = truth.head<2>() / truth.z();
        const auto off = [&](const Eigen::Vector3d& at) {
          return film.focal_px * (at.head<2>() / at.z() - seen).norm();
        };
        if (seen.norm() <= path_tangent)
          worst_beside = std::max(worst_beside, off(paths->at(point, piece, paths->weights(piece, time))));
        if (std::abs(seen.x()) > right || std::abs(seen.y()) > top) continue;
        ++on_film;
        Eigen::Vector3d control[most_path_degree + 1];
        std::copy(mesh->path(s, point), mesh->path(s, point) + mesh->degree() + 1, control);
        for (int level = mesh->degree(); level > 0; --level)
          for (int k = 0; k < level; ++k) control[k] += t * (control[k + 1] - control[k]);
        worst = std::max(worst, off(control[0]));
      }
    }
  }
  EXPECT_GT(on_film, 50000u);
  EXPECT_LE(worst, path_tolerance_px);
  EXPECT_LE(worst_beside, path_tolerance_px);
  std::printf("%zu stretches, %zu points on the film: off by %.2g px, beside it %.2g px\n", stretches,
              on_film, worst, worst_beside);
}

}  // namespace
}  // namespace swept::stochastic
