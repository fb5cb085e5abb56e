// Motion as files have it: splines through numbered files, rates of every order, points that come and go by
// id, time stamps.
#include <cmath>

#include "splat/io/cloud_source.h"
#include "splat/io/scene_file.h"
#include "splat/motion/look.h"
#include "tests/point_files.h"
#include "tests/point_reports.h"

namespace {

using namespace swept;
using Eigen::Vector3d;
using Eigen::Vector3f;
using swept_test::float_ply;
using swept_test::has_part;
using swept_test::joined;
using Rows = std::vector<std::vector<double>>;

const std::vector<std::string> with_ids{"x", "y", "z", "nx", "ny", "nz", "radius", "id"};
const std::vector<std::string> bare{"x", "y", "z", "nx", "ny", "nz", "radius"};

class MovingPointFiles : public swept_test::PointFiles {
 protected:
  void add(const std::vector<std::string>& names, const Rows& rows) {
    const std::string name = "k" + std::to_string(files_.size()) + ".ply";
    files_.push_back(
        {static_cast<double>(files_.size()), write(name, float_ply("binary_little_endian", names, rows))});
  }
  [[nodiscard]] CloudSource source() const {
    CloudSource source;
    source.files = files_;
    return source;
  }
  /// The only cloud of a scene at its frame.
  Result<SurfelCloud> cloud_of(const std::string& members, const std::string& object) {
    const std::string text =
        R"({"swept": 1, "film": {"width": 64, "height": 48}, "camera": {"fov": {"axis": "vertical", "degrees": 40},
            "keys": [{"eye": [0,0,5], "target": [0,0,0]}]}, )" +
        members + R"("objects": [{"source": )" + object + "}]}";
    Result<SceneFile> file = scene_from_text(text, folder_ / "scene.json");
    if (!file) return file.error();
    scene_.emplace(*std::move(file));
    const auto no_generator = [](const std::string&, std::size_t, const std::map<std::string, double>&) {
      return Result<SurfelCloud>(Error{"", "generator", "none"});
    };
    const Result<const Scene*> scene = scene_->scene_at(scene_->scene().frame, no_generator);
    if (!scene) return scene.error();
    return (*scene)->objects[0].cloud;
  }

  std::vector<KeyFile> files_;
  std::optional<SceneFile> scene_;
};

double x_at(const SurfelCloud& cloud, std::size_t i, double frame) {
  return surfel_at(cloud, i, frame).position.x();
}

TEST_F(MovingPointFiles, ASplineReadsTheKeysBesideThoseThatItRunsBetween) {
  // x is (n − 2)², whose spline is a parabola.
  for (int n = 0; n < 6; ++n) {
    const double x = (n - 2.0) * (n - 2.0);
    write("p" + std::to_string(n) + ".ply", float_ply("ascii", bare, {{x, 0, 0, 0, 0, 1, 0.1}}));
  }
  const std::string sequence = R"({"sequence": "p%d.ply", "first": 0, "last": 5})";
  for (const double frame : {0.3, 2.5, 4.75}) {
    const std::string at =
        R"("frame": )" + std::to_string(frame) + R"(, "shutter": {"open": -0.2, "close": 0.2}, )";
    const auto spline = cloud_of(at + R"("motion": {"path": "spline"}, )", sequence);
    ASSERT_TRUE(spline.ok()) << spline.error().message();
    EXPECT_EQ(spline->path, KeyPath::spline);
    EXPECT_GE(spline->keys.size(), 3u);
    for (const double later : {-0.2, 0.0, 0.2})
      EXPECT_NEAR(x_at(*spline, 0, frame + later), std::pow(frame + later - 2.0, 2), 1e-9);
    const auto linear = cloud_of(at, sequence);
    ASSERT_TRUE(linear.ok());
    EXPECT_EQ(linear->path, KeyPath::linear);
    EXPECT_EQ(linear->keys.size(), 2u);
  }
  // Once round: the key before the first is the last.
  const auto cyclic = cloud_of(R"("frame": 0, "motion": {"path": "spline"}, )",
                               R"({"sequence": "p%d.ply", "first": 0, "last": 5, "cycle": true})");
  ASSERT_TRUE(cyclic.ok()) << cyclic.error().message();
  EXPECT_EQ(cyclic->keys.front().frame, -2.0);
  EXPECT_EQ(cyclic->keys.front().pose.position[0].x(), 4.0);
  const auto wrong = cloud_of(R"("motion": {"path": "curly"}, )", sequence);
  ASSERT_FALSE(wrong.ok());
  EXPECT_EQ(wrong.error().field, "/motion/path");
}

TEST_F(MovingPointFiles, AccelerationAndAngularVelocityAreRead) {
  std::vector<std::string> names = bare;
  for (const char* name : {"vx", "vy", "vz", "ax", "ay", "az", "wx", "wy", "wz"}) names.emplace_back(name);
  add(names, {{0, 0, 0, 0, 0, 1, 0.1, 24, 0, 0, 0, 576, 0, 0, 0, 48}});
  const auto loaded = read_cloud(source(), 0.0, 0.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  // Per second at 24 frames per second.
  EXPECT_EQ(loaded->cloud.velocity[0], Vector3f(1, 0, 0));
  EXPECT_EQ(loaded->cloud.acceleration[0], Vector3f(0, 1, 0));
  EXPECT_EQ(loaded->cloud.angular_velocity[0], Vector3f(0, 0, 2));
  EXPECT_EQ(loaded->report.properties_of("acceleration"), (std::vector<std::string>{"ax", "ay", "az"}));
  EXPECT_LT((surfel_at(loaded->cloud, 0, 2.0).position - Vector3d(2, 2, 0)).norm(), 1e-12);
  CloudSource other = source();
  other.velocity_unit = VelocityUnit::per_frame;
  EXPECT_EQ(read_cloud(other, 0, 0)->cloud.acceleration[0], Vector3f(0, 576, 0));
  other.velocity_unit = VelocityUnit::ignore;
  EXPECT_FALSE(read_cloud(other, 0, 0)->cloud.moves());
  add(names, {{0, 0, 0, 0, 0, 1, 0.1, 24, 0, 0, NAN, 576, 0, 0, 0, 48}});
  CloudSource bad;
  bad.files = {files_.back()};
  const auto refused = read_cloud(bad, 0, 0);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "ax");
  EXPECT_EQ(refused.error().file, files_.back().path);
}

TEST_F(MovingPointFiles, PointsComeAndGoHalfwayBetweenFiles) {
  std::vector<std::string> names = with_ids;
  for (const char* name : {"vx", "vy", "vz", "red", "green", "blue"}) names.emplace_back(name);
  // Point 7 stays; 8 goes after the second file; 9 comes with the third; 7 and 8 change places.
  add(names, {{0, 0, 0, 0, 0, 1, 0.1, 7, 0, 0, 0, 1, 0, 0}, {5, 0, 0, 0, 0, 1, 0.1, 8, 24, 0, 0, 0, 1, 0}});
  add(names, {{6, 0, 0, 0, 0, 1, 0.1, 8, 24, 0, 0, 0, 1, 0}, {1, 0, 0, 0, 0, 1, 0.1, 7, 0, 0, 0, 1, 0, 0}});
  add(names, {{9, 0, 0, 0, 0, 1, 0.2, 9, 48, 0, 0, 0, 0, 1}, {2, 0, 0, 0, 0, 1, 0.1, 7, 0, 0, 0, 1, 0, 0}});
  const auto loaded = read_cloud(source(), 0.9, 1.9);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  const SurfelCloud& cloud = loaded->cloud;
  ASSERT_EQ(cloud.size(), 3u);
  ASSERT_EQ(cloud.lifetime.size(), 3u);
  // The nearest file is the second: of two the earlier.
  EXPECT_NEAR(x_at(cloud, 0, 1.25), 6.25, 1e-12);
  EXPECT_NEAR(x_at(cloud, 1, 1.25), 1.25, 1e-12);
  EXPECT_NEAR(x_at(cloud, 2, 1.75), 8.5, 1e-12) << "by its own velocity, backwards";
  EXPECT_TRUE(cloud.exists(0, 1.49));
  EXPECT_FALSE(cloud.exists(0, 1.5));
  EXPECT_FALSE(cloud.exists(2, 1.49));
  EXPECT_TRUE(cloud.exists(2, 1.5));
  for (const double frame : {0.9, 1.5, 1.9}) EXPECT_TRUE(cloud.exists(1, frame));
  EXPECT_EQ(cloud.color[0], Vector3f(0, 1, 0));
  EXPECT_EQ(cloud.color[2], Vector3f(0, 0, 1));
  EXPECT_NEAR(surfel_at(cloud, 2, 1.7).axis_u.norm(), 0.2, 1e-7);
  EXPECT_TRUE(has_part(loaded->report.assumed, "2 points come or go")) << joined(loaded->report.assumed);
  // An exposure within which none does is as it was.
  const auto calm = read_cloud(source(), 0.75, 1.25);
  ASSERT_TRUE(calm.ok());
  EXPECT_TRUE(calm->cloud.lifetime.empty());
  EXPECT_EQ(calm->cloud.size(), 2u);
}

TEST_F(MovingPointFiles, APointThatComesAgainIsAnother) {
  add(with_ids, {{0, 0, 0, 0, 0, 1, 0.1, 1}, {4, 0, 0, 0, 0, 1, 0.1, 2}});
  add(with_ids, {{0, 0, 0, 0, 0, 1, 0.1, 1}});
  add(with_ids, {{0, 0, 0, 0, 0, 1, 0.1, 1}, {-4, 0, 0, 0, 0, 1, 0.1, 2}});
  const auto loaded = read_cloud(source(), 0.0, 2.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  const SurfelCloud& cloud = loaded->cloud;
  ASSERT_EQ(cloud.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i)
    for (double frame = 0.0; frame <= 2.0; frame += 0.125) {
      if (!cloud.exists(i, frame)) continue;
      const double x = x_at(cloud, i, frame);
      EXPECT_TRUE(x == 0.0 || x == 4.0 || x == -4.0) << "a streak between two points: " << x;
    }
}

TEST_F(MovingPointFiles, PointsOfASpinningSensorStandWhereItSawThem) {
  std::vector<std::string> names = bare;
  names.emplace_back("t");
  // Both one unit ahead of a sensor that goes along x and turns to face y.
  add(names, {{1, 0, 0, 1, 0, 0, 0.1, 10.0}, {1, 0, 0, 1, 0, 0, 0.1, 10.5}});
  const std::string object = R"({"file": "k0.ply", "frame": 3}, "stamps": {"zero": 10, "sensor": {"keys": [
      {"frame": 3, "translate": [0, 0, 0], "rotate": {"axis": [0, 0, 1], "degrees": 0}},
      {"frame": 15, "translate": [2, 0, 0], "rotate": {"axis": [0, 0, 1], "degrees": 90}}]}})";
  const std::string members = R"("fps": 24, "frame": 3, )";
  const auto cloud = cloud_of(members, object);
  ASSERT_TRUE(cloud.ok()) << cloud.error().message();
  EXPECT_LT((cloud->keys[0].pose.position[0] - Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((cloud->keys[0].pose.position[1] - Vector3d(2, 1, 0)).norm(), 1e-12);
  const Vector3f normal = cloud->keys[0].pose.axis_u[1].cross(cloud->keys[0].pose.axis_v[1]);
  EXPECT_LT((normal.normalized() - Vector3f(0, 1, 0)).norm(), 1e-6f);
  EXPECT_FALSE(cloud->moves()) << "what was seen stands still";
  // Without stamps the same file is as it always was.
  const auto plain = cloud_of(members, R"({"file": "k0.ply", "frame": 3})");
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(plain->keys[0].pose.position[1], Vector3d(1, 0, 0));
}

TEST_F(MovingPointFiles, StampsShiftPathsInTheirOwnSpace) {
  std::vector<std::string> names = bare;
  for (const char* name : {"vx", "vy", "vz", "time"}) names.emplace_back(name);
  add(names, {{0, 0, 0, 0, 0, 1, 0.1, 1, 0, 0, 0.0}, {5, 0, 0, 0, 0, 1, 0.1, 1, 0, 0, 0.5}});
  CloudSource with = source();
  with.velocity_unit = VelocityUnit::per_frame;
  with.stamps = TimeStamps{StampUnit::frames, 0.0, {}};
  const auto loaded = read_cloud(with, 0, 0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  EXPECT_NEAR(x_at(loaded->cloud, 0, 0.5), 0.5, 1e-12);
  EXPECT_NEAR(x_at(loaded->cloud, 1, 0.5), 5.0, 1e-12);
  EXPECT_NEAR(x_at(loaded->cloud, 1, 0.0), 4.5, 1e-12);
  EXPECT_TRUE(has_part(loaded->report.assumed, "each at a time of its own"))
      << joined(loaded->report.assumed);
}

TEST_F(MovingPointFiles, StampsThatAreNotThereOrMeanNothingAreRefused) {
  add(bare, {{0, 0, 0, 0, 0, 1, 0.1}});
  add(bare, {{0, 0, 0, 0, 0, 1, 0.1}});
  const auto none = cloud_of("", R"({"file": "k0.ply"}, "stamps": {})");
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().message().find("time"), std::string::npos) << none.error().message();
  const auto sequence = cloud_of("", R"({"sequence": "k%d.ply"}, "stamps": {})");
  ASSERT_FALSE(sequence.ok());
  EXPECT_EQ(sequence.error().field, "/objects/0/stamps");
  const auto pair = cloud_of("", R"({"file": "k0.ply", "end_file": "k1.ply"}, "stamps": {})");
  ASSERT_FALSE(pair.ok());
  const auto unit = cloud_of("", R"({"file": "k0.ply"}, "stamps": {"unit": "days"})");
  ASSERT_FALSE(unit.ok());
  EXPECT_EQ(unit.error().field, "/objects/0/stamps/unit");
}

TEST_F(MovingPointFiles, FoundScenesComeOutRight) {
  SWEPT_DATA_OR_SKIP(data);
  const auto no_generator = [](const std::string&, std::size_t, const std::map<std::string, double>&) {
    return Result<SurfelCloud>(Error{"", "generator", "none"});
  };
  auto swapped = read_scene_file(data + "found/ids_swapped.json");
  ASSERT_TRUE(swapped.ok()) << swapped.error().message();
  const auto almost_still = swapped->scene_at(1.5, no_generator);
  ASSERT_TRUE(almost_still.ok()) << almost_still.error().message();
  const SurfelCloud& two = (*almost_still)->objects[0].cloud;
  ASSERT_EQ(two.size(), 2u);
  for (const double frame : {1.0, 1.25, 1.5, 1.75, 2.0})
    for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(std::abs(x_at(two, i, frame)), 1.0);
  auto changes = read_scene_file(data + "found/count_changes_velocity.json");
  ASSERT_TRUE(changes.ok()) << changes.error().message();
  const auto nearest = changes->scene_at(2.0, no_generator);
  ASSERT_TRUE(nearest.ok()) << nearest.error().message();
  const SurfelCloud& three = (*nearest)->objects[0].cloud;
  ASSERT_EQ(three.size(), 3u);
  EXPECT_NEAR(x_at(three, 0, 2.25), 0.625, 1e-6);
}

TEST_F(MovingPointFiles, SweepsOfALidarFitTogetherByTheirPoses) {
  SWEPT_DATA_OR_SKIP(data);
  CloudSource scan;
  scan.files = {{0.0, data + "lidar/scan0.ply"}};
  scan.radius = 0.05;
  scan.velocity_unit = VelocityUnit::ignore;
  const auto still = read_cloud(scan, 0.0, 0.0);
  ASSERT_TRUE(still.ok()) << still.error().message();
  scan.stamps.emplace();
  TransformKey start, end;
  end.frame = 2.4;  // a tenth of a second at 24 frames per second
  end.translate = {0.2454, -0.00686, 0.00845};
  scan.stamps->sensor.keys = {start, end};
  const auto moved = read_cloud(scan, 0.0, 0.0);
  ASSERT_TRUE(moved.ok()) << moved.error().message();
  ASSERT_EQ(moved->cloud.size(), still->cloud.size());
  double least = 1e9, most = 0.0;
  for (std::size_t i = 0; i < still->cloud.size(); ++i) {
    const double by = (moved->cloud.keys[0].pose.position[i] - still->cloud.keys[0].pose.position[i]).norm();
    least = std::min(least, by);
    most = std::max(most, by);
  }
  EXPECT_LT(least, 0.005);
  EXPECT_NEAR(most, 0.2456, 0.01);
}

/// What point `i` is at a frame: red times opacity, and opacity.
Eigen::Vector2f look_at(const SurfelCloud& cloud, std::size_t i, double frame) {
  const Eigen::Vector4f rgba = LooksAt(cloud, frame)[i];
  return {rgba[0], rgba[3]};
}

const std::vector<std::string> with_looks{"x",      "y",   "z",     "nx",   "ny",    "nz",
                                          "radius", "red", "green", "blue", "alpha", "id"};

TEST_F(MovingPointFiles, ColorsOpacitiesAndRadiiChangeFromFileToFile) {
  std::vector<std::string> names = with_looks;
  names.pop_back();
  add(names, {{0, 0, 0, 0, 0, 1, 0.2, 1, 0, 0, 1}, {1, 0, 0, 0, 0, 1, 0.2, 0.5, 0, 0, 1}});
  add(names, {{0, 0, 0, 0, 0, 1, 0.4, 0, 0, 1, 0.5}, {1, 0, 0, 0, 0, 1, 0.2, 0.5, 0, 0, 1}});
  const auto loaded = read_cloud(source(), 0.0, 1.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  const SurfelCloud& cloud = loaded->cloud;
  EXPECT_TRUE(look_at(cloud, 0, 0.25).isApprox(Eigen::Vector2f(0.75f, 0.875f)));
  EXPECT_TRUE(look_at(cloud, 1, 0.25).isApprox(Eigen::Vector2f(0.5f, 1.0f)));
  EXPECT_NEAR(surfel_at(cloud, 0, 0.25).axis_u.norm(), 0.25, 1e-6);
  EXPECT_TRUE(has_part(loaded->report.assumed, "colours and opacities change evenly from file to file"));
}

TEST_F(MovingPointFiles, LooksThatAreTheSameInAllFilesAreNone) {
  std::vector<std::string> names = with_looks;
  names.resize(10);
  add(names, {{0, 0, 0, 0, 0, 1, 0.2, 1, 0, 0}});
  add(names, {{1, 0, 0, 0, 0, 1, 0.2, 1, 0, 0}});
  EXPECT_TRUE(read_cloud(source(), 0.0, 1.0)->cloud.looks.empty());
  add(names, {{2, 0, 0, 0, 0, 1, 0.2, 0, 1, 0}});
  EXPECT_FALSE(read_cloud(source(), 0.0, 2.0)->cloud.looks.empty());
  // What the scene says of colours is not overruled.
  CloudSource white = source();
  white.color = Vector3f::Ones();
  EXPECT_TRUE(read_cloud(white, 0.0, 2.0)->cloud.looks.empty());
}

TEST_F(MovingPointFiles, LooksFollowTheIdsOfTheirPoints) {
  add(with_looks, {{0, 0, 0, 0, 0, 1, 0.2, 1, 0, 0, 1, 7}, {5, 0, 0, 0, 0, 1, 0.2, 0, 0, 0, 1, 8}});
  add(with_looks, {{5, 0, 0, 0, 0, 1, 0.2, 0, 0, 0, 1, 8}, {0, 0, 0, 0, 0, 1, 0.2, 0.5, 0, 0, 1, 7}});
  const auto loaded = read_cloud(source(), 0.0, 1.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  for (std::size_t i = 0; i < 2; ++i) {
    const double red = x_at(loaded->cloud, i, 0.0) == 0.0 ? 0.75 : 0.0;
    EXPECT_NEAR(look_at(loaded->cloud, i, 0.5)[0], red, 1e-6) << i;
  }
}

TEST_F(MovingPointFiles, PointsThatComeAndGoHaveTheLooksOfTheFilesThatHaveThem) {
  add(with_looks, {{0, 0, 0, 0, 0, 1, 0.2, 1, 0, 0, 1, 7}, {5, 0, 0, 0, 0, 1, 0.2, 0.2, 0, 0, 1, 8}});
  add(with_looks, {{0, 0, 0, 0, 0, 1, 0.2, 0.5, 0, 0, 1, 7}, {5, 0, 0, 0, 0, 1, 0.2, 0.4, 0, 0, 1, 8}});
  add(with_looks, {{0, 0, 0, 0, 0, 1, 0.2, 0.5, 0, 0, 1, 7}, {9, 0, 0, 0, 0, 1, 0.2, 0.9, 0, 0, 1, 9}});
  const auto loaded = read_cloud(source(), 0.0, 2.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  const SurfelCloud& cloud = loaded->cloud;
  ASSERT_EQ(cloud.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = x_at(cloud, i, 0.0);
    EXPECT_NEAR(look_at(cloud, i, 0.5)[0], x == 0.0 ? 0.75 : x == 5.0 ? 0.3 : 0.9, 1e-6) << x;
    if (x == 5.0) {
      EXPECT_NEAR(look_at(cloud, i, 1.4)[0], 0.4, 1e-6);
    }
  }
}

}  // namespace
