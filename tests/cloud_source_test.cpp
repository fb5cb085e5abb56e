// Clouds from one file, from velocities and from sequences; the names and numbers of sequences.
#include "splat/io/cloud_source.h"

#include <cmath>

#include <Eigen/Geometry>

#include "splat/io/sequence.h"
#include "tests/point_files.h"

namespace {

using namespace swept;
using Eigen::Vector3d;
using Eigen::Vector3f;
using swept_test::float_ply;

using CloudSourceTest = swept_test::PointFiles;

std::vector<double> frames_of(const SurfelCloud& cloud) {
  std::vector<double> frames;
  for (const SurfelKey& key : cloud.keys) frames.push_back(key.frame);
  return frames;
}

TEST_F(CloudSourceTest, VelocitiesBecomePerFrame) {
  const std::string path = write("v.ply", float_ply("ascii", {"x", "y", "z", "vx", "vy", "vz", "radius"},
                                                    {{0, 0, 0, 30, 0, -15, 1}, {1, 0, 0, 0, 0, 0, 2}}));
  CloudSource source;
  source.files = {{7.0, path}};
  source.fps = {30000, 1001};
  const Result<LoadedCloud> second = read_cloud(source, 6.75, 7.25);
  ASSERT_TRUE(second.ok()) << second.error().message();
  EXPECT_EQ(frames_of(second->cloud), std::vector<double>{7.0});
  EXPECT_EQ(second->cloud.velocity[0], Vector3f(1.001f, 0, -0.5005f));
  EXPECT_EQ(second->cloud.velocity[1], Vector3f(0, 0, 0));
  source.velocity_unit = VelocityUnit::per_frame;
  EXPECT_EQ(read_cloud(source, 7, 7)->cloud.velocity[0], Vector3f(30, 0, -15));
  source.velocity_unit = VelocityUnit::ignore;
  EXPECT_TRUE(read_cloud(source, 7, 7)->cloud.velocity.empty());
}

TEST_F(CloudSourceTest, OverridesReplaceRadiiAndColours) {
  const std::string path =
      write("r.ply", float_ply("ascii", {"x", "y", "z", "nx", "ny", "nz", "radius", "red", "green", "blue"},
                               {{0, 0, 0, 0, 2, 0, 1, 1, 1, 1}, {1, 0, 0, 0, 0, -3, 2, 1, 1, 1}}));
  CloudSource source;
  source.files = {{0.0, path}};
  source.radius_scale = 1.5;
  source.color = Vector3f(0.25f, 0.5f, 2.0f);
  Result<LoadedCloud> loaded = read_cloud(source, 0, 0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  EXPECT_FLOAT_EQ(loaded->cloud.keys[0].pose.axis_v[1].norm(), 3.0f);
  EXPECT_EQ(loaded->cloud.color, std::vector<Vector3f>(2, *source.color));
  source.radius = 0.1;
  loaded = read_cloud(source, 0, 0);
  for (int i = 0; i < 2; ++i) {
    const Vector3f &u = loaded->cloud.keys[0].pose.axis_u[i], &v = loaded->cloud.keys[0].pose.axis_v[i];
    EXPECT_FLOAT_EQ(u.norm(), 0.15f);
    EXPECT_FLOAT_EQ(v.norm(), 0.15f);
    EXPECT_LT((u.cross(v).normalized() - (i == 0 ? Vector3f(0, 1, 0) : Vector3f(0, 0, -1))).norm(), 1e-6f);
  }
}

TEST_F(CloudSourceTest, NormalsThatAreEstimatedShowTheSideAskedFor) {
  // A wall in x and z, whose normal is y or −y.
  std::vector<std::vector<double>> rows;
  for (int i = 0; i < 36; ++i) rows.push_back({i % 6 + 0.1 * (i / 6 % 2), 0, i / 6 + 0.0});
  CloudSource source;
  source.files = {{0.0, write("wall.ply", float_ply("ascii", {"x", "y", "z"}, rows))}};
  source.color_by_normals = true;
  for (const double side : {1.0, -1.0}) {
    source.normals_toward = {0.3, 5.0 * side, -0.4};
    const Result<LoadedCloud> loaded = read_cloud(source, 0, 0);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message();
    for (const Vector3f& color : loaded->cloud.color)
      EXPECT_LT((color - Vector3f(0.5f, side > 0.0 ? 1.0f : 0.0f, 0.5f)).norm(), 1e-5f);
  }
  // Of a mesh the triangles say it, for the vertex without any too: it is no guess.
  source.files = {
      {0.0, write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0.5 0 0.4\nf 1 2 3\nf 1 3 4\n")}};
  source.normals_toward = {0, 1, 0};
  const Result<LoadedCloud> mesh = read_cloud(source, 0, 0);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message();
  for (const Vector3f& color : mesh->cloud.color)
    EXPECT_LT((color - Vector3f(0.5f, 0.0f, 0.5f)).norm(), 1e-5f);
}

TEST_F(CloudSourceTest, OnlyTheKeysAroundTheIntervalAreRead) {
  CloudSource source;
  for (int k = 0; k < 6; ++k) {
    const std::string path = "k" + std::to_string(k) + ".ply";
    // The first and the last are missing: reading them would be an error.
    if (k > 0 && k < 5) {
      write(path,
            float_ply("ascii", {"x", "y", "z", "radius"}, {{1.0 * k, 0, 0, 1}, {0, 1, 0, 1}, {0, 2, 0, 1}}));
    }
    source.files.push_back({10.0 * k, folder_ / path});
  }
  const auto frames = [&](double first, double last) {
    const Result<LoadedCloud> loaded = read_cloud(source, first, last);
    return loaded.ok() ? frames_of(loaded->cloud) : std::vector<double>{};
  };
  EXPECT_EQ(frames(10.0, 10.0), (std::vector<double>{10}));
  EXPECT_EQ(frames(10.0, 10.5), (std::vector<double>{10, 20}));
  EXPECT_EQ(frames(19.75, 20.25), (std::vector<double>{10, 20, 30}));
  EXPECT_EQ(frames(20.0, 40.0), (std::vector<double>{20, 30, 40}));
  EXPECT_EQ(frames(12.0, 13.0), (std::vector<double>{10, 20}));
  EXPECT_TRUE(frames(9.0, 11.0).empty());
  EXPECT_TRUE(frames(41.0, 42.0).empty());
  source.files.pop_back();
  EXPECT_EQ(frames(41.0, 42.0), (std::vector<double>{40}));
  source.files.erase(source.files.begin());
  EXPECT_EQ(frames(-3.0, 1.0), (std::vector<double>{10}));
}

TEST_F(CloudSourceTest, AxesOfTheNextKeyFollowThoseOfTheOneBefore) {
  // One disc that the file writes with other axes in every key: u and v spun by 2 rad within its plane.
  CloudSource source;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()));
    const Eigen::Quaterniond q = tilt * Eigen::AngleAxisd(2.0 * k, Vector3d::UnitZ());
    const std::vector<std::string> names{"x",     "y",     "z",     "scale_0", "scale_1",
                                         "rot_0", "rot_1", "rot_2", "rot_3"};
    source.files.push_back(
        {1.0 * k, write("t" + std::to_string(k) + ".ply",
                        float_ply("ascii", names, {{1.0 * k, 0, 0, -1, -1, q.w(), q.x(), q.y(), q.z()}}))});
  }
  const Result<LoadedCloud> loaded = read_cloud(source, 0.0, 3.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  ASSERT_EQ(loaded->cloud.keys.size(), 4u);
  const SurfelPose& first = loaded->cloud.keys[0].pose;
  // The files' quaternions are good to 6e-8 in each of four numbers, and turn an axis by twice their error.
  const float tolerance = 5e-7f * first.axis_u[0].norm();
  for (const SurfelKey& key : loaded->cloud.keys) {
    EXPECT_LE((key.pose.axis_u[0] - first.axis_u[0]).norm(), tolerance) << "key " << key.frame;
    EXPECT_LE((key.pose.axis_v[0] - first.axis_v[0]).norm(), tolerance) << "key " << key.frame;
  }
}

TEST_F(CloudSourceTest, GuessedSidesDoNotTurnOverBetweenKeys) {
  // A bent sheet without normals, turning: a plane fit may come out either way up.
  CloudSource source;
  for (int k = 0; k < 6; ++k) {
    const Eigen::AngleAxisd turn(0.5 * k, Vector3d(1, 2, 3).normalized());
    std::vector<std::vector<double>> rows;
    for (int i = 0; i < 100; ++i) {
      const double x = 0.1 * (i % 10), y = 0.1 * (i / 10);
      const Vector3d p = turn * Vector3d(x, y, 0.2 * std::sin(3.0 * x));
      rows.push_back({p.x(), p.y(), p.z()});
    }
    source.files.push_back(
        {1.0 * k, write("g" + std::to_string(k) + ".ply", float_ply("ascii", {"x", "y", "z"}, rows))});
  }
  const Result<LoadedCloud> loaded = read_cloud(source, 0.0, 5.0);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message();
  for (std::size_t k = 1; k < 6; ++k) {
    const SurfelPose &a = loaded->cloud.keys[k - 1].pose, &b = loaded->cloud.keys[k].pose;
    for (std::size_t i = 0; i < a.size(); ++i) {
      // The sheet turns by 0.5 rad from key to key, so its normals by no more: cos 0.5 = 0.878.
      const Vector3f n = a.axis_u[i].cross(a.axis_v[i]).normalized(),
                     m = b.axis_u[i].cross(b.axis_v[i]).normalized();
      EXPECT_GT(n.dot(m), 0.87f) << "key " << k << " point " << i;
    }
  }
}

TEST_F(CloudSourceTest, CountsThatDifferNameBothFiles) {
  CloudSource source;
  const auto add = [&](const std::string& name, const std::string& bytes) {
    source.files.push_back({static_cast<double>(source.files.size()), write(name, bytes)});
  };
  add("three.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  add("two.xyz", "0 0 0\n1 0 0\n");
  const Error points = read_cloud(source, 0, 1).error();
  EXPECT_EQ(points.file, folder_ / "two.xyz");
  EXPECT_EQ(points.field, "points");
  for (const char* part : {"has 2 where ", "three.xyz has 3", "velocities", "by id"}) {
    EXPECT_NE(points.reason.find(part), std::string::npos) << points.reason;
  }
  source.files.clear();
  add("one.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n");
  add("two.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n");
  EXPECT_EQ(read_cloud(source, 0, 1).error().field, "triangles");
}

TEST_F(CloudSourceTest, OptionsOutOfRangeAreNamed) {
  CloudSource good;
  good.files = {{0.0, write("a.xyz", "0 0 0\n1 0 0\n0 1 0\n")}};
  ASSERT_TRUE(read_cloud(good, 0, 0).ok());
  const auto field = [&](auto spoil) {
    CloudSource source = good;
    spoil(source);
    const Result<LoadedCloud> loaded = read_cloud(source, 0, 0);
    return loaded.ok() ? "none" : loaded.error().field;
  };
  EXPECT_EQ(field([](CloudSource& s) { s.radius = 0.0; }), "radius");
  EXPECT_EQ(field([](CloudSource& s) { s.radius = NAN; }), "radius");
  EXPECT_EQ(field([](CloudSource& s) { s.radius_scale = -1.0; }), "radius_scale");
  EXPECT_EQ(field([](CloudSource& s) { s.color = Vector3f(0, NAN, 0); }), "color");
  EXPECT_EQ(field([](CloudSource& s) { s.fps = {0, 1}; }), "fps");
  EXPECT_EQ(field([](CloudSource& s) { s.delta = 0.0; }), "delta");
  EXPECT_EQ(field([](CloudSource& s) { s.files.clear(); }), "files");
  EXPECT_EQ(field([](CloudSource& s) { s.files.push_back(s.files[0]); }), "frame");
  EXPECT_EQ(field([](CloudSource& s) {
              s.files.push_back({1.0, s.files[0].path});
              s.skip_invalid = true;
            }),
            "skip_invalid");
  EXPECT_EQ(field([](CloudSource& s) { s.attributes["speed"] = "x"; }), "attributes.speed");
  EXPECT_EQ(read_cloud(good, 1, 0).error().field, "frames");
}

TEST(SequenceTest, NumbersAreFilledInAsPrintfDoes) {
  const auto path = [](const char* pattern, int number) {
    const Result<std::string> filled = sequence_path(pattern, number);
    return filled.ok() ? *filled : "error: " + filled.error().reason.substr(0, 9);
  };
  EXPECT_EQ(path("a/walk.%04d.ply", 7), "a/walk.0007.ply");
  EXPECT_EQ(path("a/walk.%d.ply", 7), "a/walk.7.ply");
  EXPECT_EQ(path("####.obj", 12345), "12345.obj");
  EXPECT_EQ(path("####.obj", 12), "0012.obj");
  EXPECT_EQ(path("f#", 3), "f3");
  EXPECT_EQ(path("%04d", -7), "-007");
  EXPECT_EQ(path("%d", -2147483647 - 1), "-2147483648");
  for (const char* bad : {"", "walk.ply", "%s", "%4d", "%", "%0d", "%04", "%099999999999d"}) {
    EXPECT_EQ(path(bad, 1), "error: needs one") << bad;
  }
  for (const char* bad : {"##_##", "%d_%d", "#%d"}) EXPECT_EQ(path(bad, 1), "error: has more ") << bad;
  for (const char* bad : {"%099d", "%0-1d", "%00d"}) EXPECT_EQ(path(bad, 1), "error: asks for ") << bad;
}

TEST_F(CloudSourceTest, FilesOfASequenceAreSortedByNumber) {
  for (const char* name :
       {"s10.ply", "s9.ply", "s100.ply", "s-1.ply", "s09.ply", "s1.obj", "sx.ply", "t1.ply"}) {
    write(name, "");
  }
  const auto listed = list_sequence(folder_ / "s#.ply");
  ASSERT_TRUE(listed.ok()) << listed.error().message();
  std::vector<int> numbers;
  for (const NumberedFile& file : *listed) {
    numbers.push_back(file.number);
    EXPECT_EQ(file.path, *sequence_path(folder_ / "s#.ply", file.number));
  }
  EXPECT_EQ(numbers, (std::vector<int>{-1, 9, 10, 100}));
  EXPECT_EQ(list_sequence(folder_ / "q%d.ply").error().reason, "no such file");
  EXPECT_FALSE(list_sequence(folder_ / "absent/s%d.ply").ok());
  EXPECT_FALSE(list_sequence(folder_ / "s%d/a.ply").ok());
}

TEST(SequenceTest, FrameRanges) {
  const auto frames = [](const char* text) {
    const Result<std::vector<int>> parsed = parse_frame_ranges(text);
    return parsed.ok() ? *parsed : std::vector<int>{-999};
  };
  EXPECT_EQ(frames("5"), (std::vector<int>{5}));
  EXPECT_EQ(frames("1-10x3,20,4-5"), (std::vector<int>{1, 4, 7, 10, 20, 5}));
  EXPECT_EQ(frames("-3--1"), (std::vector<int>{-3, -2, -1}));
  EXPECT_EQ(frames("2147483646-2147483647"), (std::vector<int>{2147483646, 2147483647}));
  EXPECT_EQ(frames("1-1000000").size(), 1000000u);
  for (const char* bad : {"", ",", "1,", "a", "1-", "1-5x", "1-5x0", "1-5x-1", "1x2", "1.5", "1 -2", "5-1",
                          "99999999999", "1-2000000", "0-2147483647"}) {
    EXPECT_EQ(frames(bad), (std::vector<int>{-999})) << bad;
  }
}

}  // namespace
