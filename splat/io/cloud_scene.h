// A scene for points that come without a scene file. What they do not say is assumed and reported.
#pragma once

#include <string>
#include <vector>

#include "splat/export.h"
#include "splat/io/scene_file.h"
#include "splat/result.h"

namespace SWEPT_API swept {

struct CloudScene {
  std::string text;                  ///< the text of a scene file
  std::vector<std::string> assumed;  ///< "assumed: …", one line for each thing that the points do not say
};

/// The text of a scene file that shows the points of `path`, a point file or a pattern such as
/// "anim.%04d.ply". The camera frames the points and sees them from the front and above; of a sequence, five
/// files spread over it are read for that. Points without colours are coloured by their normals. The film is
/// that of `overrides`, or 1920 × 1080. In the text the path is relative to `folder`, the scene file's
/// folder, if the points are in or below it, else absolute. Errors: as read_points() and list_sequence(),
/// points that cannot be framed, names that are not UTF-8.
[[nodiscard]] Result<CloudScene> scene_of_points(const std::string& path, const std::string& folder,
                                                 const SceneOverrides& overrides = {});

/// read_scene_file() for a scene file; for a point file or pattern the scene of scene_of_points(), whose
/// notes begin with what was assumed. Errors: as these two.
[[nodiscard]] Result<SceneFile> read_scene_or_points(const std::string& path,
                                                     const SceneOverrides& overrides = {});

}  // namespace swept
