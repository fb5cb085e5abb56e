// What an exposure sees of a sequence before its first file and after its last.
#include "splat/io/cloud_source.h"

#include <gtest/gtest.h>

#include "tests/point_files.h"

namespace {

using namespace swept;
using Eigen::Vector3d;
using swept_test::float_ply;
class SequenceEnds : public swept_test::PointFiles {
 protected:
  /// Files 1 and 2: points that go by 1 a frame, and so do their velocities, but 3 at the ends.
  CloudSource source(const std::vector<std::string>& more = {}, bool ids = false, bool velocities = true) {
    CloudSource source;
    source.velocity_unit = VelocityUnit::per_frame;
    for (const int k : {1, 2}) {
      std::vector<std::vector<double>> rows;
      for (int i = 0; i < 4; ++i) {
        const int id = k == 1 ? i : 3 - i;  // in another order, by ids
        const double x = k + 10.0 * (ids ? id : i);
        rows.push_back({x, 0.5 * i, 0, 1});
        if (velocities) rows.back().insert(rows.back().end(), {3, 0, 0});
        if (ids) rows.back().push_back(id);
        if (!more.empty()) rows.back().push_back(2);
      }
      std::vector<std::string> names = {"x", "y", "z", "radius"};
      if (velocities) names.insert(names.end(), {"vx", "vy", "vz"});
      if (ids) names.emplace_back("id");
      names.insert(names.end(), more.begin(), more.end());
      source.files.push_back({1.0 * k, write(std::to_string(k) + ".ply", float_ply("ascii", names, rows))});
    }
    return source;
  }
};

double x_at(const SurfelCloud& cloud, double frame) { return surfel_at(cloud, 0, frame).position.x(); }

TEST_F(SequenceEnds, MoveOnAsTheirFileSays) {
  for (const bool ids : {false, true}) {
    const Result<LoadedCloud> last = read_cloud(source({}, ids), 1.75, 2.25);
    ASSERT_TRUE(last.ok()) << last.error().message();
    const double at_2 = x_at(last->cloud, 2.0);
    EXPECT_DOUBLE_EQ(x_at(last->cloud, 2.25), at_2 + 0.75) << ids;
    EXPECT_DOUBLE_EQ(x_at(last->cloud, 2.1), at_2 + 0.3) << ids;
    EXPECT_NEAR(x_at(last->cloud, 1.75), at_2 - 0.25, 1e-12)
        << ids;  // between two files they say where it is
    const Result<LoadedCloud> first = read_cloud(source({}, ids), 0.75, 1.25);
    ASSERT_TRUE(first.ok()) << first.error().message();
    const double at_1 = x_at(first->cloud, 1.0);
    EXPECT_DOUBLE_EQ(x_at(first->cloud, 0.75), at_1 - 0.75) << ids;
    EXPECT_NEAR(x_at(first->cloud, 1.25), at_1 + 0.25, 1e-12) << ids;
    // Within the files nothing is added.
    EXPECT_EQ(read_cloud(source({}, ids), 1.0, 2.0)->cloud.keys.size(), 2u);
  }
  // Both ends at once: the file that is nearest says it.
  EXPECT_TRUE(read_cloud(source(), 0.5, 2.5).ok());
}

TEST_F(SequenceEnds, AccelerateToo) {
  CloudSource accelerated = source({"ax"});
  accelerated.attributes["acceleration"] = "ax,vy,vz";
  const Result<LoadedCloud> last = read_cloud(accelerated, 1.5, 2.5);
  ASSERT_TRUE(last.ok()) << last.error().message();
  EXPECT_DOUBLE_EQ(x_at(last->cloud, 2.5), 2.0 + 0.5 * 3.0 + 0.5 * 0.25 * 2.0);
}

TEST_F(SequenceEnds, AreHeldWithoutVelocities) {
  const Result<LoadedCloud> last = read_cloud(source({}, false, false), 1.75, 2.25);
  ASSERT_TRUE(last.ok()) << last.error().message();
  EXPECT_EQ(last->cloud.keys.size(), 2u);
  EXPECT_DOUBLE_EQ(x_at(last->cloud, 2.25), 2.0);
  CloudSource ignored = source();
  ignored.velocity_unit = VelocityUnit::ignore;
  EXPECT_DOUBLE_EQ(x_at(read_cloud(ignored, 1.75, 2.25)->cloud, 2.25), 2.0);
}

}  // namespace
