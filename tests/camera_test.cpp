#include "splat/camera.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

namespace swept {
namespace {

using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

template <class Matrix>
::testing::AssertionResult same_bits(const Matrix& a, const Matrix& b) {
  for (Eigen::Index i = 0; i < a.size(); ++i)
    if (std::bit_cast<std::uint64_t>(a.data()[i]) != std::bit_cast<std::uint64_t>(b.data()[i]))
      return ::testing::AssertionFailure() << "entry " << i << ": " << a.data()[i] << " and " << b.data()[i];
  return ::testing::AssertionSuccess();
}

TransformKey key_at(double frame, const Vector3d& axis = Vector3d::UnitY(), double radians = 0.0) {
  TransformKey key;
  key.frame = frame;
  key.rotate_axis = axis;
  key.rotate_radians = radians;
  return key;
}

LookAtKey look_at(double frame, const Vector3d& eye, const Vector3d& target = Vector3d::Zero()) {
  LookAtKey key;
  key.frame = frame;
  key.eye = eye;
  key.target = target;
  return key;
}

// Tolerances below are 16 ulp of the largest number involved: a handful of rounded sums and products.
constexpr double ulp = std::numeric_limits<double>::epsilon();

TEST(TransformTrack, EmptyIsIdentity) {
  const TransformTrack track;
  EXPECT_TRUE(same_bits(track.at(3.5).matrix(), Eigen::Affine3d::Identity().matrix()));
  EXPECT_TRUE(track.constant_over(-1e9, 1e9));
}

TEST(TransformTrack, ScalesThenRotatesThenTranslates) {
  TransformKey key = key_at(0.0, Vector3d::UnitZ(), pi / 2);
  key.translate = {10, 0, 0};
  key.scale = {2, 3, 4};
  const Vector3d moved = TransformTrack{{key}}.at(0.0) * Vector3d(1, 1, 1);
  EXPECT_LE((moved - Vector3d(10 - 3, 2, 4)).norm(), 16 * 10 * ulp);
}

TEST(TransformTrack, InterpolatesLinearlyAndHoldsOutside) {
  TransformTrack track{{key_at(2.0), key_at(6.0)}};
  track.keys[1].translate = {8, 0, -4};
  track.keys[1].scale = {3, 1, 1};
  EXPECT_EQ(track.at(3.0).translation(), Vector3d(2, 0, -1));
  EXPECT_EQ(track.at(3.0).linear()(0, 0), 1.5);
  EXPECT_TRUE(same_bits(track.at(-100.0).matrix(), track.at(2.0).matrix()));
  EXPECT_TRUE(same_bits(track.at(100.0).matrix(), track.at(6.0).matrix()));
  EXPECT_EQ(track.at(6.0).translation(), Vector3d(8, 0, -4));
}

TEST(TransformTrack, SpinsThroughTwoRevolutions) {
  const TransformTrack track{{key_at(0.0), key_at(16.0, Vector3d::UnitY(), 4 * pi)}};
  for (double frame = 0.0; frame <= 16.0; frame += 0.5) {
    const double angle = frame / 16.0 * 4 * pi;
    const Vector3d expected(std::cos(angle), 0.0, -std::sin(angle));
    EXPECT_LE((track.at(frame) * Vector3d::UnitX() - expected).norm(), 16 * angle * ulp + 16 * ulp) << frame;
  }
}

TEST(TransformTrack, RotationByZeroTakesTheOtherKeysAxis) {
  const TransformTrack track{{key_at(0.0), key_at(4.0, Vector3d::UnitX(), 4 * pi)}};
  const Vector3d quarter = track.at(0.5) * Vector3d::UnitY();
  EXPECT_LE((quarter - Vector3d::UnitZ()).norm(), 16 * pi * ulp);
}

TEST(TransformTrack, OppositeAxesAreOneAxis) {
  const TransformTrack track{
      {key_at(0.0, Vector3d::UnitZ(), 1.5 * pi), key_at(2.0, -Vector3d::UnitZ(), 1.5 * pi)}};
  EXPECT_LE((track.at(1.0).linear() - Eigen::Matrix3d::Identity()).norm(), 16 * pi * ulp);
}

TEST(TransformTrack, DifferentAxesTakeTheShorterArc) {
  const TransformTrack track{
      {key_at(0.0, Vector3d::UnitX(), pi / 2), key_at(1.0, Vector3d::UnitY(), pi / 2)}};
  const Eigen::Quaterniond from(track.at(0.0).linear()), to(track.at(1.0).linear());
  const Eigen::Quaterniond middle(track.at(0.5).linear());
  EXPECT_NEAR(from.angularDistance(middle), 0.5 * from.angularDistance(to), 1e-7);  // √ulp: acos near 1
  EXPECT_NEAR(middle.angularDistance(to), 0.5 * from.angularDistance(to), 1e-7);
}

TEST(TransformTrack, ConstantMeansEqualBits) {
  TransformTrack track{{key_at(1.0, Vector3d(1, 2, 3).normalized(), 0.7), key_at(2.0), key_at(3.0)}};
  track.keys[0].translate = {0.1, 1.0 / 3.0, -0.0};
  track.keys[1] = track.keys[0];
  track.keys[1].frame = 2.0;
  track.keys[1].translate.z() = 0.0;  // equals −0, and must give its bits

  EXPECT_TRUE(track.constant_over(1.0, 2.0));
  EXPECT_TRUE(track.constant_over(-5.0, 1.75));
  EXPECT_TRUE(track.constant_over(3.0, 9.0));
  EXPECT_TRUE(track.constant_over(2.5, 2.5));
  EXPECT_FALSE(track.constant_over(1.5, 2.0 + 1e-9));
  EXPECT_FALSE(track.constant_over(2.5, 3.0));
  EXPECT_FALSE(track.constant_over(0.0, 9.0));
  const Eigen::Matrix4d first = track.at(-1.0).matrix();
  for (double frame = -1.0; frame <= 2.0; frame += 1.0 / 64)
    EXPECT_TRUE(same_bits(track.at(frame).matrix(), first));
}

TEST(CameraTrack, LookAtHasXRightYDownZForward) {
  CameraTrack track;
  track.look_ats = {look_at(0.0, {0, 0, 5})};
  const CameraInstant camera = track.at(0.0);
  EXPECT_EQ(camera.camera_from_world * Vector3d(0, 0, 0), Vector3d(0, 0, 5));
  EXPECT_EQ(camera.camera_from_world * Vector3d(1, 0, 0), Vector3d(1, 0, 5));
  EXPECT_EQ(camera.camera_from_world * Vector3d(0, 1, 0), Vector3d(0, -1, 5));
  EXPECT_EQ(camera.camera_from_world.linear().determinant(), 1.0);
}

TEST(CameraTrack, TargetIsInTheMiddleOfTheImageAtEveryInstant) {
  CameraTrack track;
  track.look_ats = {look_at(0.0, {3, 4, 5}, {1, -2, 0.5}), look_at(1.0, {-7, 1, 2}, {0, 1, 9})};
  const Film film{.width = 641, .height = 480};
  for (double frame = 0.0; frame <= 1.0; frame += 0.125) {
    const CameraInstant camera = track.at(frame);
    const Vector3d target = (1 - frame) * Vector3d(1, -2, 0.5) + frame * Vector3d(0, 1, 9);
    const Vector3d seen = camera.camera_from_world.linear() * (target - camera.eye);
    const Projection projection = projection_of(film, camera.tan_half_fov_y);
    EXPECT_GT(seen.z(), 0.0);
    // A few ulp of the scene's extent, 10, times focal length over depth, 480/3.
    EXPECT_NEAR(projection.center_x + projection.focal_px * seen.x() / seen.z(), 320.5, 16 * 10 * ulp * 160);
    EXPECT_NEAR(projection.center_y + projection.focal_px * seen.y() / seen.z(), 240.0, 16 * 10 * ulp * 160);
    const Eigen::Matrix3d r = camera.camera_from_world.linear();
    EXPECT_LE((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 16 * ulp);
  }
}

TEST(CameraTrack, FieldOfViewReachesTheBorder) {
  const Film film{.width = 200, .height = 100};
  const Projection projection = projection_of(film, std::tan(20.0 * pi / 180));
  EXPECT_NEAR(projection.center_y + projection.focal_px * std::tan(20.0 * pi / 180), 100.0, 16 * 100 * ulp);
  EXPECT_EQ(projection.center_x, 100.0);
}

TEST(CameraTrack, SurveyCoordinatesKeepTheirDigits) {
  // All numbers are dyadic, so p − eye is exact; the translation of the affine map is not.
  const Vector3d eye(5e6 + 0.125, 5.4e6 - 0.25, 512.0), offset(0.375, -0.5, -8.0);
  CameraTrack far, near;
  far.look_ats = {look_at(0.0, eye, eye + Vector3d(0.25, 0.5, -8.0))};
  near.look_ats = {look_at(0.0, Vector3d::Zero(), Vector3d(0.25, 0.5, -8.0))};
  const CameraInstant a = far.at(0.0), b = near.at(0.0);
  EXPECT_TRUE(same_bits(a.camera_from_world.linear().eval(), b.camera_from_world.linear().eval()));
  const Vector3d p = eye + offset;
  EXPECT_TRUE(same_bits((a.camera_from_world.linear() * (p - a.eye)).eval(),
                        (b.camera_from_world.linear() * (offset - b.eye)).eval()));
}

TEST(CameraTrack, ConstantMeansEqualBits) {
  CameraTrack track;
  const Eigen::Quaterniond q(Eigen::AngleAxisd(1.1, Vector3d(1, -2, 3).normalized()));
  track.poses = {{0.0, {1.0 / 3.0, 0.2, 0.3}, q, 0.4},
                 {1.0, {1.0 / 3.0, 0.2, 0.3}, Eigen::Quaterniond(-q.coeffs()), 0.4},
                 {2.0, {1, 2, 3}, q, 0.4}};
  EXPECT_TRUE(track.constant_over(0.0, 1.0));
  EXPECT_FALSE(track.constant_over(0.5, 1.5));
  const CameraInstant first = track.at(-1.0);
  for (double frame = -1.0; frame <= 1.0; frame += 1.0 / 64)
    EXPECT_TRUE(same_bits(track.at(frame).camera_from_world.matrix(), first.camera_from_world.matrix()));
  // A dolly shot: the orientation is shared, and keeps its bits while the eye moves.
  EXPECT_TRUE(
      same_bits(track.at(1.4).camera_from_world.linear().eval(), first.camera_from_world.linear().eval()));

  CameraTrack look;
  look.look_ats = {look_at(0.0, {0.1, 0.7, 5}), look_at(3.0, {0.1, 0.7, 5})};
  EXPECT_TRUE(look.constant_over(0.0, 3.0));
  for (double frame = 0.0; frame <= 3.0; frame += 1.0 / 16)
    EXPECT_TRUE(
        same_bits(look.at(frame).camera_from_world.matrix(), look.at(0.0).camera_from_world.matrix()));
}

struct BadCamera {
  const char* name;
  CameraTrack track;
  const char* field;
  const char* reason;
};

BadCamera bad(const char* name, std::vector<LookAtKey> keys, const char* field, const char* reason) {
  CameraTrack track;
  track.look_ats = std::move(keys);
  return {name, track, field, reason};
}

std::vector<BadCamera> bad_cameras() {
  LookAtKey up_along_view = look_at(0.0, {0, 5, 0}), no_up = look_at(0.0, {0, 0, 5});
  no_up.up.setZero();
  LookAtKey flat = look_at(0.0, {0, 0, 5}), half_space = flat, infinite = flat,
            turned = look_at(1.0, {0, 0, 5});
  flat.tan_half_fov_y = 0.0;
  half_space.tan_half_fov_y = std::numeric_limits<double>::infinity();
  infinite.eye.x() = nan;
  turned.up = {0, -1, 0};
  LookAtKey below = look_at(2.0, {1, -3, 0.0}), above = look_at(1.0, {-1, 3, 0.0});
  const LookAtKey good = look_at(0.0, {0, 0, 5});
  std::vector<BadCamera> cases = {
      bad("no keys", {}, "/keys", "one kind"),
      bad("eye on target", {look_at(0.0, {1, 2, 3}, {1, 2, 3})}, "/keys/0/target", "where the eye is"),
      bad("up along the view", {up_along_view}, "/keys/0/up", "parallel"),
      bad("no up", {no_up}, "/keys/0/up", "zero"),
      bad("no field of view", {flat}, "/keys/0/fov", "field of view"),
      bad("180 degrees", {half_space}, "/keys/0/fov", "field of view"),
      bad("NaN", {infinite}, "/keys/0/eye", "finite"),
      bad("equal frames", {good, good}, "/keys/1/frame", "increasing"),
      bad("through the target", {good, look_at(2.0, {0, 0, -5})}, "/keys/1", "meets the target"),
      bad("up through zero", {good, turned}, "/keys/1", "meets the target"),
      bad("up meets the view", {above, below}, "/keys/1", "up meets the view"),
      bad("near", {good}, "/near", "near"),
  };
  cases.back().track.near = 0.0;
  CameraTrack skewed;
  skewed.poses = {CameraKey{}};
  skewed.poses[0].world_from_camera.w() = 1.1;
  cases.push_back({"not a rotation", skewed, "/keys/0/matrix", "unit quaternion"});
  CameraTrack both = skewed;
  both.poses[0].world_from_camera.w() = 1.0;
  both.look_ats = {good};
  cases.push_back({"two kinds", both, "/keys", "one kind"});
  return cases;
}

TEST(CameraTrack, ValidateNamesWhatIsWrong) {
  for (const BadCamera& bad_camera : bad_cameras()) {
    const Status status = bad_camera.track.validate();
    ASSERT_FALSE(status.ok()) << bad_camera.name;
    EXPECT_EQ(status.error().field, bad_camera.field) << bad_camera.name;
    EXPECT_NE(status.error().reason.find(bad_camera.reason), std::string::npos)
        << bad_camera.name << ": " << status.error().reason;
  }
}

TEST(CameraTrack, ValidateAcceptsAnOrbit) {
  CameraTrack track;
  for (int i = 0; i < 8; ++i)
    track.look_ats.push_back(look_at(i, {5 * std::cos(i * pi / 4), 1.0, 5 * std::sin(i * pi / 4)}));
  const Status status = track.validate();
  EXPECT_TRUE(status.ok()) << status.error().message();
}

}  // namespace
}  // namespace swept
