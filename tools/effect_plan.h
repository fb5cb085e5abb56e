// What a scene calls for, object by object: what is not called for is neither run nor paid for.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "splat/scene.h"

namespace swept {

struct ObjectPlan {
  std::string name;
  std::string motion;                    ///< "still", "straight" or "curved"
  std::string why;                       ///< what moves, or that nothing does
  int segments = 1;                      ///< linear ones, of the exact method
  bool layered = false;                  ///< light gets through somewhere
  bool splats = false;                   ///< trained ones, sampled in time, and without sides
  bool triangles = false;                ///< a mesh, sampled in time, whose edges are sampled too
  bool one_sided = false;                ///< the front alone is seen
  std::size_t points = 0, oriented = 0;  ///< and those of them whose front and back are two surfaces
  int lens_points = 1;                   ///< that all of it is seen through; 1: no lens
  /// Otherwise the sampled engine takes as many as the error asked for does, and that number with --samples.
  bool lens_given = false;

  /// "straight (its transform), opaque, two sides, no lens".
  [[nodiscard]] std::string text() const;
  [[nodiscard]] nlohmann::ordered_json json() const;
};

[[nodiscard]] std::vector<ObjectPlan> effect_plan(const Scene& scene);

}  // namespace swept
