#include "abuffer/resolve/lone.h"

#include <algorithm>
#include <cmath>

#include "splat/kernel/kernel_integral.h"

namespace swept {
namespace {

struct Lone {
  double y, rate;    ///< at the piece's begin
  double z, z_rate;  ///< likewise
  float peak;
  float rgba[4];
  float rgba_rate[4] = {0.0f, 0.0f, 0.0f, 0.0f};
  bool changes = false;

  /// Adds [from, to], shares of the exposure after the piece's begin. Where it covers the pixel it is seen
  /// alike wherever it is; else as much as it weighs.
  void add(const SurfaceModel& model, double from, double to, bool covers, PixelSum& pixel) const {
    const double duration = to - from;
    if (!(duration > 0.0)) return;
    const double y_from = y + rate * from, y_to = y + rate * to;
    const float mean = peak * mean_gaussian_as<float>(y_from, y_to);
    const double place =
        covers || rate == 0.0 || (z_rate == 0.0 && !changes) ? 0.0 : gaussian_centroid(y_from, y_to);
    const double middle = from + (0.5 + place) * duration;
    SurfaceSum sum;
    sum.weight = mean;
    for (int c = 0; c < 4; ++c) sum.rgba[c] = mean * rgba[c];
    // What is linear has the mean that it has where the weight's centre is.
    if (changes)
      for (int c = 0; c < 4; ++c) sum.rgba[c] += mean * (rgba_rate[c] * static_cast<float>(middle));
    sum.depth = mean * static_cast<float>(z + z_rate * middle);
    float transmittance = 1.0f;
    const DepthSpan span{z + z_rate * from, z + z_rate * to};
    model.add(sum, duration, transmittance, pixel, &span);
  }
};

}  // namespace

void add_lone(const SurfaceModel& model, const MemberSet& members, std::size_t i, Ticks begin, Ticks end,
              PixelSum& pixel, const float* color_rate) {
  const double since = share_of(begin - members.t_begin(i)), duration = share_of(end - begin);
  const double rate = members.field(member_rate)[i], z_rate = members.field(member_z_rate)[i];
  Lone lone{members.field(member_y)[i] + rate * since,
            rate,
            members.field(member_z)[i] + z_rate * since,
            z_rate,
            members.field(member_peak)[i],
            {members.field(member_red)[i], members.field(member_green)[i], members.field(member_blue)[i],
             members.field(member_alpha)[i]}};
  if (color_rate != nullptr) {
    lone.changes = true;
    for (int c = 0; c < 4; ++c) {
      lone.rgba_rate[c] = color_rate[c];
      lone.rgba[c] += static_cast<float>(since) * color_rate[c];
    }
  }
  if (model.hard()) return lone.add(model, 0.0, duration, true, pixel);
  if (lone.peak <= model.edge_weight()) return lone.add(model, 0.0, duration, false, pixel);
  const double reach = std::sqrt(std::log(double{lone.peak} / double{model.edge_weight()}));
  double from = 0.0, to = duration;
  if (rate > 0.0) {
    from = std::clamp((-reach - lone.y) / rate, 0.0, duration);
    to = std::clamp((reach - lone.y) / rate, from, duration);
  } else if (std::abs(lone.y) > reach) {
    to = 0.0;
  }
  lone.add(model, 0.0, from, false, pixel);
  lone.add(model, from, to, true, pixel);
  lone.add(model, to, duration, false, pixel);
}

}  // namespace swept
