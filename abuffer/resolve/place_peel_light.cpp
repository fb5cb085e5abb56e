// The light that layers take, one after the other.
#include <algorithm>
#include <cmath>

#include "abuffer/resolve/place_peel.h"
#include "abuffer/resolve/texel_cuts.h"

namespace swept {
namespace {

/// How often a part is halved at most. At shutters' corners, and where a triangle is seen from the side,
/// nothing is smooth.
constexpr int most_halvings = 10;

/// Whether its polynomial is it to 10⁻⁶ of the light, part by part.
bool close_enough(const SmoothPart& part) { return std::abs(part.share(4)) <= 0x1p-19; }

double middle(const LightLeft::Part& part) { return 0.5 * part.begin + 0.5 * part.end; }

}  // namespace

/// Whether the integral of what has these values is theirs to about 10⁻⁶ of `most`. What the rule leaves out
/// begins at degree 10; where shares of Legendre's polynomials halve from degree to degree that is a 64th of
/// what there is at degree 4. A shutter that opens slowly has time go as the root of light, whose shares fall
/// as squares of degrees.
bool PlacePeel::smooth_enough(const SmoothPart& values, double span, double most) const {
  return span * (std::abs(values.share(3)) + std::abs(values.share(4))) <=
         (light_->even() ? 0x1p-15 : 0x1p-18) * most;
}

double PlacePeel::depth_at(std::uint32_t layer, double time) {
  const Layer& of = layers_[layer];
  if (!of.is_parabola()) return depth(layer).at(time);
  const double u = (time - of.since) * of.per_time;
  return of.z_begin + u * (of.slope() + u * of.bend());
}

/// ∫ z ds over these shares of light.
double PlacePeel::depth_over(std::uint32_t layer, double first, double last) {
  const Layer& of = layers_[layer];
  if (!light_->even() || !of.is_parabola()) {
    const PlaceDepth& exact = depth(layer);
    return smooth_integral(*light_, first, last, [&](double time) { return exact.at(time); });
  }
  const double span = (last - first) * of.per_time,
               middle = (0.5 * first + 0.5 * last - of.since) * of.per_time;
  return (last - first) *
         (of.z_begin + middle * (of.slope() + middle * of.bend()) + of.bend() * (span * span) * (1.0 / 12.0));
}

/// Adds what is seen of the layer, and leaves the light that it leaves. False: none.
bool PlacePeel::take(std::uint32_t layer, LightSum& sum) {
  const Layer& of = layers_[layer];
  const double from = light_->share(of.begin), to = light_->share(of.end);
  if (!(from < to)) return true;
  const TriangleStretch& triangle = (*triangles_)[of.source];
  looked_ = false;
  if (!triangle.even_alpha)
    return left_.meet(from, to, [&](const LightLeft::Part& part) {
      ++counters_->pieces;
      make_look(of);
      between_texels(part, [&](const LightLeft::Part& p) { take_uneven(layer, p, most_halvings, sum); });
    });
  const double alpha = double{triangle.rgba[0][3]}, through = 1.0 - alpha;
  double weight = 0.0;
  LightSum taken;
  const bool lit = left_.meet(from, to, [&](const LightLeft::Part& part) {
    ++counters_->pieces;
    if (!triangle.plain) {
      make_look(of);
      if (on_way_)
        way_.see(part);
      else
        between_texels(part, [&](const LightLeft::Part& p) { add_colors(p, most_halvings, sum); });
    }
    if (part.is_even) {
      weight += part.even * part.span();
      taken.v[4] += part.even * depth_over(layer, part.begin, part.end);
      left_.leave(part.end, part.even * through);
      return;
    }
    weight += part.changes.mean() * part.span();
    add_depths(layer, part, most_halvings, taken);
    SmoothPart left = part.changes;
    for (double& v : left.v) v *= through;
    left_.leave(part.end, left);
  });
  if (looked_ && on_way_) way_.add_light(triangle, sum);
  for (int c = triangle.plain ? 0 : 3; c < 4; ++c) sum.v[c] += weight * double{triangle.rgba[0][c]};
  sum.v[4] += alpha * taken.v[4];
  return lit;
}

/// Once for all parts of a layer.
void PlacePeel::make_look(const Layer& of) {
  if (looked_) return;
  looked_ = true;
  const TriangleStretch& triangle = (*triangles_)[of.source];
  on_way_ = triangle.texture != nullptr && triangle.one_color && triangle.even_alpha && light_->even() &&
            way_.find(triangle, *ray_, of.begin, of.end);
  if (on_way_) return;
  look_ = PlaceLook(triangle, *ray_);
  texel_cuts_.clear();
  if (triangle.texture == nullptr) return;
  add_texel_cuts([&](double time) { return look_.on_texture(time); }, of.begin, of.end, texel_cuts_);
  std::sort(texel_cuts_.begin(), texel_cuts_.end());
  if (!light_->even())
    for (double& cut : texel_cuts_) cut = light_->share(cut);
}

template <class Take>
void PlacePeel::between_texels(const LightLeft::Part& part, const Take& take) {
  double begin = part.begin;
  for (auto cut = std::upper_bound(texel_cuts_.begin(), texel_cuts_.end(), begin);
       cut != texel_cuts_.end() && *cut < part.end; ++cut) {
    if (!(begin < *cut)) continue;
    take(part.between(begin, *cut));
    begin = *cut;
  }
  take(part.between(begin, part.end));
}

/// Of a layer that lets light through evenly: red, green and blue.
void PlacePeel::add_colors(const LightLeft::Part& part, int halvings, LightSum& sum) const {
  SmoothPart seen[3];
  for (std::size_t k = 0; k < smooth_points; ++k) {
    double rgba[4];
    look_.at(light_->time(part.begin + smooth_part::at[k] * part.span()), rgba);
    for (int c = 0; c < 3; ++c) seen[c].v[k] = part.at(k) * rgba[c];
  }
  if (halvings > 0)
    for (const SmoothPart& of : seen)
      if (!smooth_enough(of, part.span(), std::max(1.0, std::abs(of.v[smooth_points / 2])))) {
        add_colors(part.between(part.begin, middle(part)), halvings - 1, sum);
        return add_colors(part.between(middle(part), part.end), halvings - 1, sum);
      }
  for (int c = 0; c < 3; ++c) sum.v[c] += part.span() * seen[c].mean();
}

/// ∫ z ds by what is left.
void PlacePeel::add_depths(std::uint32_t layer, const LightLeft::Part& part, int halvings, LightSum& sum) {
  SmoothPart seen;
  for (std::size_t k = 0; k < smooth_points; ++k)
    seen.v[k] = part.at(k) * depth_at(layer, light_->time(part.begin + smooth_part::at[k] * part.span()));
  if (halvings > 0 && !smooth_enough(seen, part.span(), layers_[layer].z_middle)) {
    add_depths(layer, part.between(part.begin, middle(part)), halvings - 1, sum);
    return add_depths(layer, part.between(middle(part), part.end), halvings - 1, sum);
  }
  sum.v[4] += part.span() * seen.mean();
}

/// Of a layer that lets more light through here and then than there: all of it.
void PlacePeel::take_uneven(std::uint32_t layer, const LightLeft::Part& part, int halvings, LightSum& sum) {
  SmoothPart seen[5], left;
  for (std::size_t k = 0; k < smooth_points; ++k) {
    const double time = light_->time(part.begin + smooth_part::at[k] * part.span());
    double rgba[4];
    look_.at(time, rgba);
    for (int c = 0; c < 4; ++c) seen[c].v[k] = part.at(k) * rgba[c];
    seen[4].v[k] = seen[3].v[k] * depth_at(layer, time);
    left.v[k] = part.at(k) * (1.0 - rgba[3]);
  }
  if (halvings > 0) {
    bool good = close_enough(left) && smooth_enough(seen[4], part.span(), layers_[layer].z_middle);
    for (int c = 0; c < 3; ++c)
      good =
          good && smooth_enough(seen[c], part.span(), std::max(1.0, std::abs(seen[c].v[smooth_points / 2])));
    if (!good) {
      take_uneven(layer, part.between(part.begin, middle(part)), halvings - 1, sum);
      return take_uneven(layer, part.between(middle(part), part.end), halvings - 1, sum);
    }
  }
  for (int c = 0; c < 5; ++c) sum.v[c] += part.span() * seen[c].mean();
  left_.leave(part.end, left);
}

}  // namespace swept
