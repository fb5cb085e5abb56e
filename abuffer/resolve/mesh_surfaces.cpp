// What surfaces a pixel's places make of each mesh: model section 15.3.
#include <algorithm>
#include <limits>

#include "abuffer/resolve/mesh_pixel.h"
#include "splat/without_throwing.h"

namespace swept {

void MeshPixel::list_surfaces() {
  surfaces_.clear();
  parts_.clear();
  for (std::size_t first = 0; first < on_.size();) {
    std::size_t last = first + 1;
    while (last < on_.size() && tracks_[on_[last]].mesh == tracks_[on_[first]].mesh) ++last;
    list_mesh(first, last);
    first = last;
  }
  of_meshes_ = surfaces_.size();
  list_discs();
}

void MeshPixel::list_mesh(std::size_t first, std::size_t last) {
  std::uint32_t most = 0;
  for (std::size_t i = first; i < last; ++i) most = std::max(most, view_.pieces[tracks_[on_[i]].next].count);
  double light[pixel_places];
  std::fill(light, light + pixel_places, 1.0);
  bool open[pixel_places];  // light is left there, or may be
  std::fill(open, open + pixel_places, true);
  for (std::uint32_t layer = 0; layer < most; ++layer) {
    Surface surface;
    surface.owner = tracks_[on_[first]].mesh;
    surface.first = parts_.size();
    surface.nearest = std::numeric_limits<float>::infinity();
    surface.farthest = -surface.nearest;
    for (std::size_t i = first; i < last; ++i) {
      const Track& track = tracks_[on_[i]];
      const PlacePiece& piece = view_.pieces[track.next];
      if (piece.count <= layer) continue;
      const std::uint32_t seen = view_.seen[piece.first + layer];
      const PlaceLayer& of = view_.layers[seen];
      parts_.push_back({track.place, seen, 0.0});
      surface.nearest = std::min(surface.nearest, of.nearest);
      surface.farthest = std::max(surface.farthest, of.farthest);
      if (of.opaque) open[track.place] = false;
    }
    surface.count = parts_.size() - surface.first;
    surface.opaque = std::none_of(open, open + pixel_places, [](bool o) { return o; });
    if (plain_) color_plain(surface, light);
    surfaces_.push_back(surface);
    double left = 0.0;
    for (const double l : light) left += l / pixel_places;
    if (surface.opaque || (plain_ && !(left > double{opaque_transmittance}))) return;
  }
}

/// Once for all the time between two events.
void MeshPixel::color_plain(Surface& surface, double (&light)[pixel_places]) {
  double before = 0.0;
  for (const double l : light) before += l / pixel_places;
  for (std::size_t p = surface.first; p < surface.first + surface.count; ++p) {
    Part& part = parts_[p];
    const float(&rgba)[4] = (*triangles_)[view_.layers[part.layer].source].rgba[0];
    double& left = light[part.place];
    const double share = left / pixel_places;
    for (int c = 0; c < 4; ++c) surface.rgba[c] += share * double{rgba[c]};
    part.weight = share * double{rgba[3]};
    left *= 1.0 - double{rgba[3]};
  }
  if (!(surface.rgba[3] > 0.0)) return;
  for (std::size_t p = surface.first; p < surface.first + surface.count; ++p)
    parts_[p].weight /= surface.rgba[3];
  for (double& v : surface.rgba) v /= before;
}

void MeshPixel::list_discs() {
  for (const MovingSurface& disc : discs_) {
    Surface surface;
    surface.owner = of_discs;
    double low = std::min(disc.z_begin, disc.z_end), high = std::max(disc.z_begin, disc.z_end);
    for (const SurfaceMember& m : disc.members)
      for (const double z : {m.z, m.z + m.z_rate * (last_share_ - first_share_)})
        low = std::min(low, z), high = std::max(high, z);
    // Rounding, and a float's.
    surface.nearest = static_cast<float>(low - 1e-6 * std::abs(low));
    surface.farthest = static_cast<float>(high + 1e-6 * std::abs(high));
    surface.opaque = disc.members.empty() && disc.rgba[3] - std::abs(disc.swing[3]) >= 1.0;
    surfaces_.push_back(surface);
  }
}

double MeshPixel::depth_of(const Surface& surface, double time) {
  double depth = 0.0;
  for (std::size_t p = surface.first; p < surface.first + surface.count; ++p) {
    const Part& part = parts_[p];
    depth += part.weight * view_.depth(part.layer, *triangles_, (*rays_)[part.place]).at(time);
  }
  return depth;
}

void MeshPixel::look(double time) {
  for (std::size_t first = 0; first < of_meshes_;) {
    std::size_t last = first + 1;
    while (last < of_meshes_ && surfaces_[last].owner == surfaces_[first].owner) ++last;
    if (plain_)
      for (std::size_t i = first; i < last; ++i) surfaces_[i].depth = depth_of(surfaces_[i], time);
    else
      look_at_mesh(first, last, time);
    first = last;
  }
  if (discs_.empty()) return;
  const double share = light_->share(time);
  const double at = last_share_ > first_share_ ? (share - first_share_) / (last_share_ - first_share_) : 0.5;
  for (std::size_t i = 0; i < discs_.size(); ++i) {
    const MovingSurface::Look seen = discs_[i].at(*model_, share - first_share_, at);
    Surface& surface = surfaces_[of_meshes_ + i];
    surface.depth = seen.depth;
    std::copy_n(seen.rgba, 4, surface.rgba);
  }
}

void MeshPixel::look_at_mesh(std::size_t first, std::size_t last, double time) {
  throw_if_stopped(sweep_->stop);
  double light[pixel_places];
  std::fill(light, light + pixel_places, 1.0);
  for (std::size_t i = first; i < last; ++i) {
    Surface& surface = surfaces_[i];
    double before = 0.0, depths = 0.0;
    for (const double l : light) before += l / pixel_places;
    std::fill(surface.rgba, surface.rgba + 4, 0.0);
    surface.depth = 0.0;
    for (std::size_t p = surface.first; p < surface.first + surface.count; ++p) {
      const Part& part = parts_[p];
      const TriangleStretch::Look seen =
          (*triangles_)[view_.layers[part.layer].source].look((*rays_)[part.place], time);
      double& left = light[part.place];
      const double share = left / pixel_places;
      for (int c = 0; c < 4; ++c) surface.rgba[c] += share * seen.rgba[c];
      surface.depth += share * seen.rgba[3] * seen.depth;
      depths += seen.depth;
      left *= 1.0 - seen.rgba[3];
    }
    if (surface.rgba[3] > 0.0 && before > double{opaque_transmittance}) {
      surface.depth /= surface.rgba[3];
      for (double& v : surface.rgba) v /= before;
    } else {  // clear, or not seen: anywhere
      surface.depth = depths / static_cast<double>(surface.count);
      std::fill(surface.rgba, surface.rgba + 4, 0.0);
    }
  }
}

}  // namespace swept
