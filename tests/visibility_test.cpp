// Which triangle is seen where and when: intervals beside plain instants, and intervals that are merged.
#include "abuffer/visibility.h"

#include <cstdlib>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/counter.h"
#include "tests/drawn.h"
#include "tests/splat_scenes.h"
#include "tools/study/mesh_tables.h"

namespace swept {
namespace {

using test::psnr_db;

/// Small triangles before and behind each other, each going its own way; some through the eye.
Scene swarm(int triangles, unsigned seed, bool transparent = false) {
  Scene scene;
  scene.film = {40, 30, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats = {test::looking_along_z(0.0, {0, 0, 0}, {0, 0, 1}, 60.0)};
  scene.camera.near = 0.1;
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  Object& object = scene.objects.emplace_back();
  object.cloud.keys.resize(1);
  SurfelPose& pose = object.cloud.keys[0].pose;
  for (int t = 0; t < triangles; ++t) {
    const Eigen::Vector3d middle(uniform(-1.5, 1.5), uniform(-1.0, 1.0), uniform(-0.1, 5.0));
    const Eigen::Vector3f color(static_cast<float>(uniform(0, 1)), static_cast<float>(uniform(0, 1)), 0.5f);
    for (int i = 0; i < 3; ++i) {
      pose.position.push_back(middle +
                              Eigen::Vector3d(uniform(-0.4, 0.4), uniform(-0.4, 0.4), uniform(-0.4, 0.4)));
      pose.axis_u.emplace_back(0.1f, 0.0f, 0.0f);
      pose.axis_v.emplace_back(0.0f, 0.1f, 0.0f);
      object.cloud.color.push_back(color);
      object.cloud.velocity.emplace_back(static_cast<float>(uniform(-1, 1)),
                                         static_cast<float>(uniform(-1, 1)),
                                         static_cast<float>(uniform(-1, 1)));
      if (transparent) object.cloud.opacity.push_back(static_cast<float>(uniform(0.2, 1.0)));
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    object.triangles.push_back({first, first + 1, first + 2});
  }
  return scene;
}

const std::vector<double> times = {0.03, 0.21, 0.34, 0.55, 0.71, 0.96};

Rendered exact(const Scene& scene, std::size_t most, int tile_px = 32, std::size_t held = 1u << 20) {
  AbufferOptions options;
  options.place_intervals = most;
  options.tile_px = tile_px;
  options.tile_fragments = held;
  return test::value_of(render_abuffer(scene, options));
}

TEST(VisibilityAccuracy, OfIntervalsIsThatOfRays) {
  for (const bool turning : {false, true})
    for (unsigned seed = 1; seed <= 4; ++seed) {
      Scene scene = swarm(60, seed, seed % 2 == 0);
      scene.objects[0].two_sided = seed != 3;
      // Of several meshes that share pixels, too.
      scene.objects.push_back(swarm(20, seed + 50).objects[0]);
      if (turning) {
        TransformKey open, close;
        close.frame = 1.0;
        open.rotate_axis = close.rotate_axis = Eigen::Vector3d(0.1, 0.2, 1.0).normalized();
        close.rotate_radians = 0.8;
        scene.objects[0].transform.keys = {open, close};
      }
      const VisibleTriangles truth = test::value_of(visible_at_instants(scene, times)),
                             named = test::value_of(visible_by_intervals(scene, times));
      const VisibilityAccuracy accuracy = visibility_accuracy(truth, named);
      EXPECT_GT(accuracy.samples, 10000u);
      // Parabolas in place of arcs, by 0.01 px, may name a neighbour.
      EXPECT_GT(accuracy.share(), turning ? 0.999 : 0.99999) << seed;
    }
}

TEST(VisibilityAccuracy, FallsWhereInstantsAreOthers) {
  const Scene scene = swarm(60, 1);
  const VisibleTriangles truth = test::value_of(visible_at_instants(scene, times)),
                         late = test::value_of(
                             visible_by_intervals(scene, {0.05, 0.23, 0.36, 0.57, 0.73, 0.98}));
  EXPECT_LT(visibility_accuracy(truth, late).share(), 0.97);
  EXPECT_GT(visibility_accuracy(truth, late).share(), 0.5);
}

TEST(VisibilityAccuracy, RefusesByNameWhatItDoesNotMeasure) {
  Scene scene = swarm(3, 1);
  EXPECT_FALSE(visible_by_intervals(scene, {0.5, 0.4}).ok());
  EXPECT_FALSE(visible_at_instants(scene, {1.0}).ok());
  scene.objects.push_back(scene.objects[0]);
  scene.objects.back().triangles.clear();
  const Result<VisibleTriangles> discs = visible_at_instants(scene, {0.5});
  ASSERT_FALSE(discs.ok());
  EXPECT_EQ(discs.error().field, "/objects/1");
}

TEST(TileTests, ChangeNoBitOfAMesh) {
  Scene scene = swarm(300, 8);
  scene.film.width = 20, scene.film.height = 15;
  AbufferOptions plain;
  plain.tile_tests = false;
  const Rendered all = test::value_of(render_abuffer(scene, plain)), tested = exact(scene, 0);
  EXPECT_EQ(tested.image.rgba, all.image.rgba);
  EXPECT_EQ(tested.image.depth, all.image.depth);
  EXPECT_LT(test::counter(tested, "fragments"), 0.9 * test::counter(all, "fragments"));
}

TEST(TileTests, ChangeNothingButRoundingWhereMeshesShareAPixel) {
  for (const bool transparent : {false, true}) {
    Scene scene = swarm(60, 8, transparent);
    scene.film.width = 20, scene.film.height = 15;
    scene.objects.push_back(swarm(60, 9).objects[0]);
    AbufferOptions plain;
    plain.tile_tests = false;
    const Rendered all = test::value_of(render_abuffer(scene, plain)), tested = exact(scene, 0);
    // Sums of some 100 floats' worth of pieces, in another order.
    for (std::size_t i = 0; i < all.image.rgba.size(); ++i)
      ASSERT_NEAR(tested.image.rgba[i], all.image.rgba[i], 1e-6) << i;
    EXPECT_LT(test::counter(tested, "fragments"), test::counter(all, "fragments"));
  }
}

TEST(LossyIntervals, OfAsManyAsThereAreChangeNothing) {
  const Scene scene = swarm(80, 3);
  EXPECT_EQ(exact(scene, 65536).image.rgba, exact(scene, 0).image.rgba);
}

TEST(LossyIntervals, DoNotDependOnTiles) {
  Scene scene = swarm(150, 4, true);
  scene.objects.push_back(swarm(20, 5).objects[0]);
  const Rendered whole = exact(scene, 3);
  EXPECT_EQ(exact(scene, 3, 7).image.rgba, whole.image.rgba);
  EXPECT_EQ(exact(scene, 3, 32, 2000).image.rgba, whole.image.rgba);
}

TEST(LossyIntervals, CostLessTheMoreThereAre) {
  const Scene scene = swarm(400, 6);
  const Image all = exact(scene, 0).image;
  const VisibleTriangles truth = test::value_of(visible_at_instants(scene, times));
  double db = 0.0, share = 0.0;
  for (const std::size_t most : {1, 2, 4, 8, 16}) {
    const Rendered few = exact(scene, most);
    EXPECT_LE(test::counter(few, "fragments_in_fullest_pixel"), 16.0 * static_cast<double>(most));
    AbufferOptions options;
    options.place_intervals = most;
    const double better = psnr_db(few.image, all),
                 seen =
                     visibility_accuracy(truth, test::value_of(visible_by_intervals(scene, times, options)))
                         .share();
    EXPECT_GT(better, db) << most;
    EXPECT_GT(seen, share) << most;
    db = better, share = seen;
  }
  EXPECT_GT(db, 45.0);
  EXPECT_GT(share, 0.99);
}

TEST(LossyIntervals, AreOfTriangles) {
  Scene scene = swarm(3, 1);
  scene.objects[0].triangles.clear();
  AbufferOptions options;
  options.place_intervals = 4;
  const Result<Rendered> rendered = render_abuffer(scene, options);
  ASSERT_FALSE(rendered.ok());
  EXPECT_EQ(rendered.error().field, "place_intervals");
}

TEST(MeshTables, DropLooksThatChange) {
  Object object = swarm(3, 2).objects[0];
  SurfelCloud& cloud = object.cloud;
  for (const double frame : {0.0, 1.0}) cloud.looks.push_back({frame, cloud.color, {}});
  make_flat(object);
  EXPECT_TRUE(cloud.looks.empty());
  EXPECT_EQ(cloud.color.size(), cloud.size());
  const Status valid = cloud.validate();
  EXPECT_TRUE(valid.ok()) << valid.error().message();
}

TEST(MeshTables, AreMeasuredOnMadeUpScenes) {
  std::vector<TraversalScene> scenes = {{"swarm", "", swarm(40, 2)}, {"none", "", {}, "no such file"}};
  for (Object& object : scenes[0].scene.objects) make_flat(object);
  std::size_t calls = 0;
  const auto done = [&](const StudyTable&) { ++calls; };
  const StudyTable table = visibility_table(
      scenes, {.side_px = 24, .stills = 64, .quick = true, .triangles = {}, .motions_px = {}}, done);
  ASSERT_EQ(table.rows.size(), 8u);
  EXPECT_EQ(calls, 8u);
  EXPECT_EQ(table.failed, 1u);
  EXPECT_EQ(table.rows[0][1], "all");
  EXPECT_GT(table.rows[0][2].get<double>(), 99.9);
  EXPECT_EQ(table.rows[7][1], "no such file");
  EXPECT_NE(markdown(table).find("| swarm | all |"), std::string::npos);
  EXPECT_EQ(to_json(table)["rows"][0].size(), table.columns.size());
}

}  // namespace
}  // namespace swept
