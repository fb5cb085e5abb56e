// One reader per format; read_points picks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "splat/io/point_file.h"
#include "splat/result.h"
#include "splat/surfel.h"

namespace swept {

[[nodiscard]] Result<PointSet> read_ply(const std::string& path, std::string_view bytes,
                                        const ReadOptions& options);
[[nodiscard]] Result<PointSet> read_pcd(const std::string& path, std::string_view bytes,
                                        const ReadOptions& options);
[[nodiscard]] Result<PointSet> read_xyz(const std::string& path, std::string_view bytes,
                                        const ReadOptions& options);
[[nodiscard]] Result<PointSet> read_obj(const std::string& path, std::string_view bytes,
                                        const ReadOptions& options);
[[nodiscard]] Result<PointSet> read_off(const std::string& path, std::string_view bytes,
                                        const ReadOptions& options);

/// Cuts a polygon into the fan of its first corner. Fewer than three corners: none. Likewise of anything else
/// that is said of its corners.
template <class Corner>
void add_fan(const std::vector<Corner>& polygon, std::vector<std::array<Corner, 3>>& triangles) {
  for (std::size_t i = 2; i < polygon.size(); ++i)
    triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
}

/// Triangles of strips parted by -1, every second one turned round so that all face the same way; those
/// with a repeated corner, which only join pieces, are left out. Indices other than -1 are ≥ 0.
void add_strips(const std::vector<std::int64_t>& strips, std::vector<Triangle>& triangles);

}  // namespace swept
