// The parts of a scene file, as functions from JSON. Private to splat/io; all throw swept::Error.
#pragma once

#include <string>

#include "splat/io/json_node.h"
#include "splat/io/scene_file.h"

namespace swept::io {

/// What of the file's root the table of splat/fields.h names.
void parse_fields(const JsonNode& root, Scene& scene);

/// The names that parse_fields() knows at the root.
[[nodiscard]] std::vector<std::string_view> root_field_names();

/// `film` gives the aspect that converts horizontal and diagonal fields of view.
[[nodiscard]] CameraTrack parse_camera(const JsonNode& node, const Film& film);

/// Throws what cannot be had of `camera`; what it leaves is still to be validated.
void override_camera(const CameraOverrides& wanted, const std::string& file, CameraTrack& camera);

/// What one element of "objects" says.
struct ParsedObject {
  Object object;  ///< without its cloud
  ObjectSource source;
};

/// `folder` is where relative paths begin; `default_frame` is when the points of single files are where the
/// file says, unless the source names a frame of its own.
[[nodiscard]] ParsedObject parse_object(const JsonNode& node, const std::string& folder,
                                        double default_frame);

/// The frame of key `i`; throws unless frames increase. A lone key may leave its frame out.
[[nodiscard]] double parse_key_frame(const JsonNode& key, std::size_t i, std::size_t count, double previous);

}  // namespace swept::io
