#include "splat/io/sequence_ends.h"

#include <algorithm>
#include <utility>

namespace swept::io {
namespace {

/// The key at `frame`, beyond the one at `end`, which is that of the file whose points `set` has. The last
/// points are `copies`.
SurfelKey moved_on(const SurfelKey& end, double frame, const PointSet& set,
                   const std::vector<std::uint32_t>& copies, const CloudSource& source) {
  SurfelKey key = end;
  key.frame = frame;
  const double elapsed = (frame - end.frame) * velocity_scale(source);
  key.pose.position.own();
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (!set.velocity.empty()) key.pose.position[i] += elapsed * set.velocity[i].cast<double>();
    if (!set.acceleration.empty())
      key.pose.position[i] += 0.5 * elapsed * elapsed * set.acceleration[i].cast<double>();
  }
  const std::size_t others = key.pose.size() - copies.size();
  for (std::size_t k = 0; k < copies.size(); ++k)
    key.pose.position[others + k] = key.pose.position[copies[k]];
  return key;
}

/// Whether the first points of the key are those of `set`; reading rates may have dropped some.
bool same_points(const SurfelKey& key, const PointSet& set) {
  return set.size() <= key.pose.size() &&
         std::equal(set.position.begin(), set.position.end(), std::as_const(key.pose.position).begin());
}

}  // namespace

Status add_ends(const CloudSource& source, const KeySpan& span, double first, double last,
                LoadedCloud& loaded) {
  SurfelCloud& cloud = loaded.cloud;
  if (cloud.keys.size() < 2) return Done{};
  const KeyFile& file = source.files[span.nearest];
  const bool before = span.nearest == 0 && first < file.frame;
  const bool after = span.nearest + 1 == source.files.size() && last > file.frame;
  if (!before && !after) return Done{};
  const Result<PointSet> set = read_with_rates(source, file);
  if (!set) return set.error();
  if (set->velocity.empty() && set->acceleration.empty()) return Done{};
  if (!same_points(before ? cloud.keys.front() : cloud.keys.back(), *set)) return Done{};
  if (before)
    cloud.keys.insert(cloud.keys.begin(), moved_on(cloud.keys.front(), first, *set, loaded.copies, source));
  if (after) cloud.keys.push_back(moved_on(cloud.keys.back(), last, *set, loaded.copies, source));
  loaded.report.assumed.push_back("beyond the files points move along their velocities");
  return Done{};
}

}  // namespace swept::io
