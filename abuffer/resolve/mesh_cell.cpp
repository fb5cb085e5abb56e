#include "abuffer/resolve/mesh_cell.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "splat/interval/composite.h"

namespace swept {
namespace {

constexpr std::uint16_t all_places = (1u << pixel_places) - 1;

/// Whole numbers of [begin, end), from floor(low) and up to floor(high), both included.
struct Pixels {
  int begin, end;

  [[nodiscard]] Pixels within(double low, double high) const {
    return {static_cast<int>(std::clamp<double>(std::floor(low), begin, end)),
            static_cast<int>(std::clamp<double>(std::floor(high) + 1.0, begin, end))};
  }
};

void lay_textures_over(const std::vector<PlacedTriangle>& placed, const MeshLayer& layer,
                       MeshColors& colors) {
  for (int k = 0; k < pixel_places; ++k) {
    if (layer.triangle[k] < 0.0f) continue;
    const Texture* const texture = placed[static_cast<std::size_t>(layer.triangle[k])].texture;
    if (texture == nullptr) continue;
    const Eigen::Vector4f texel = texture->at(colors.uv[0][k], colors.uv[1][k]);
    for (int c = 0; c < 4; ++c) colors.rgba[c][k] *= texel[c];
  }
}

}  // namespace

void MeshCell::draw(const PlacedTriangle& placed, const FilmBox& box, const Cell& cell) {
  const Pixels rows = Pixels{0, cell.height}.within(box.y_min - cell.y - 1.0, box.y_max - cell.y + 1.0);
  const Pixels columns = Pixels{0, cell.width}.within(box.x_min - cell.x - 1.0, box.x_max - cell.x + 1.0);
  for (int y = rows.begin; y < rows.end; ++y) draw_row(placed, columns.begin, columns.end, y, cell);
}

/// Of pixels whose middle lies more than ½ inside all edges every place is met, and more than ½ outside one
/// of them none. The outermost place is 1/32 short of that, which takes care of rounding.
void MeshCell::draw_row(const PlacedTriangle& placed, int x_begin, int x_end, int y, const Cell& cell) {
  const double film_y = cell.y + y + 0.5;
  // In terms of the pixels' middles: where an edge may be met, and where all places are inside.
  double low = x_begin + 0.5, high = x_end - 0.5, inner_low = low, inner_high = high;
  for (const Linear& edge : placed.edge) {
    const double at_zero = edge.at(cell.x, film_y);
    if (edge.a > 0.0) {
      low = std::max(low, (-0.5 - at_zero) / edge.a);
      inner_low = std::max(inner_low, (0.5 - at_zero) / edge.a);
    } else if (edge.a < 0.0) {
      high = std::min(high, (-0.5 - at_zero) / edge.a);
      inner_high = std::min(inner_high, (0.5 - at_zero) / edge.a);
    } else {
      if (at_zero < -0.5) return;
      if (!(at_zero > 0.5)) inner_high = -1.0;
    }
  }
  if (!(low <= high)) return;
  if (placed.cut) inner_high = -1.0;
  const auto triangle = static_cast<std::uint32_t>(placed_.size() - 1);
  const int first = std::max(x_begin, static_cast<int>(std::ceil(low - 0.5))),
            last = std::min(x_end - 1, static_cast<int>(std::floor(high - 0.5)));
  for (int x = first; x <= last; ++x) {
    const double middle = x + 0.5;
    std::uint32_t mask = all_places;
    if (!(middle >= inner_low && middle <= inner_high)) mask = math_.inside(placed, cell.x + middle, film_y);
    if (mask == 0) continue;
    fragments_.push_back(
        {triangle, static_cast<std::uint16_t>(y * cell_px + x), static_cast<std::uint16_t>(mask)});
  }
}

/// One pixel's surfaces, from the nearest: the k-th is what the places meet as their k-th, as a share of the
/// light that those before it let through.
void MeshCell::shade(const MeshInstant& mesh, const Cell& cell, std::size_t begin, std::size_t end,
                     std::vector<SampledCell::Surface>& surfaces) const {
  const int x = sorted_[begin].pixel % cell_px, y = sorted_[begin].pixel / cell_px;
  const double film_x = cell.x + x + 0.5, film_y = cell.y + y + 0.5;
  const bool parallel = mesh.projection().orthographic;
  MeshLayer last, next;
  std::fill(last.inverse_depth, last.inverse_depth + pixel_places, std::numeric_limits<float>::infinity());
  std::fill(last.triangle, last.triangle + pixel_places, -1.0f);
  float light[pixel_places], before = 1.0f;
  std::fill(light, light + pixel_places, 1.0f);
  while (before > opaque_transmittance &&
         math_.meet_next(placed_.data(), &sorted_[begin], end - begin, film_x, film_y, last, next)) {
    MeshColors colors{};
    for (int k = 0; k < pixel_places; ++k) {
      const float t = next.triangle[k];
      if (t < 0.0f || std::find(next.triangle, next.triangle + k, t) != next.triangle + k) continue;
      math_.color(placed_.data(), static_cast<std::uint32_t>(t), film_x, film_y, next, colors);
    }
    if (!mesh.object().texture_corners.empty()) lay_textures_over(placed_, next, colors);
    float seen[4] = {0.0f, 0.0f, 0.0f, 0.0f}, depth = 0.0f, after = 0.0f;
    for (int k = 0; k < pixel_places; ++k) {
      constexpr float per_place = 1.0f / pixel_places;
      const float share = light[k] * per_place, alpha = colors.rgba[3][k];
      for (std::size_t c = 0; c < 4; ++c) seen[c] += share * colors.rgba[c][k];
      if (alpha > 0.0f)
        depth += parallel ? share * alpha * mesh.depth_of(next.inverse_depth[k])
                          : share * alpha / next.inverse_depth[k];
      light[k] *= 1.0f - alpha;
      after += light[k] * per_place;
    }
    if (seen[3] > 0.0f)
      surfaces.push_back(
          {x,
           y,
           depth / seen[3],
           {seen[0] / before, seen[1] / before, seen[2] / before, std::min(1.0f, seen[3] / before)}});
    before = after;
    last = next;
  }
}

void MeshCell::add(const MeshInstant& mesh, const Cell& cell, std::size_t index,
                   std::vector<SampledCell::Surface>& surfaces) {
  const std::span<const std::uint32_t> triangles = mesh.triangles(index);
  if (triangles.empty()) return;
  placed_.clear();
  fragments_.clear();
  for (const std::uint32_t t : triangles) {
    const std::optional<PlacedTriangle> placed = place_triangle(mesh, t);
    const std::optional<FilmBox> box = mesh.box(t);
    if (!placed || !box) continue;
    placed_.push_back(*placed);
    draw(*placed, *box, cell);
  }
  // Stable: within a pixel triangles keep the mesh's order.
  starts_.assign(cell_px * cell_px + 1, 0);
  for (const MeshFragment& fragment : fragments_) ++starts_[fragment.pixel + 1u];
  for (std::size_t p = 0; p < cell_px * cell_px; ++p) starts_[p + 1] += starts_[p];
  sorted_.resize(fragments_.size());
  for (const MeshFragment& fragment : fragments_) sorted_[starts_[fragment.pixel]++] = fragment;
  for (std::size_t begin = 0; begin < sorted_.size();) {
    const std::size_t end = starts_[sorted_[begin].pixel];
    shade(mesh, cell, begin, end, surfaces);
    begin = end;
  }
}

}  // namespace swept
