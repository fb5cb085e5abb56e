// Points packed for a cell by themselves: none that passes by is missing, there are fewer of them than
// packets would bring, and the picture is the same.
#include "abuffer/tiles/point_lists.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/lens_looks.h"
#include "abuffer/resolve/sampled_cell.h"
#include "abuffer/sampled.h"
#include "abuffer/sources/instant_table.h"

namespace swept {
namespace {

/// A burst of 1500 discs, some of them large, each of which flies its own way, `accelerated` on curves, by
/// about 100 px of 512 × 384; some fly past the eye. Not all have a front, and they let light through.
Scene burst(bool accelerated) {
  Scene scene;
  scene.film = {512, 384, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  CameraKey pose;
  pose.eye = {0.0, 0.0, -5.0};
  scene.camera.poses.push_back(pose);
  scene.camera.near = 0.125;
  std::mt19937 bits(3);
  const auto number = [&] { return static_cast<double>(bits()) * 0x1p-31 - 1.0; };
  const auto vector = [&] { return Eigen::Vector3d(number(), number(), number()); };
  Object object;
  SurfelCloud& cloud = object.cloud;
  SurfelPose discs;
  for (int i = 0; i < 1500; ++i) {
    discs.position.emplace_back(1.5 * vector());
    const Eigen::Vector3d normal = vector().normalized(), side = normal.unitOrthogonal();
    const double size = i % 25 == 0 ? 0.3 : 0.02;
    discs.axis_u.push_back((size * side).cast<float>());
    discs.axis_v.push_back((0.75 * size * normal.cross(side)).cast<float>());
    cloud.velocity.push_back(((i % 50 == 0 ? 8.0 : 1.5) * vector()).cast<float>());
    if (accelerated) cloud.acceleration.push_back((2.0 * vector()).cast<float>());
    cloud.color.emplace_back(static_cast<float>(i + 1) / 1500.0f, 0.5f, 0.25f);
    cloud.opacity.push_back(0.75f);
    cloud.oriented.push_back(i % 2 == 0 ? 1 : 0);
  }
  cloud.keys.push_back({0.0, std::move(discs)});
  scene.objects.push_back(std::move(object));
  return scene;
}

/// A scene as the engine has it.
struct Prepared {
  Scene scene;
  Exposure exposure;
  std::vector<PointPackets> objects;
  PacketBins bins;
  PointLists lists;

  explicit Prepared(Scene of)
      : scene(std::move(of)),
        exposure(scene.exposure()),
        objects(pack_points(scene, exposure)),
        bins(scene, exposure, objects),
        lists(scene, exposure, objects, bins) {}
};

/// `scene` with discs so much larger, the filter included.
Scene enlarged(Scene scene, double by) {
  SurfelPose& discs = scene.objects[0].cloud.keys[0].pose;
  for (std::size_t i = 0; i < discs.size(); ++i) {
    discs.axis_u[i] *= static_cast<float>(by);
    discs.axis_v[i] *= static_cast<float>(by);
  }
  scene.model.filter_radius_px *= by;
  return scene;
}

/// `scene` with discs elsewhere.
Scene moved(Scene scene, const Eigen::Vector3d& by) {
  for (Eigen::Vector3d& position : scene.objects[0].cloud.keys[0].pose.position) position += by;
  return scene;
}

/// A scene and one that hardly differs: what its discs bring to a pixel, in double.
class Neighbours {
 public:
  Neighbours(const Scene& a, const Scene& b)
      : scenes_{a, b},
        exposure_(a.exposure()),
        objects_{pack_points(scenes_[0], exposure_), pack_points(scenes_[1], exposure_)} {}

  struct Difference {
    int discs = 0;        ///< that only one of the two has there
    double weight = 0.0;  ///< by which those of both differ, all together
  };
  [[nodiscard]] Difference at(int x, int y, double frame) const {
    Difference sum;
    const ObjectInstant instants[2] = {{scenes_[0], objects_[0][0], frame},
                                       {scenes_[1], objects_[1][0], frame}};
    for (std::uint32_t i = 0; i < scenes_[0].objects[0].cloud.size(); ++i) {
      std::optional<GeneralDisc::Fragment> found[2];
      for (int k = 0; k < 2; ++k)
        if (const auto disc = GeneralDisc::make(scenes_[k], scenes_[k].objects[0], instants[k], i))
          found[k] = disc->meet(x, y);
      sum.discs += found[0].has_value() != found[1].has_value() ? 1 : 0;
      if (found[0] && found[1])
        sum.weight += std::abs(static_cast<double>(found[0]->weight) - static_cast<double>(found[1]->weight));
    }
    return sum;
  }

 private:
  Scene scenes_[2];
  Exposure exposure_;
  std::vector<PointPackets> objects_[2];
};

/// What rounding may change in a scene's pixel.
class Rounding {
 public:
  explicit Rounding(const Scene& scene) : rims_(enlarged(scene, 1.0 - 1e-4), enlarged(scene, 1.0 + 1e-4)) {
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d by = rounding * Eigen::Vector3d::Unit(axis);
      places_.emplace_back(moved(scene, -by), moved(scene, by));
    }
  }

  /// Discs whose rim goes through the centre of the film's pixel at a frame, to 10⁻⁴ of their size.
  [[nodiscard]] int rims(int x, int y, double frame) const { return rims_.at(x, y, frame).discs; }
  /// By how much the weights there change, all together, with places that are rounded.
  [[nodiscard]] double weights(int x, int y, double frame) const {
    double sum = 0.0;
    for (const Neighbours& place : places_) sum += place.at(x, y, frame).weight;
    return sum;
  }

 private:
  /// Of a float in a packet of burst(), all of whose points are within 16 of each other: a place and the way
  /// from there.
  static constexpr double rounding = 2 * 16 * 0x1p-24;
  Neighbours rims_;
  std::vector<Neighbours> places_;
};

class PointListsOf : public testing::TestWithParam<bool> {};

TEST_P(PointListsOf, HoldEveryPointThatPassesBy) {
  const Prepared of(burst(GetParam()));
  std::size_t cells = 0, wide = 0, packets = 0;
  std::vector<std::set<std::uint32_t>> listed(of.bins.cell_count());
  for (std::size_t c = 0; c < of.bins.cell_count(); ++c) {
    const std::optional<CellPackets> found = of.lists.of(c);
    if (!found) continue;
    ++cells;
    wide += of.bins.packets(c).size();
    packets += found->refs.size();
    for (const PacketRef ref : found->refs) {
      const PointPackets& object = *found->objects[ref.object];
      for (std::uint32_t lane = 0; lane < packet_size; ++lane)
        if (object.lanes[ref.packet] >> lane & 1u) {
          EXPECT_TRUE(listed[c].insert(object.points[ref.packet * packet_size + lane]).second) << "twice";
        }
    }
  }
  EXPECT_GE(2 * cells, of.bins.cell_count());
  EXPECT_LE(3 * packets, 2 * wide);
  std::size_t seen = 0, general = 0;
  for (int k = 0; k <= 64; ++k) {
    const ObjectInstant at(of.scene, of.objects[0], of.exposure.at(k / 64.0));
    for (std::uint32_t i = 0; i < 1500; ++i) {
      const auto disc = GeneralDisc::make(of.scene, of.scene.objects[0], at, i);
      if (!disc) continue;
      for (std::size_t c = 0; c < of.bins.cell_count(); ++c) {
        const Cell cell = of.bins.cell(c);
        if (listed[c].empty() || disc->x_begin >= cell.x + cell.width || disc->x_end <= cell.x ||
            disc->y_begin >= cell.y + cell.height || disc->y_end <= cell.y)
          continue;
        ++seen;
        EXPECT_EQ(listed[c].count(i), 1u) << "point " << i << " at " << k << " in cell " << c;
      }
      general += disc->x_end - disc->x_begin > 64 ? 1 : 0;
    }
  }
  EXPECT_GT(seen, 50'000u);
  EXPECT_GT(general, 0u) << "nothing comes near the eye";
}

TEST_P(PointListsOf, DrawWhatThePacketsDraw) {
  const Prepared of(burst(GetParam()));
  const Rounding rounding(of.scene);
  const LensLooks no_lens;
  InstantTable table(of.scene, of.exposure, of.objects, no_lens);
  SampledCell renderer(of.scene, of.objects, sampled_maths().widest());
  // Most that a pixel gains by a weight of one.
  const double gain = static_cast<double>(of.scene.objects[0].cloud.opacity[0]) / of.scene.model.edge_weight;
  // At its rim a disc's weight ends at exp(−δ): a pixel whose centre is there may have it or not.
  const double rim = gain * std::exp(-of.scene.model.delta);
  double light = 0.0;
  std::size_t flips = 0, values = 0;
  for (std::size_t c = 0; c < of.bins.cell_count(); ++c) {
    const Cell cell = of.bins.cell(c);
    for (int k = 0; k < 5; ++k) {
      std::optional<CellPackets> own = of.lists.of(c);
      if (!own) continue;
      CellImage images[2];
      renderer.begin(cell, of.bins.packets(c));
      renderer.add(*table.at(2 * k + 1, 10, 0), {});
      renderer.image(1.0, images[0]);
      renderer.begin(cell, *std::move(own));
      renderer.add(*table.at(2 * k + 1, 10, 0), {});
      renderer.image(1.0, images[1]);
      for (std::size_t i = 0; i < images[0].rgba.size(); ++i) {
        const double off = std::abs(images[0].rgba[i] - images[1].rgba[i]);
        light += images[0].rgba[i];
        values += images[0].rgba[i] > 0.0 ? 1 : 0;
        if (off <= 1e-4) continue;
        // Centres are floats from another origin.
        const int x = cell.x + static_cast<int>(i / 4) % cell_px,
                  y = cell.y + static_cast<int>(i / 4) / cell_px;
        const double frame = of.exposure.at((2 * k + 1) / 10.0);
        if (off <= gain * rounding.weights(x, y, frame)) continue;
        ++flips;
        EXPECT_LE(off, rim);
        EXPECT_GE(rounding.rims(x, y, frame), 1)
            << "pixel " << x << ", " << y << " at instant " << k << " is off by " << off;
      }
    }
  }
  EXPECT_GT(light, 500.0);
  EXPECT_LE(flips, values / 10'000) << "of " << values;
}

INSTANTIATE_TEST_SUITE_P(Paths, PointListsOf, testing::Values(false, true));

TEST(PointLists, LeaveAloneWhatStaysTogether) {
  Scene scene = burst(false);
  SurfelCloud& cloud = scene.objects[0].cloud;
  for (Eigen::Vector3f& velocity : cloud.velocity) velocity = {1.0f, 0.5f, 0.0f};
  SurfelPose& discs = cloud.keys[0].pose;
  for (std::size_t i = 0; i < discs.size(); ++i) {
    discs.position[i] *= 0.1;
    discs.axis_u[i] = discs.axis_u[1];
    discs.axis_v[i] = discs.axis_v[1];
  }
  const Prepared of(std::move(scene));
  for (std::size_t c = 0; c < of.bins.cell_count(); ++c) EXPECT_FALSE(of.lists.of(c));
}

TEST(PointLists, ChangeNoBitWithThreadsCropsAndOrder) {
  const Scene scene = burst(true);
  const Result<Rendered> whole = render_sampled(scene, {}, {1});
  ASSERT_TRUE(whole);
  const Result<Rendered> threads = render_sampled(scene, {}, {2});
  ASSERT_TRUE(threads);
  EXPECT_EQ(threads->image.rgba, whole->image.rgba);

  Scene shuffled = scene;
  std::vector<std::size_t> order(1500);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(11));
  const SurfelCloud& from = scene.objects[0].cloud;
  SurfelCloud& to = shuffled.objects[0].cloud;
  for (std::size_t i = 0; i < order.size(); ++i) {
    to.keys[0].pose.position[i] = from.keys[0].pose.position[order[i]];
    to.keys[0].pose.axis_u[i] = from.keys[0].pose.axis_u[order[i]];
    to.keys[0].pose.axis_v[i] = from.keys[0].pose.axis_v[order[i]];
    to.velocity[i] = from.velocity[order[i]];
    to.acceleration[i] = from.acceleration[order[i]];
    to.color[i] = from.color[order[i]];
    to.oriented[i] = from.oriented[order[i]];
  }
  const Result<Rendered> again = render_sampled(shuffled);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->image.rgba, whole->image.rgba);

  Scene crop = scene;
  crop.film = {512, 384, 70, 50, 90, 100};
  const Result<Rendered> part = render_sampled(crop);
  ASSERT_TRUE(part);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 90; ++x)
      for (int k = 0; k < 4; ++k)
        ASSERT_EQ(
            part->image.rgba[4 * static_cast<std::size_t>(y * 90 + x) + static_cast<std::size_t>(k)],
            whole->image
                .rgba[4 * static_cast<std::size_t>((y + 50) * 512 + x + 70) + static_cast<std::size_t>(k)]);
}

}  // namespace
}  // namespace swept
