// What a shape is to the registry in generators.cpp: a name, its parameters and a function.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/generators.h"
#include "splat/result.h"
#include "splat/surfel.h"

namespace swept::datasets {

/// A call of generate() after its parameters were completed and checked against their ranges.
class Request {
 public:
  Request(std::size_t points, std::map<std::string, double> values)
      : points_(points), values_(std::move(values)) {}

  [[nodiscard]] std::size_t points() const { return points_; }
  /// Precondition: the shape declares `name`.
  [[nodiscard]] double number(const std::string& name) const { return values_.at(name); }
  [[nodiscard]] int whole(const std::string& name) const { return static_cast<int>(values_.at(name)); }
  [[nodiscard]] std::uint64_t seed() const { return static_cast<std::uint64_t>(values_.at("seed")); }

 private:
  std::size_t points_;
  std::map<std::string, double> values_;
};

struct Shape {
  std::string name;
  std::vector<GeneratorParameter> parameters;  ///< its own, without the shared ones
  Result<SurfelCloud> (*build)(const Request&);
  bool surface = true;  ///< its points have an outside; else they are particles
};

/// Each defined in the shape_*.cpp of its name.
[[nodiscard]] Shape box_shape();
[[nodiscard]] Shape disc_shape();
[[nodiscard]] Shape fan_shape();
[[nodiscard]] Shape head_shape();
[[nodiscard]] Shape knot_shape();
[[nodiscard]] Shape page_shape();
[[nodiscard]] Shape plane_shape();
[[nodiscard]] Shape ribbon_shape();
[[nodiscard]] Shape sparks_shape();
[[nodiscard]] Shape sphere_shape();

}  // namespace swept::datasets
