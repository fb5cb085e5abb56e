// Across every switch of formula, values and images change by no more than what the two sides are off by. A
// switch is stepped over at its exact place: bisection goes on down to neighbouring numbers.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "abuffer/resolve/members.h"
#include "splat/kernel/ray_kernel.h"
#include "splat/motion/segments.h"
#include "tests/counter.h"
#include "tests/oracle/hard_scenes.h"
#include "tests/oracle/oracle.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// The last number from `low` on for which `first_side` holds, and the next; it holds at low and not at high.
template <class T, class Side>
std::pair<T, T> switch_between(T low, T high, Side first_side) {
  EXPECT_TRUE(first_side(low));
  EXPECT_FALSE(first_side(high));
  while (std::nextafter(low, high) < high) {
    T middle = low + (high - low) / 2;
    if (!(middle > low && middle < high)) middle = std::nextafter(low, high);
    (first_side(middle) ? low : high) = middle;
  }
  return {low, high};
}

/// The sweep's own series and what it takes beyond: the ends of a span s about m, for the last s of the
/// series and the first beyond. Both are within 5 ulp of means that differ by less than an ulp.
TEST(Continuity, OfTheSweepsMeanWhereItsSeriesEnds) {
  FragmentArrays fragment;
  fragment.ensure(member_lanes);
  fragment.t_begin[0] = 0;
  fragment.t_end[0] = shutter_close;
  fragment.z_rate[0] = 0.0f;
  fragment.peak[0] = fragment.z[0] = 1.0f;
  for (const IntervalMath& math : interval_math_builds())
    for (const float middle : {-6.5f, -3.0f, -2.0f, -1.0f, 0.0f, 0.25f, 1.0f, 2.5f, 5.0f}) {
      const auto mean = [&](float span) {
        fragment.y[0] = middle - 0.5f * span;  // y + rate / 2 rounds back to the middle, or next to it
        fragment.rate[0] = span;
        MemberSet members;
        members.push(fragment, 0, {});
        float value[member_lanes];
        (void)math.sum_over(members.view(), 0, shutter_close, value);
        return value[0];
      };
      const auto is_series = [&](float span) {
        const float of_y = (middle - 0.5f * span) + 0.5f * span;
        return span <= 0.5f && span * std::abs(of_y) <= 1.0f;
      };
      const auto [last, first] = switch_between(0.05f, 1.0f, is_series);
      const double ulp = oracle::ulp<float>(mean(last));
      // The middle in float may be half an ulp of it away, which costs 2|m| of that.
      const double moved = 2 * std::abs(middle) * oracle::ulp<float>(middle) * mean(last) / ulp;
      EXPECT_LE(std::abs(double{mean(last)} - double{mean(first)}), (5 + 5 + 1 + moved) * ulp)
          << math.name << " " << middle;
    }
}

/// A fragment stands still below the smallest normal speed. To either side of it times, peak and depth are
/// the same, and y has moved by nothing.
TEST(Continuity, OfAFragmentWhereItStandsStill) {
  for (const double distance : {0.0, 0.3, 0.999, 0.999999999}) {
    const auto fragment_at = [&](double speed) {
      RayFragment<double> f{};
      const RayCoordinates<double> ray{0.6 * distance, 0.8 * distance, 2.0, 0.8 * speed, -0.6 * speed, 0.5};
      EXPECT_TRUE(intersect_tube(ray, 0.0, 1.0, 0.1, 3.0, 1.0, f)) << distance << " " << speed;
      return f;
    };
    const auto [slow, fast] =
        switch_between(0.0, 1e-300, [&](double speed) { return fragment_at(speed).rate == 0.0; });
    EXPECT_LE(fast, 2 * std::numeric_limits<double>::min());
    const RayFragment<double> a = fragment_at(slow), b = fragment_at(fast);
    EXPECT_EQ(a.t_begin, b.t_begin);
    EXPECT_EQ(a.t_end, b.t_end);
    EXPECT_EQ(a.z_begin, b.z_begin);
    // For (u, v) moved by 5 ε w each.
    EXPECT_NEAR(a.peak, b.peak, a.peak * 2 * 0x1p-53 * (2 * 3 + 3 + 2 * 3 * 5));
    EXPECT_LE(std::abs(b.y_begin - a.y_begin), 2 * 24 * 0x1p-53 * std::sqrt(3.0) * 2);
  }
}

/// The pixel filter has no switch: from a thousandth of a pixel to a thousand px, and through edge-on, a step
/// of 10⁻⁴ in size or angle never changes weight, size or AAᵀ by more than a few times that.
TEST(Continuity, OfThePixelFilterThroughAllSizesAndAngles) {
  PixelFilter filter;
  filter.radius = 1e-3;  // 1 px
  filter.near = 0.1;
  const Vector3d center(0.1, -0.2, 1.0);
  const auto disc_at = [&](double radius, double angle) {
    const Eigen::AngleAxisd turn(angle, Vector3d(0.3, 1.0, 0.1).normalized());
    return filter_disc(center, radius * (turn * Vector3d::UnitX()), 0.7 * radius * (turn * Vector3d::UnitY()),
                       filter);
  };
  const auto spread = [](const FilteredDisc& d) {
    return Eigen::Matrix3d(d.axis_u * d.axis_u.transpose() + d.axis_v * d.axis_v.transpose());
  };
  constexpr double step = 1e-4;
  double worst = 0.0;
  const auto compare = [&](const FilteredDisc& a, const FilteredDisc& b) {
    worst = std::max({worst, std::abs(a.weight - b.weight) / step, std::abs(a.size - b.size) / a.size / step,
                      (spread(a) - spread(b)).norm() / spread(a).norm() / step});
  };
  for (double radius = 1e-6; radius < 1.0; radius *= 1 + step)
    compare(disc_at(radius, 0.9), disc_at(radius * (1 + step), 0.9));
  // A disc of ρ px turns through edge-on within an angle of 1/ρ, so that its step is as much smaller.
  for (const double radius_px : {0.1, 1.0, 10.0})
    for (double angle = 0.0; angle < 3.2; angle += step)
      compare(disc_at(1e-3 * radius_px, angle),
              disc_at(1e-3 * radius_px, angle + step / std::max(1.0, radius_px)));
  EXPECT_LE(worst, 8.0);
  EXPECT_GT(worst, 0.5) << "nothing changes";
}

double farthest_apart(const Image& a, const Image& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    worst = std::max<double>(worst, std::abs(a.rgba[i] - b.rgba[i]));
  return worst;
}

Image image_of(const Scene& scene) {
  const auto rendered = render_abuffer(scene, {}, {.threads = 1});
  EXPECT_TRUE(rendered.ok());
  return rendered->image;
}

/// A few large discs, two of them crossing, on 16 × 12 px, all of whose motion is `speed` times their own.
/// Speeds and places are floats' neighbours only if speed is one.
Scene few_discs(float speed) {
  Scene scene;
  scene.film = {16, 12, 0, 0, 0, 0};
  scene.shutter = {-0.5, 0.5};
  scene.camera.poses.emplace_back();
  scene.camera.near = 0.1;
  Object object;
  SurfelPose pose;
  const auto add = [&](const Vector3d& center, const Vector3f& u, const Vector3f& v, const Vector3f& velocity,
                       const Vector3f& color) {
    pose.position.push_back(center);
    pose.axis_u.push_back(u);
    pose.axis_v.push_back(v);
    object.cloud.velocity.push_back(speed * velocity);
    object.cloud.color.push_back(color);
  };
  add({-0.3, 0.1, 3.0}, {0.7f, 0.0f, 0.1f}, {0.0f, 0.5f, 0.2f}, {1.0f, 0.25f, 0.5f}, {0.9f, 0.1f, 0.1f});
  add({0.3, -0.1, 3.1}, {0.5f, 0.1f, -0.1f}, {0.1f, 0.6f, 0.0f}, {-0.75f, 0.5f, -1.0f}, {0.1f, 0.8f, 0.2f});
  add({0.0, 0.3, 3.0}, {0.3f, 0.0f, 0.5f}, {0.0f, 0.3f, 0.0f}, {0.5f, -1.0f, 0.0f}, {0.2f, 0.2f, 0.9f});
  add({0.0, 0.0, 8.0}, {6.0f, 0.0f, 0.0f}, {0.0f, 6.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, {0.5f, 0.5f, 0.5f});
  object.cloud.keys.push_back({0.0, std::move(pose)});
  scene.objects.push_back(std::move(object));
  return scene;
}

/// Closes in on the largest jump of the image between two values of a parameter, down to neighbouring floats.
double largest_jump(float low, float high, const std::function<Image(float)>& image) {
  constexpr int parts = 6;
  double jump = 0.0;
  while (std::nextafter(low, high) < high) {
    std::vector<float> at = {low};
    for (int i = 1; i < parts; ++i) {
      const float next = low + static_cast<float>(i) * ((high - low) / parts);
      if (next > at.back() && next < high) at.push_back(next);
    }
    if (at.size() == 1 && std::nextafter(low, high) < high) at.push_back(std::nextafter(low, high));
    at.push_back(high);
    Image before = image(at[0]);
    jump = -1.0;
    for (std::size_t i = 1; i < at.size(); ++i) {
      Image after = image(at[i]);
      const double step = farthest_apart(before, after);
      if (step > jump) {
        jump = step;
        low = at[i - 1];
        high = at[i];
      }
      before = std::move(after);
    }
  }
  return jump;
}

/// What a piece may be off by: 2⁻¹² in the integral of its colour, and its coverage 2⁻¹⁵.
constexpr double piece_error = 0x1p-12 + 0x1p-15;

TEST(Continuity, OfTheImageInSpeed) {
  // Standing still to moving by 10⁻⁶ px, past a pixel, and past all pixels: every series, span and piece on
  // the way.
  for (const auto& [low, high] :
       {std::pair{0.0f, 1e-6f}, {0.01f, 0.02f}, {0.1f, 0.3f}, {0.5f, 2.0f}, {5.0f, 40.0f}})
    EXPECT_LE(largest_jump(low, high, [](float speed) { return image_of(few_discs(speed)); }),
              2 * piece_error)
        << low << " to " << high;
}

double counter(const Scene& scene, const std::string& counted) {
  const auto rendered = render_abuffer(scene, {}, {.threads = 1});
  return test::counter(*rendered, counted);
}

/// Where what is counted becomes another number.
void step_where_it_changes(const std::string& counted) {
  const auto count_at = [&](float speed) { return counter(few_discs(speed), counted); };
  int switches = 0;
  for (float low = 0.02f; low < 4.0f; low *= 1.3f) {
    const float high = 1.02f * low;
    const double count = count_at(low);
    if (count_at(high) == count) continue;
    ++switches;
    const auto [last, first] =
        switch_between(low, high, [&](float speed) { return count_at(speed) == count; });
    EXPECT_LE(farthest_apart(image_of(few_discs(last)), image_of(few_discs(first))), 2 * piece_error) << last;
  }
  EXPECT_GE(switches, 10);
}

/// Where a piece is cut once more, or a fragment comes or goes.
TEST(Continuity, OfTheImageInTheNumberOfPieces) { step_where_it_changes("intervals"); }

/// And where a piece is looked at in another number of points.
TEST(Continuity, OfTheImageInTheNumberOfIntegrals) { step_where_it_changes("integrals"); }

/// The very speed at which pixels are swept: still path on one side, events and integrals on the other. Sums
/// of few floats in two orders, each of at most 1.
TEST(Continuity, OfTheImageWhereTheSweepTakesOver) {
  const auto swept_pixels = [](float speed) { return counter(few_discs(speed), "pixels_swept"); };
  const auto [slow, fast] =
      switch_between(0.0f, 1.0f, [&](float speed) { return swept_pixels(speed) == 0.0; });
  EXPECT_LE(farthest_apart(image_of(few_discs(slow)), image_of(few_discs(fast))), 32 * 0x1p-24) << slow;
}

/// Into how many segments a turn is cut is chosen by its angle. On either side of a choice paths are within
/// 0.1 px and rims within 0.25 px of the truth; a lone disc's min(1, 2ρ) changes by at most 2 √(2δ/e)/R per
/// px, R being its smaller radius in px.
TEST(Continuity, OfTheImageInTheNumberOfSegments) {
  constexpr double radius_px = 9.0;
  const auto turning = [](double radians) {
    Scene scene = few_discs(0.0f);
    scene.film = {48, 36, 0, 0, 0, 0};
    Object& object = scene.objects[0];
    SurfelPose pose;
    pose.position.emplace_back(0.5, 0.0, 3.6);  // 36 px of focal length: 10 px to a unit
    pose.axis_u.emplace_back(1.2f, 0.0f, 0.0f);
    pose.axis_v.emplace_back(0.0f, static_cast<float>(0.1 * radius_px), 0.0f);
    object.cloud.keys = {{0.0, std::move(pose)}};
    object.cloud.velocity.clear();
    object.cloud.color.resize(1);
    TransformKey first, last;
    first.frame = -0.5;
    last.frame = 0.5;
    first.rotate_axis = last.rotate_axis = Vector3d::UnitZ();
    last.rotate_radians = radians;
    object.transform.keys = {first, last};
    return scene;
  };
  const auto segments = [&](double radians) {
    const Scene scene = turning(radians);
    return linear_segments(scene, scene.objects[0], scene.exposure());
  };
  int choices = 0;
  for (double low = 0.001; low < 1.5;) {
    const int count = segments(low);
    double high = low;
    while (high < 1.5 && segments(high) == count) high *= 1.01;
    if (!(high < 1.5)) break;
    const auto [last, first] =
        switch_between(low, high, [&](double radians) { return segments(radians) == count; });
    EXPECT_LE(farthest_apart(image_of(turning(last)), image_of(turning(first))),
              2 * (0.1 + 0.25) * 2 * std::sqrt(2 * 3.0 / std::numbers::e) / radius_px)
        << count << " segments to " << segments(first);
    ++choices;
    low = first;
  }
  EXPECT_GE(choices, 4);
}

/// The loops that define the arithmetic and the vectors that compute it.
TEST(Continuity, VectorsChangeNoBitOfAnImage) {
  for (const oracle::HardScene& hard : oracle::hard_scenes()) {
    if (hard.name == "ten_thousand_fragments" || hard.name == "motion_1e5_px")
      continue;  // slow, and no other code
    const Scene scene = hard.make();
    const auto vectors = render_abuffer(scene, {.simd = true}),
               scalar = render_abuffer(scene, {.simd = false});
    ASSERT_TRUE(vectors && scalar);
    EXPECT_EQ(vectors->image.rgba, scalar->image.rgba) << hard.name;
    EXPECT_EQ(vectors->image.depth, scalar->image.depth) << hard.name;
  }
}

}  // namespace
}  // namespace swept
