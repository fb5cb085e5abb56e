// Which packets a cell is given, against the pixels that their discs really cover at very many instants.
#include "abuffer/tiles/cells.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/small_scenes.h"

namespace swept {
namespace {

/// Small packets here and there, on a film of 7 × 5 cells.
Scene sparse_stage(unsigned seed, double extent) {
  Scene scene = test::stage();
  scene.film = {448, 320, 0, 0, 0, 0};
  Object& object = scene.objects.emplace_back();
  test::Random random(seed);
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector3d middle = random.vector(-extent, extent);
    for (int k = 0; k < packet_size; ++k)
      test::add_disc(object, middle + random.vector(-0.02, 0.02), random.vector(-1.0, 1.0).normalized(),
                     random(0.005, 0.03));
  }
  return scene;
}

/// Counts pixels of discs in cells that do not know of their packet, out of all that were looked at.
std::pair<int, int> unknown_pixels(const Scene& scene, int instants) {
  const Exposure exposure = scene.exposure();
  const std::vector<PointPackets> objects = pack_points(scene, exposure);
  const PacketBins bins(scene, exposure, objects);
  std::set<std::pair<std::size_t, std::size_t>> known;
  for (std::size_t cell = 0; cell < bins.cell_count(); ++cell)
    for (const PacketRef packet : bins.packets(cell)) known.insert({cell, packet.packet});
  const auto columns = static_cast<std::size_t>((scene.film.width + cell_px - 1) / cell_px);
  int unknown = 0, seen = 0;
  for (int i = 0; i < instants; ++i) {
    const ObjectInstant at(scene, objects[0], exposure.at((i + 0.5) / instants));
    for (std::size_t p = 0; p < objects[0].count; ++p)
      for (std::size_t lane = 0; lane < packet_size; lane += 5) {
        const auto disc =
            GeneralDisc::make(scene, scene.objects[0], at, objects[0].points[p * packet_size + lane]);
        if (!disc) continue;
        const int x_begin = std::max(disc->x_begin, 0), x_end = std::min(disc->x_end, scene.film.width);
        const int y_begin = std::max(disc->y_begin, 0), y_end = std::min(disc->y_end, scene.film.height);
        const int step = 1 + std::max(x_end - x_begin, y_end - y_begin) / 6;
        for (int y = y_begin; y < y_end; y += step)
          for (int x = x_begin; x < x_end; x += step) {
            if (!disc->meet(x, y)) continue;
            ++seen;
            const std::size_t cell =
                static_cast<std::size_t>(y / cell_px) * columns + static_cast<std::size_t>(x / cell_px);
            unknown += known.count({cell, p}) == 0 ? 1 : 0;
          }
      }
  }
  return {unknown, seen};
}

void expect_known(const Scene& scene, const std::string& what, int instants = 600) {
  ASSERT_TRUE(scene.validate()) << what << ": " << scene.validate().error().message();
  const auto [unknown, seen] = unknown_pixels(scene, instants);
  EXPECT_EQ(unknown, 0) << what << ", of " << seen;
  EXPECT_GT(seen, 50) << what << ": there is little to see";
}

TEST(Cells, KnowWhatTurnsAndFlies) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    Scene scene = sparse_stage(seed, 1.6);
    test::Random random(seed + 100);
    test::move(scene.objects[0], random.vector(-2.0, 2.0), random.vector(-2.0, 2.0), random(0.0, 9.0));
    expect_known(scene, "seed " + std::to_string(seed));
  }
}

TEST(Cells, KnowWhatSpins) {
  for (const double radians : {100.0, 3000.0, 1e5}) {
    Scene scene = sparse_stage(3, 1.6);
    test::move(scene.objects[0], {0.0, 0.0, 0.0}, {0.5, 0.0, 0.0}, radians);
    expect_known(scene, std::to_string(radians) + " rad");
  }
}

/// Past the eye: in front of it only for a part of the exposure.
TEST(Cells, KnowWhatPassesTheNearPlane) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    Scene scene = sparse_stage(seed, 0.5);
    scene.camera.near = 0.01;
    test::Random random(seed + 200);
    const Eigen::Vector3d behind(random(-0.5, 0.5), random(-0.5, 0.5), random(5.3, 9.0)),
        front(random(-3.0, 3.0), random(-3.0, 3.0), random(-20.0, 0.0));
    if (seed % 2 == 0)
      test::move(scene.objects[0], behind, front);
    else
      test::move(scene.objects[0], front, behind, seed % 3 == 0 ? 1.0 : 0.0);
    expect_known(scene, "seed " + std::to_string(seed));
  }
}

/// A floor that begins behind the eye and stands still.
TEST(Cells, AreSparedWhatStandsBelowTheEye) {
  Scene scene = test::stage();
  scene.film = {448, 320, 0, 0, 0, 0};
  scene.camera.near = 0.05;
  Object& floor = scene.objects.emplace_back();
  for (int z = 0; z < 80; ++z)
    for (int x = 0; x < 80; ++x)
      test::add_disc(floor, {0.1 * (x - 40), -1.5, 7.0 - 0.1 * z}, {0.0, 1.0, 0.0}, 0.07);
  expect_known(scene, "floor");

  const Exposure exposure = scene.exposure();
  const std::vector<PointPackets> objects = pack_points(scene, exposure);
  const PacketBins bins(scene, exposure, objects);
  const ObjectInstant at(scene, objects[0], exposure.open);
  std::set<std::uint32_t> through, known;
  for (std::uint32_t p = 0; p < objects[0].count; ++p)
    if (std::abs(at.center(objects[0], p).z() - scene.camera.near) < double{objects[0].radius[p]})
      through.insert(p);
  for (std::size_t cell = 0; cell < bins.cell_count(); ++cell)
    for (const PacketRef packet : bins.packets(cell)) known.insert(packet.packet);
  EXPECT_GE(through.size(), 5u);
  EXPECT_GE(known.size(), 50u);
  for (const std::uint32_t p : through) EXPECT_EQ(known.count(p), 0u) << "packet " << p;
}

TEST(Cells, KnowWhatACameraLooksAtAsItPassesBy) {
  for (const double distance : {1.0, 0.1, 0.01, 0.001}) {
    Scene scene = sparse_stage(5, 1.5);
    scene.camera.near = 0.01;
    scene.camera.look_ats.resize(2);
    scene.camera.look_ats[0].eye = {-3.0, 0.0, distance};
    scene.camera.look_ats[1].eye = {2.0, 0.0, distance};
    scene.camera.look_ats[1].frame = 1.0;
    expect_known(scene, std::to_string(distance), 2001);
  }
}

TEST(Cells, KnowWhatATurningCameraSees) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    Scene scene = sparse_stage(seed, 3.0);
    scene.camera.look_ats.clear();
    test::Random random(seed + 300);
    for (int k = 0; k < 4; ++k) {
      CameraKey key;
      key.frame = 0.3 * k;
      key.eye = random.vector(-1.0, 1.0);
      key.world_from_camera = Eigen::AngleAxisd(random(-3.0, 3.0), random.vector(-1.0, 1.0).normalized());
      key.tan_half_fov_y = random(0.1, 1.5);
      scene.camera.poses.push_back(key);
    }
    expect_known(scene, "seed " + std::to_string(seed));
  }
}

TEST(Cells, KnowKeyedPointsWhoseKeysAreDense) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    Scene scene = sparse_stage(seed, 1.0);
    SurfelCloud& cloud = scene.objects[0].cloud;
    test::Random random(seed + 400);
    const SurfelPose first = cloud.keys[0].pose;
    for (int k = 1; k < 6; ++k) {
      SurfelKey key{0.05 + 0.3 * k * random(0.8, 1.1), first};
      const Eigen::Vector3d jump = random.vector(-2.5, 2.5);
      for (Eigen::Vector3d& p : key.pose.position) p += jump;
      cloud.keys.push_back(std::move(key));
    }
    expect_known(scene, "seed " + std::to_string(seed));
  }
}

}  // namespace
}  // namespace swept
