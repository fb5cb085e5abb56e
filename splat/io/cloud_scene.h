// The scene of points that come without a scene file: what they do not say is assumed, and told.
#pragma once

#include <string>
#include <vector>

#include "splat/export.h"
#include "splat/io/scene_file.h"
#include "splat/result.h"

namespace SWEPT_API swept {

struct CloudScene {
  std::string text;                  ///< of a scene file
  std::vector<std::string> assumed;  ///< "assumed: …", a line for each thing the points do not say
};

/// A scene file that shows the points of `path`, a point file or a pattern as "anim.%04d.ply": framed from
/// where they are and seen from the front and above, coloured by their normals if they have no colours. Of a
/// sequence, five files spread over it are looked at. The film is that of `overrides`, or 1920 × 1080. In the
/// text the path is relative to `folder`, the scene file's, if the points are in or below it, else absolute.
/// Errors: as read_points() and list_sequence(), points that cannot be framed, names that are not UTF-8.
[[nodiscard]] Result<CloudScene> scene_of_points(const std::string& path, const std::string& folder,
                                                 const SceneOverrides& overrides = {});

/// read_scene_file(), or of a point file or pattern the scene that shows it, whose notes begin with what was
/// assumed.
[[nodiscard]] Result<SceneFile> read_scene_or_points(const std::string& path,
                                                     const SceneOverrides& overrides = {});

}  // namespace swept
