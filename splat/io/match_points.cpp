#include "splat/io/match_points.h"

#include <array>
#include <limits>
#include <type_traits>
#include <unordered_map>
#include <vector>

namespace swept {
namespace {

constexpr std::size_t kMissing = std::numeric_limits<std::size_t>::max();

/// Entry i from `other` at from[i], or from the reference where that is missing.
template <class T>
std::vector<T> gather(const std::vector<T>& reference, const std::vector<T>& other,
                      const std::vector<std::size_t>& from) {
  std::vector<T> gathered;
  if (other.empty()) return gathered;
  gathered.reserve(from.size());
  for (std::size_t i = 0; i < from.size(); ++i)
    gathered.push_back(from[i] == kMissing ? reference[i] : other[from[i]]);
  return gathered;
}

}  // namespace

Result<MatchedPoints> match_by_id(const PointSet& reference, const PointSet& other, double velocity_scale) {
  std::unordered_map<std::int64_t, std::size_t> index_of;
  index_of.reserve(other.size());
  for (std::size_t i = 0; i < other.size(); ++i) index_of.emplace(other.id[i], i);

  MatchedPoints matched;
  std::vector<std::size_t> from(reference.size(), kMissing);
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const auto found = index_of.find(reference.id[i]);
    if (found == index_of.end())
      ++matched.missing;
    else
      from[i] = found->second;
  }
  matched.extra = other.size() - (reference.size() - matched.missing);
  const auto kinds = [](const PointSet& set) {
    return std::array{set.normal.empty(), set.radius.empty(), set.axis_u.empty()};
  };
  if (matched.missing > 0 && kinds(reference) != kinds(other)) {
    return Error{"", "attributes", "normals, radii and scales must be in all files of a sequence or in none"};
  }
  matched.set.position = gather(reference.position, other.position, from);
  matched.set.normal = gather(reference.normal, other.normal, from);
  matched.set.radius = gather(reference.radius, other.radius, from);
  matched.set.axis_u = gather(reference.axis_u, other.axis_u, from);
  matched.set.axis_v = gather(reference.axis_v, other.axis_v, from);
  // Where the reference has none there is nothing to stand in for a point that is missing.
  const auto look = [&](const auto& of_reference, const auto& of_other) {
    return matched.missing > 0 && of_reference.empty() ? std::decay_t<decltype(of_other)>{}
                                                       : gather(of_reference, of_other, from);
  };
  matched.set.color = look(reference.color, other.color);
  matched.set.opacity = look(reference.opacity, other.opacity);
  matched.set.triangle = reference.triangle;
  matched.set.texture_corners = reference.texture_corners;
  for (std::size_t i = 0; i < from.size() && !reference.velocity.empty(); ++i) {
    if (from[i] == kMissing) matched.set.position[i] += velocity_scale * reference.velocity[i].cast<double>();
  }
  return matched;
}

}  // namespace swept
