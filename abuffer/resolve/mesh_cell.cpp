#include "abuffer/resolve/mesh_cell.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "splat/interval/composite.h"
#include "splat/interval/pixel_places.h"

namespace swept {
namespace {

constexpr auto all_places = static_cast<std::uint16_t>((1u << pixel_places) - 1);

}  // namespace

void MeshCell::draw(const PlacedTriangle& placed, std::uint32_t index, const FilmBox& box, const Cell& cell) {
  const auto first = [](double px, int begin, int size) {
    return static_cast<int>(std::clamp(std::floor(px) - 1.0 - begin, 0.0, double{1.0} * size));
  };
  const auto last = [](double px, int begin, int size) {
    return static_cast<int>(std::clamp(std::floor(px) + 2.0 - begin, 0.0, double{1.0} * size));
  };
  const int x_begin = first(box.x_min, cell.x, cell.width), x_end = last(box.x_max, cell.x, cell.width);
  const int y_begin = first(box.y_min, cell.y, cell.height), y_end = last(box.y_max, cell.y, cell.height);
  for (int y = y_begin; y < y_end; ++y)
    for (int x = x_begin; x < x_end; ++x) {
      const double film_x = cell.x + x + 0.5, film_y = cell.y + y + 0.5;
      unsigned mask = all_places;
      for (std::size_t i = 0; i < 3 && mask != 0; ++i) {
        const Linear& edge = placed.edge[i];
        const double middle = edge.at(film_x, film_y);
        if (middle < -0.5) mask = 0;
        if (middle < -0.5 || middle > 0.5) continue;
        const auto at_middle = static_cast<float>(middle), a = static_cast<float>(edge.a),
                   b = static_cast<float>(edge.b);
        unsigned inside = 0;
        for (int k = 0; k < pixel_places; ++k) {
          const float v = at_middle + (a * places_in_pixel.x[k] + b * places_in_pixel.y[k]);
          inside |= static_cast<unsigned>(v > 0.0f || (v == 0.0f && placed.owns[i])) << k;
        }
        mask &= inside;
      }
      if (mask != 0 && placed.cut) {
        const auto middle = static_cast<float>(placed.inverse_depth.at(film_x, film_y)),
                   a = static_cast<float>(placed.inverse_depth.a),
                   b = static_cast<float>(placed.inverse_depth.b);
        for (int k = 0; k < pixel_places; ++k) {
          const float w = middle + (a * places_in_pixel.x[k] + b * places_in_pixel.y[k]);
          if (!(w > 0.0f && w <= placed.nearest)) mask &= ~(1u << k);
        }
      }
      if (mask == 0) continue;
      fragments_.push_back(
          {index, static_cast<std::uint16_t>(y * cell_px + x), static_cast<std::uint16_t>(mask)});
    }
}

/// Of one pixel: the k-th nearest of what each place meets is the k-th surface.
void MeshCell::shade(std::uint32_t pixel, std::size_t begin, std::size_t end, const Cell& cell, bool opaque,
                     std::vector<SampledCell::Surface>& surfaces) const {
  const int x = static_cast<int>(pixel) % cell_px, y = static_cast<int>(pixel) / cell_px;
  const double film_x = cell.x + x + 0.5, film_y = cell.y + y + 0.5;
  constexpr auto none = static_cast<std::uint32_t>(-1);
  // Of the layer before: what lies behind it, or at its depth and later in the mesh, is left.
  float last_inverse[pixel_places];
  std::uint32_t last[pixel_places];
  std::fill(last_inverse, last_inverse + pixel_places, std::numeric_limits<float>::infinity());
  std::fill(last, last + pixel_places, none);
  float through = 1.0f;
  do {
    float inverse[pixel_places];
    std::uint32_t nearest[pixel_places];
    std::fill(inverse, inverse + pixel_places, 0.0f);
    std::fill(nearest, nearest + pixel_places, none);
    for (std::size_t f = begin; f < end; ++f) {
      const Fragment& fragment = sorted_[f];
      const Linear& inverse_depth = placed_[fragment.placed].inverse_depth;
      const auto middle = static_cast<float>(inverse_depth.at(film_x, film_y)),
                 a = static_cast<float>(inverse_depth.a), b = static_cast<float>(inverse_depth.b);
      for (int k = 0; k < pixel_places; ++k) {
        if ((fragment.mask >> k & 1u) == 0) continue;
        const float w = middle + (a * places_in_pixel.x[k] + b * places_in_pixel.y[k]);
        const bool left = w < last_inverse[k] || (w == last_inverse[k] && fragment.placed > last[k]);
        if (left && w > inverse[k]) {
          inverse[k] = w;
          nearest[k] = fragment.placed;
        }
      }
    }
    float rgba[4] = {0.0f, 0.0f, 0.0f, 0.0f}, depth = 0.0f, met = 0.0f;
    std::uint32_t done = 0;
    for (int k = 0; k < pixel_places; ++k) {
      if (nearest[k] == none || (done >> k & 1u) != 0) continue;
      const PlacedTriangle& placed = placed_[nearest[k]];
      Linear share[3];
      for (std::size_t i = 0; i < 3; ++i) {
        const double weight = placed.weight[i];
        share[i] = {weight * placed.edge[i].a, weight * placed.edge[i].b,
                    weight * placed.edge[i].at(film_x, film_y)};
      }
      for (int j = k; j < pixel_places; ++j) {
        if (nearest[j] != nearest[k]) continue;
        done |= 1u << j;
        depth += 1.0f / inverse[j];
        met += 1.0f;
        if (placed.plain) {
          for (int c = 0; c < 4; ++c) rgba[c] += placed.rgba[0][c];
          continue;
        }
        const double dx = double{places_in_pixel.x[j]}, dy = double{places_in_pixel.y[j]};
        double corner[3], sum = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
          corner[i] = std::max(0.0, share[i].a * dx + share[i].b * dy + share[i].c);
          sum += corner[i];
        }
        for (int c = 0; c < 4; ++c) {
          const double value = corner[0] * double{placed.rgba[0][c]} + corner[1] * double{placed.rgba[1][c]} +
                               corner[2] * double{placed.rgba[2][c]};
          rgba[c] += static_cast<float>(sum > 0.0 ? value / sum : double{placed.rgba[0][c]});
        }
      }
    }
    if (met == 0.0f) return;
    constexpr float per_place = 1.0f / pixel_places;
    const float alpha = std::min(1.0f, rgba[3] * per_place);
    surfaces.push_back(
        {x, y, depth / met, {rgba[0] * per_place, rgba[1] * per_place, rgba[2] * per_place, alpha}});
    through *= 1.0f - alpha;
    std::copy(inverse, inverse + pixel_places, last_inverse);
    std::copy(nearest, nearest + pixel_places, last);
  } while (!opaque && through > opaque_transmittance);
}

void MeshCell::add(const MeshInstant& mesh, const Cell& cell, std::size_t index,
                   std::vector<SampledCell::Surface>& surfaces) {
  placed_.clear();
  fragments_.clear();
  for (const std::uint32_t t : mesh.triangles(index)) {
    const std::optional<PlacedTriangle> placed = PlacedTriangle::make(mesh, t);
    const std::optional<FilmBox> box = mesh.box(t);
    if (!placed || !box) continue;
    placed_.push_back(*placed);
    draw(placed_.back(), static_cast<std::uint32_t>(placed_.size() - 1), *box, cell);
  }
  fragments += fragments_.size();
  starts_.assign(cell_px * cell_px + 1, 0);
  for (const Fragment& fragment : fragments_) ++starts_[fragment.pixel + 1];
  for (std::size_t p = 0; p < cell_px * cell_px; ++p) starts_[p + 1] += starts_[p];
  sorted_.resize(fragments_.size());
  for (const Fragment& fragment : fragments_) sorted_[starts_[fragment.pixel]++] = fragment;
  const bool opaque = mesh.object().cloud.opacity.empty();
  for (std::size_t begin = 0; begin < sorted_.size();) {
    const std::uint32_t pixel = sorted_[begin].pixel;
    const std::size_t end = starts_[pixel];
    shade(pixel, begin, end, cell, opaque, surfaces);
    begin = end;
  }
}

}  // namespace swept
