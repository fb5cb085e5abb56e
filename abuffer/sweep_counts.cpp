#include "abuffer/sweep_counts.h"

#include <algorithm>
#include <string>

namespace swept {
namespace {

void describe_discs(const DiscFilm& film, Statistics& s) {
  const KernelCounts& set = film.counts;
  s.count("surfels", static_cast<double>(set.surfels));
  s.count("kernels", static_cast<double>(film.kernels));
  s.count("segments", set.most_segments);
  s.count("kernels_still", static_cast<double>(set.still_kernels));
  s.count("kernels_edge_on", static_cast<double>(set.edge_on_kernels));
  s.count("kernels_at_near_plane", static_cast<double>(set.near_kernels));
  s.count("culled_degenerate", static_cast<double>(set.culled_degenerate));
  s.count("culled_near", static_cast<double>(set.culled_near));
  s.count("culled_outside", static_cast<double>(film.bins.outside()));
  s.count("culled_facing_away", static_cast<double>(film.bins.facing_away()));
}

void describe_meshes(const MeshFilm& film, bool with_discs, Statistics& s) {
  std::size_t triangles = 0, stretches = 0;
  int degree = 0;
  for (const MovingMesh& mesh : film.meshes) {
    triangles += mesh.object().triangles.size();
    stretches = std::max(stretches, mesh.stretches());
    degree = std::max(degree, mesh.degree());
  }
  s.count("triangles", static_cast<double>(triangles));
  s.count(with_discs ? "path_stretches" : "segments", static_cast<double>(stretches));
  s.count("path_degree", degree);
  s.count("triangles_facing_away", static_cast<double>(film.bins->facing_away()));
  if (film.back_faces == BackFaces::both_ends) {
    s.count("triangles_away_at_both_ends", static_cast<double>(film.bins->away_at_both_ends()));
    s.effect("triangles of one-sided meshes left out where they face away at both ends of the exposure");
  }
  s.effect("motion blur: triangles swept at 16 places of a pixel, on paths of degree " +
           std::to_string(degree) + " in " + std::to_string(stretches) +
           (stretches == 1 ? " stretch" : " stretches at most"));
}

}  // namespace

void describe(const DiscFilm* discs, const MeshFilm* meshes, const SweepCounts& c, Statistics& s) {
  if (discs != nullptr) describe_discs(*discs, s);
  if (meshes != nullptr) describe_meshes(*meshes, discs != nullptr, s);
  const std::size_t entries = (discs != nullptr ? discs->bins.entry_count() : 0) +
                              (meshes != nullptr ? meshes->bins->entry_count() : 0);
  s.count("tile_entries", static_cast<double>(entries));
  s.count("tiles_split", static_cast<double>(c.split_tiles));
  s.count("fragments", static_cast<double>(c.fragments));
  s.count("fragments_in_fullest_pixel", static_cast<double>(c.most_fragments));
  if (discs != nullptr) s.count("pixels_still", static_cast<double>(c.still_pixels));
  s.count("pixels_swept", static_cast<double>(c.swept_pixels));
  if (meshes != nullptr) s.count("fragments_held", static_cast<double>(c.most_held));
  if (meshes != nullptr) s.count("pixels_of_several_meshes", static_cast<double>(c.pixels_of_several_meshes));
  if (discs != nullptr && meshes != nullptr)
    s.count("pixels_of_discs_and_triangles", static_cast<double>(c.pixels_of_both));
  const auto intervals = static_cast<double>(c.sweep.intervals + c.places.pieces);
  s.count("intervals", intervals);
  if (discs != nullptr) {
    s.count("intervals_per_swept_pixel",
            intervals / static_cast<double>(std::max<std::uint64_t>(1, c.swept_pixels)));
    s.count("intervals_merged", static_cast<double>(c.sweep.merged));
    s.count("intervals_retried", static_cast<double>(c.sweep.retried));
  }
  s.count("intervals_cut_by_crossings", static_cast<double>(c.sweep.crossings + c.places.crossings));
  if (discs == nullptr) return;
  s.count("intervals_subdivided", static_cast<double>(c.sweep.subdivided));
  s.count("intervals_at_shortest", static_cast<double>(c.sweep.shortest));
  s.count("integrals", static_cast<double>(c.sweep.evaluations));
  s.count("fragments_hidden", static_cast<double>(c.sweep.hidden));
  s.count("hidden_revealed", static_cast<double>(c.sweep.revealed));
  s.effect(c.swept_pixels > 0 ? "motion blur: swept where something moves"
                              : "motion blur: skipped, nothing moves during the exposure");
}

}  // namespace swept
