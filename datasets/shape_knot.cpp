// A tube along a (p, q) torus knot.
#include <cmath>

#include <Eigen/Geometry>

#include "datasets/paint.h"
#include "datasets/sampling.h"

namespace swept::datasets {
namespace {

// The knot winds p times around the z axis and q times around the ring, radius kRing.
constexpr double kRing = 0.7, kWinding = 0.3;

struct Derivatives {
  Eigen::Vector3d c, d, dd;  ///< position, first and second derivative by t in [0, 2π)
};

Derivatives knot_at(double t, int p, int q) {
  const double cp = std::cos(p * t), sp = std::sin(p * t), cq = std::cos(q * t), sq = std::sin(q * t);
  const double r = kRing + kWinding * cq, dr = -kWinding * q * sq, ddr = -kWinding * q * q * cq;
  return {{r * cp, r * sp, kWinding * sq},
          {dr * cp - r * p * sp, dr * sp + r * p * cp, kWinding * q * cq},
          {ddr * cp - 2.0 * dr * p * sp - r * p * p * cp, ddr * sp + 2.0 * dr * p * cp - r * p * p * sp,
           -kWinding * q * q * sq}};
}

// Arc length and a frame that does not twist about the tangent, so that the chart is orthogonal.
class Spine {
 public:
  Spine(int p, int q) : p_(p), q_(q) {
    Derivatives here = knot_at(0.0, p, q);
    Eigen::Vector3d normal = here.d.cross(Eigen::Vector3d::UnitZ()).normalized();
    length_.push_back(0.0);
    normal_.push_back(normal);
    for (int i = 1; i <= kSteps; ++i) {
      const Derivatives next = knot_at(step() * i, p, q);
      const Derivatives middle = knot_at(step() * (i - 0.5), p, q);
      const double speeds = here.d.norm() + 4.0 * middle.d.norm() + next.d.norm();  // Simpson
      length_.push_back(length_.back() + step() * speeds / 6.0);
      normal = Eigen::Quaterniond::FromTwoVectors(here.d, next.d) * normal;
      normal_.push_back(normal);
      max_curvature_ = std::max(max_curvature_, next.d.cross(next.dd).norm() / std::pow(next.d.norm(), 3));
      here = next;
    }
    const Eigen::Vector3d tangent = here.d.normalized();
    closing_turn_ = std::atan2(normal_[0].dot(tangent.cross(normal)), normal_[0].dot(normal));
  }

  struct Frame {
    Eigen::Vector3d center, tangent, normal, binormal;
    Eigen::Vector3d curvature;  ///< d tangent / d arc length
  };
  /// At share u of the length.
  [[nodiscard]] Frame at(double u) const {
    const double s = u * length();
    const auto above = std::upper_bound(length_.begin(), length_.end() - 1, s);
    const std::size_t i = static_cast<std::size_t>(above - length_.begin()) - 1;
    const double f = (s - length_[i]) / (length_[i + 1] - length_[i]);
    const Derivatives k = knot_at(step() * (static_cast<double>(i) + f), p_, q_);
    const Eigen::Vector3d tangent = k.d.normalized();
    Eigen::Vector3d normal = (1.0 - f) * normal_[i] + f * normal_[i + 1];
    normal = (normal - normal.dot(tangent) * tangent).normalized();
    const Eigen::Vector3d curvature = (k.dd - k.dd.dot(tangent) * tangent) / k.d.squaredNorm();
    return {k.c, tangent, normal, tangent.cross(normal), curvature};
  }
  [[nodiscard]] double length() const { return length_.back(); }
  [[nodiscard]] double max_curvature() const { return max_curvature_; }
  /// Angle from the last frame to the first about the tangent.
  [[nodiscard]] double closing_turn() const { return closing_turn_; }

 private:
  static constexpr int kSteps = 8192;
  static double step() { return 2.0 * kPi / kSteps; }
  int p_, q_;
  std::vector<double> length_;
  std::vector<Eigen::Vector3d> normal_;
  double max_curvature_ = 0.0, closing_turn_ = 0.0;
};

Eigen::Vector3d knot_color(double u, double phi, int bands) {
  const unsigned palette[8] = {0xef476f, 0xf78c3b, 0xffd23f, 0x6fcf4a,
                               0x06b6a0, 0x1d8fe1, 0x5a4fd6, 0xb544c8};
  const double place = u * bands, within = place - std::floor(place);
  const int band = cell(place, bands);
  if (within < 0.12) return srgb(0xfffaf0);
  const Eigen::Vector3d color = srgb(palette[band * 8 / bands]);
  return cell(phi / (2.0 * kPi) * 8.0, 2) == 0 ? color : mix(color, srgb(0x101020), 0.55);
}

Result<SurfelCloud> build(const Request& request) {
  const int p = request.whole("p"), q = request.whole("q"), bands = request.whole("bands");
  const double tube = request.number("tube");
  const Spine spine(p, q);
  if (tube * spine.max_curvature() > 0.9) {
    return Error{"", "tube",
                 "the tube is too thick for the bends of this knot; at most " +
                     std::to_string(0.9 / spine.max_curvature())};
  }
  CloudBuilder builder(request);
  builder.add_patch(request.points(), CloudBuilder::Sides::outer, [&](double u, double v) {
    const Spine::Frame frame = spine.at(u);
    const double phi = 2.0 * kPi * v;
    const Eigen::Vector3d out = std::cos(phi) * frame.normal + std::sin(phi) * frame.binormal;
    Eigen::Vector3d around =
        2.0 * kPi * tube * (std::cos(phi) * frame.binormal - std::sin(phi) * frame.normal);
    Eigen::Vector3d along = spine.length() * (1.0 - tube * frame.curvature.dot(out)) * frame.tangent;
    even_out(around, along);
    // tangent × normal = binormal, so around × along = out.
    return SurfaceSample{frame.center + tube * out, around, along,
                         knot_color(u, phi - spine.closing_turn() * u, bands)};
  });
  return builder.take();
}

}  // namespace

Shape knot_shape() {
  return {"knot",
          {{"p", 2, 1, 12, true, "turns about the z axis"},
           {"q", 3, 1, 12, true, "turns about the ring"},
           {"tube", 0.15, 0.005, 0.5, false, "radius of the tube, object units"},
           {"bands", 32, 1, 1000, true, "colour bands along the tube"}},
          build};
}

}  // namespace swept::datasets
