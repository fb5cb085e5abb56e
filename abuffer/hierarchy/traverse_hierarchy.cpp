#include "abuffer/hierarchy/traverse_hierarchy.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "abuffer/hierarchy/moving_boxes.h"
#include "abuffer/parallel.h"

namespace swept {

bool hierarchy_available() { return true; }

namespace hierarchy {
namespace {

using stochastic::Block;
using stochastic::FilmView;
using stochastic::MeshPaths;
using stochastic::MovingDisc;
using stochastic::MovingTriangle;
using stochastic::Primitives;
using stochastic::Span;

/// More stretches of time than that are not told apart, and discs' boxes reach over the whole exposure.
constexpr std::size_t most_stretches = 64;

MovingBox box_of(const MovingKernel& kernel, const Span& time) {
  const Eigen::Array3d half =
      (kernel.axis_u.cast<double>().array().square() + kernel.axis_v.cast<double>().array().square()).sqrt();
  MovingBox box;
  for (int end = 0; end < 2; ++end) {
    const double t = (end == 0 ? time.begin : time.end) - double{kernel.t_mid()};
    const Eigen::Array3d center = (kernel.center + t * kernel.velocity).array();
    box.low[end] = center - half;
    box.high[end] = center + half;
  }
  return box;
}

/// Places outside of the tile's sides, as in MovingTriangle::tile(), and nearer than the near plane.
Frustum frustum_of(const FilmView& view, int x, int y, int tile_px) {
  constexpr double margin = 2e-3;  // px
  const double per_focal = 1.0 / view.projection.focal_px;
  const double low[2] = {(x - margin - view.projection.center_x) * per_focal,
                         (y - margin - view.projection.center_y) * per_focal},
               high[2] = {(x + tile_px + margin - view.projection.center_x) * per_focal,
                          (y + tile_px + margin - view.projection.center_y) * per_focal};
  Frustum frustum;
  for (int axis = 0; axis < 2; ++axis)
    for (int right = 0; right < 2; ++right) {
      Frustum::Side& side = frustum.side[2 * axis + right];
      const double sign = right == 1 ? 1.0 : -1.0, tangent = right == 1 ? high[axis] : low[axis];
      const auto add = [&](double gamma, double further) {
        Eigen::Vector3d normal(0.0, 0.0, -sign * gamma);
        normal[axis] = sign;
        side.plane[side.count++] = {normal, further};
      };
      const double reach = axis == 0 ? view.lens.x : view.lens.y;
      if (!(reach > 0.0)) {
        add(tangent, 0.0);
        continue;
      }
      for (const double inverse_focus : {view.lens.least_inverse_focus, view.lens.most_inverse_focus}) {
        add(tangent - sign * reach * inverse_focus, reach);
        add(tangent + sign * reach * inverse_focus, -reach);
      }
    }
  frustum.side[4].plane[frustum.side[4].count++] = {{0.0, 0.0, -1.0}, -view.near * (1.0 - 1e-9)};
  return frustum;
}

}  // namespace

/// A hierarchy for each stretch of time in which things move evenly enough.
class SceneTrees {
 public:
  explicit SceneTrees(const Primitives& primitives) : primitives_(primitives) {
    add_discs();
    for (std::size_t m = 0; m < primitives.meshes(); ++m)
      for (int p = 0; p < primitives.mesh(m).pieces(); ++p) add_piece(m, p);
  }

  void run(int tile_px, Block& block) const {
    const Window& window = block.samples.window;
    const auto floored = [&](int v) { return v - ((v % tile_px) + tile_px) % tile_px; };
    for (int y = floored(window.y); y < window.y + window.height; y += tile_px)
      for (int x = floored(window.x); x < window.x + window.width; x += tile_px) {
        const Frustum frustum = frustum_of(primitives_.view(), x, y, tile_px);
        const stochastic::PixelRange pixels =
            stochastic::meet({x, y, x + tile_px, y + tile_px}, stochastic::range_of(window));
        for (const Tree& tree : trees_) {
          const std::uint64_t before = block.counts.bounds;
          const MovingBoxes::Seen seen = tree.boxes.seen(frustum, block.counts.bounds);
          block.worked(block.counts.bounds - before);
          if (!seen.span.empty()) cast(tree, seen, pixels, block);
        }
      }
  }

 private:
  struct Tree {
    MovingBoxes boxes;
    Span time;                         ///< the stretch
    std::vector<std::uint32_t> discs;  ///< of items; empty: of a mesh, whose items are triangles
    std::size_t mesh = 0;
    int piece = 0;
  };

  void add_discs() {
    const std::vector<MovingKernel>& kernels = primitives_.kernels().kernels;
    std::map<std::pair<float, float>, std::vector<std::uint32_t>> stretches;
    for (std::size_t k = 0; k < kernels.size() && stretches.size() <= most_stretches; ++k)
      stretches[{kernels[k].t_begin, kernels[k].t_end}].push_back(static_cast<std::uint32_t>(k));
    if (stretches.size() > most_stretches) {
      stretches.clear();
      std::vector<std::uint32_t>& all = stretches[{0.0f, 1.0f}];
      for (std::size_t k = 0; k < kernels.size(); ++k) all.push_back(static_cast<std::uint32_t>(k));
    }
    for (auto& [ends, discs] : stretches) {
      Tree& tree = trees_.emplace_back();
      tree.time = {double{ends.first}, double{ends.second}};
      tree.discs = std::move(discs);
      std::vector<MovingBox> boxes(tree.discs.size());
      parallel_for_each_index(boxes.size(),
                              [&](std::size_t i) { boxes[i] = box_of(kernels[tree.discs[i]], tree.time); });
      tree.boxes = MovingBoxes(boxes);
    }
  }

  void add_piece(std::size_t mesh, int piece) {
    const MeshPaths& paths = primitives_.mesh(mesh);
    Tree& tree = trees_.emplace_back();
    tree.time = {paths.cut(piece), paths.cut(piece + 1)};
    tree.mesh = mesh;
    tree.piece = piece;
    const std::vector<Triangle>& triangles = paths.object().triangles;
    std::vector<MovingBox> boxes(triangles.size(), MovingBox::none());
    parallel_for_each_index(boxes.size(), [&](std::size_t i) {
      for (const std::uint32_t corner : triangles[i]) {
        const Eigen::Vector3d* const p = paths.controls(corner, piece);
        boxes[i].include({p[0], p[1], p[2]});
      }
    });
    tree.boxes = MovingBoxes(boxes);
  }

  void cast(const Tree& tree, const MovingBoxes::Seen& seen, const stochastic::PixelRange& pixels,
            Block& block) const {
    const FilmView& view = primitives_.view();
    const bool discs = !tree.discs.empty();
    const double width = tree.time.end - tree.time.begin, per_focal = 1.0 / view.projection.focal_px;
    const double begin = tree.time.begin + width * seen.span.begin - 1e-7,
                 end = tree.time.begin + width * seen.span.end + 1e-7;
    const float* const times =
        discs ? MovingDisc::times(block.samples) : MovingTriangle::times(block.samples);
    const auto count = static_cast<std::size_t>(block.samples.per_pixel);
    for (int y = pixels.y0; y < pixels.y1; ++y)
      for (int x = pixels.x0; x < pixels.x1; ++x) {
        const std::size_t first = block.first_of(x, y);
        const auto earlier = [](float t, double limit) { return double{t} < limit; };
        const float* const from = std::lower_bound(times + first, times + first + count, begin, earlier);
        for (auto k = static_cast<std::size_t>(from - times); k < first + count && double{times[k]} <= end;
             ++k) {
          if (!discs && primitives_.mesh(tree.mesh).piece_of(double{times[k]}) != tree.piece) continue;
          stochastic::SampleRay ray = stochastic::ray_of(block.samples, k, x, y, view.projection, per_focal);
          // Discs are met through the pixel's centre.
          if (discs) {
            ray.x += (0.5 - double{block.samples.x[k]}) * per_focal;
            ray.y += (0.5 - double{block.samples.y[k]}) * per_focal;
          }
          const double t =
              width > 0.0 ? std::clamp((double{times[k]} - tree.time.begin) / width, 0.0, 1.0) : 0.0;
          const std::uint64_t before = block.counts.bounds;
          tree.boxes.walk(box_ray(ray.x, ray.y, ray.from_x, ray.from_y, view.near), t, seen.branch,
                          block.counts.bounds, [&](std::uint32_t item) {
                            const std::size_t i =
                                discs ? tree.discs[item] : primitives_.begin_of(tree.mesh) + item;
                            primitives_.with(i, [&](auto& primitive) {
                              ++block.counts.tested;
                              if (primitive.test(block.samples, k, x, y, block.hits)) ++block.counts.inside;
                            });
                          });
          block.worked(1 + block.counts.bounds - before);
        }
      }
  }

  const Primitives& primitives_;
  std::vector<Tree> trees_;
};

HierarchyTraversal::HierarchyTraversal(const Primitives& primitives)
    : trees_(std::make_unique<SceneTrees>(primitives)) {}
HierarchyTraversal::~HierarchyTraversal() = default;
void HierarchyTraversal::run(int tile_px, Block& block) const { trees_->run(tile_px, block); }

}  // namespace hierarchy
}  // namespace swept
