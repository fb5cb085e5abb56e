// Gaussian splats as training programs and their viewers store them.
//
// Formats, by extension: .ply (3D and 2D Gaussian splats as they are trained, and packed by PlayCanvas),
// .splat, .spz, .sog (and the meta.json of one that was unpacked), .glb and .gltf.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "splat/export.h"
#include "splat/io/read_report.h"
#include "splat/result.h"
#include "splat/splat_cloud.h"
#include "splat/splat_motion.h"

namespace SWEPT_API swept {

/// How the axes of a .spz file are read. By the format they are right, up and back, while those of training
/// are right, down and forward; but converters from PLY leave the axes as they are.
enum class SpzAxes {
  automatic,      ///< as a record in the file says; else trained
  trained,        ///< as they are in the file
  right_up_back,  ///< y and z change sign
};

struct SplatReadOptions {
  bool skip_invalid = false;  ///< drop splats with NaN or infinite numbers; else they are an error
  SpzAxes spz_axes = SpzAxes::automatic;
  /// Read the motion of splats that were trained in motion into LoadedSplats::motion; false: such files are
  /// an error.
  bool motion = false;
};

struct LoadedSplats {
  SplatCloud splats;  ///< in the axes of training, y down and z forward; velocities as stored, at frame 0
  std::vector<std::string> notes;     ///< what a person should know about how this was read
  ReadReport report;                  ///< what was read, and what was not
  std::optional<SplatMotion> motion;  ///< of SpacetimeGaussians' PLY files, where asked for
};

/// Whether only files of splats have such a name. That goes by the extension, and .ply is not among these; a
/// meta.json is read to see whether it is that of an unpacked .sog.
[[nodiscard]] bool is_splat_file_name(const std::string& path);

/// Whether read_splats() is the reader for this file: its name says so, or it is a PLY file whose header
/// declares trained splats. False if it cannot be read; the reader of points then returns the error.
[[nodiscard]] bool holds_splats(const std::string& path);

/// Reads one file whole. Errors: unreadable or malformed files, no splats, variants that are not known,
/// non-finite numbers, quaternions of length zero; each names the file, the field and the splat. Infinite
/// opacities as logits are 0 and 1.
[[nodiscard]] Result<LoadedSplats> read_splats(const std::string& path, const SplatReadOptions& options = {});

}  // namespace swept
