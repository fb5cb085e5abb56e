// What makes the keys of a cloud of one file and of several. For splat/io's own sources.
#pragma once

#include <cstddef>
#include <vector>

#include "splat/io/cloud_source.h"
#include "splat/io/surfel_estimate.h"

namespace swept::io {

/// The files that are read, files[begin] to files[end − 1].
struct KeySpan {
  std::size_t begin = 0, end = 0;
  std::size_t nearest = 0;  ///< to the middle of what is asked for; of two the earlier
};

/// Discs by the best the set has to offer: its own axes, else its triangles, else its nearest points.
[[nodiscard]] Result<EstimatedSurfels> discs_of(PointSet& set, const CloudSource& source);

/// Adds a key after those there are, its discs turned to agree with theirs.
void push_key(EstimatedSurfels discs, double frame, SurfelCloud& cloud);

/// A file's points, with their rates if it has any that are good.
[[nodiscard]] Result<PointSet> read_with_rates(const CloudSource& source, const KeyFile& file);

/// Frames times this times a stored velocity is a distance.
[[nodiscard]] double velocity_scale(const CloudSource& source);

/// Gives points of a cloud of one key the times of `set`, as `source`.stamps says. Errors (file left empty):
/// there are none, they are out of range.
[[nodiscard]] Status take_stamps(const PointSet& set, const CloudSource& source, LoadedCloud& loaded);

/// Makes `loaded`, the points of the nearest file of those in `span` matched by id, a cloud in which points
/// come and go: those that only some files have exist from halfway after the last file that lacks them until
/// halfway to the next that does, and move there by their own velocities. As it was where none comes or goes
/// while frames [first, last] are exposed. A point that comes again is another one.
[[nodiscard]] Status take_lives(const CloudSource& source, const KeySpan& span, double first, double last,
                                LoadedCloud& loaded);

}  // namespace swept::io
