#include "abuffer/splats/film_surfaces.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "abuffer/resolve/sample_plan.h"
#include "splat/motion/instant.h"

namespace swept {

FilmSurfaces::FilmSurfaces(const Scene& scene, const Exposure& exposure, bool only_standing,
                           const SampledMath& math, const MeshMath& mesh_math, const CellGrid& grid)
    : scene_(scene),
      exposure_(exposure),
      grid_(grid),
      discs_(pack_points(scene, exposure, only_standing)),
      bins_(scene, exposure, discs_),
      mesh_motion_(scene, exposure, grid),
      cells_([this, &math, &mesh_math] { return OfCell(*this, math, mesh_math); }) {
  for (const Object& object : scene.objects) {
    const bool still = stands_still(scene, object, exposure), lens = scene.camera.aperture.radius > 0.0;
    if (object.triangles.empty() || (only_standing && !still)) continue;
    Mesh mesh{&object, nullptr};
    // Through a lens nothing stays where it is.
    if (still && !lens) {
      auto instant = std::make_shared<MeshInstant>(scene, object, exposure.open);
      instant->share_out(grid, std::vector<char>(grid.size(), 1));
      mesh.standing = std::move(instant);
    }
    meshes_.push_back(std::move(mesh));
  }
}

float FilmSurfaces::motion_px(std::size_t cell) const {
  if (exposure_.instant()) return 0.0f;
  return std::max(typical_motion(bins_, bins_.packets(cell)), mesh_motion_.px(cell));
}

FilmSurfaces::Instant FilmSurfaces::at(double time, const std::vector<char>& wanted,
                                       const Scene* pinhole) const {
  const Scene& seen = pinhole != nullptr ? *pinhole : scene_;
  Instant instant;
  for (const PointPackets& object : discs_) instant.discs.emplace_back(seen, object, exposure_.at(time));
  for (const Mesh& mesh : meshes_) {
    instant.meshes.push_back(mesh.standing);
    if (mesh.standing) continue;
    auto moving = std::make_shared<MeshInstant>(seen, *mesh.object, exposure_.at(time));
    moving->share_out(grid_, wanted);
    instant.meshes.back() = std::move(moving);
  }
  return instant;
}

std::size_t FilmSurfaces::instant_bytes() const {
  std::size_t bytes = 0;
  for (const Mesh& mesh : meshes_)
    if (!mesh.standing)
      bytes += mesh.object->cloud.size() * sizeof(Eigen::Vector3d) +
               2 * mesh.object->triangles.size() * sizeof(std::uint32_t);
  return bytes;
}

std::size_t FilmSurfaces::discs() const {
  std::size_t count = 0;
  for (const PointPackets& object : discs_) count += object.size;
  return count;
}

std::size_t FilmSurfaces::triangles() const {
  std::size_t count = 0;
  for (const Mesh& mesh : meshes_) count += mesh.object->triangles.size();
  return count;
}

void FilmSurfaces::OfCell::begin(std::size_t cell) {
  index_ = cell;
  cell_ = film_.grid_.cell(cell);
  any_discs_ = !film_.discs_.empty() && !film_.bins_.packets(cell).empty();
  if (any_discs_) discs_.begin(cell_, film_.bins_.packets(cell));
}

const std::vector<SampledCell::Surface>& FilmSurfaces::OfCell::at(const Instant& instant) {
  meshes_.clear();
  for (const auto& mesh : instant.meshes) mesh_.add(*mesh, cell_, index_, meshes_);
  static const std::vector<SampledCell::Surface> no_discs;
  const std::vector<SampledCell::Surface>& discs = any_discs_ ? discs_.surfaces(instant.discs) : no_discs;
  if (meshes_.empty()) return discs;
  merge(discs);
  return merged_;
}

/// In each pixel a mesh's surface comes before the first of the discs' that is deeper; those keep their
/// order.
void FilmSurfaces::OfCell::merge(const std::vector<SampledCell::Surface>& discs) {
  constexpr std::size_t pixels = cell_px * cell_px;
  const auto pixel = [](const SampledCell::Surface& s) {
    return static_cast<std::size_t>(s.y * cell_px + s.x);
  };
  // Both by pixel, one list behind the other.
  by_pixel_.resize(discs.size() + meshes_.size());
  std::size_t first = 0;
  for (const auto* list : {&discs, &std::as_const(meshes_)}) {
    std::vector<std::size_t>& ends = list == &discs ? disc_ends_ : mesh_ends_;
    ends.assign(pixels + 1, 0);
    for (const SampledCell::Surface& s : *list) ++ends[pixel(s) + 1];
    ends[0] = first;
    for (std::size_t p = 0; p < pixels; ++p) ends[p + 1] += ends[p];
    for (const SampledCell::Surface& s : *list) by_pixel_[ends[pixel(s)]++] = s;
    first = by_pixel_.size() - meshes_.size();
  }
  const auto nearer = [](const SampledCell::Surface& a, const SampledCell::Surface& b) {
    return a.depth < b.depth;
  };
  // What follows the depth makes the order of meshes indifferent.
  const auto before = [](const SampledCell::Surface& a, const SampledCell::Surface& b) {
    return std::tie(a.depth, a.rgba[3], a.rgba[0], a.rgba[1], a.rgba[2]) <
           std::tie(b.depth, b.rgba[3], b.rgba[0], b.rgba[1], b.rgba[2]);
  };
  merged_.clear();
  const auto at = [&](std::size_t i) { return by_pixel_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::size_t disc = 0, mesh = discs.size();
  for (std::size_t p = 0; p < pixels; ++p) {
    std::sort(at(mesh), at(mesh_ends_[p]), before);
    std::merge(at(disc), at(disc_ends_[p]), at(mesh), at(mesh_ends_[p]), std::back_inserter(merged_), nearer);
    disc = disc_ends_[p];
    mesh = mesh_ends_[p];
  }
}

}  // namespace swept
