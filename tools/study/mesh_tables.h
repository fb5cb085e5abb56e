// Tables about moving triangles: how well intervals name what is seen, what merging them costs, Table 1 of
// Rönnow et al. 2021, and the hierarchy of moving boxes beside bins.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "splat/scene.h"
#include "tools/study/traversal.h"

namespace swept {

/// Of numbers, texts and nulls, row by row.
struct StudyTable {
  std::string id, title, note;
  std::vector<std::string> columns;
  std::vector<std::vector<nlohmann::ordered_json>> rows;
  std::size_t failed = 0;  ///< rows that are an error
};
[[nodiscard]] nlohmann::ordered_json to_json(const StudyTable& table);
/// As a table of Markdown, under its title.
[[nodiscard]] std::string markdown(const StudyTable& table);

/// How large and how often; quick: small, once.
struct MeshTableOptions {
  int side_px = 256;
  int stills = 1024;
  bool quick = false;
  /// Of hierarchy_table(): how many triangles, and how far they move. Empty: 10⁴ to 10⁶, and 0 to 300 px.
  std::vector<int> triangles = {};
  std::vector<double> motions_px = {};
  /// Of ronnow_table(): sides of the film, px, and which of "opaque", "transparent" and "textured". Empty:
  /// side_px and its double, and all of them.
  std::vector<int> films_px = {};
  std::vector<std::string> looks = {};
};
/// Called after each row.
using RowDone = std::function<void(const StudyTable&)>;

/// Cloth ball and horse where they are, a ball that turns and a fan, each triangle in one colour.
[[nodiscard]] std::vector<TraversalScene> visibility_scenes(int side_px, const std::string& folder);
/// Every triangle with corners of its own, which have the mean of the colours that they had, at all times:
/// looks are dropped for the cloud's own.
void make_flat(Object& object);

/// Visibility accuracy and PSNR of the exact method on meshes, with all intervals and with the K per place
/// that cost the least; CPU time and memory of them.
[[nodiscard]] StudyTable visibility_table(const std::vector<TraversalScene>& scenes,
                                          const MeshTableOptions& options, const RowDone& done);
/// Rönnow et al. 2021, Table 1: time, intervals and memory of the exact method, by the film's size,
/// and the stochastic method of 128 samples; of each scene as it is, half transparent and white, and half
/// transparent with a texture.
[[nodiscard]] StudyTable ronnow_table(const std::vector<TraversalScene>& scenes,
                                      const MeshTableOptions& options, const RowDone& done);
/// CPU time of the stochastic method by the hierarchy of moving boxes and by bins: primitives, motion in px.
[[nodiscard]] StudyTable hierarchy_table(const MeshTableOptions& options, const RowDone& done);

}  // namespace swept
