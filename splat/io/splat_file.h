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

/// Which way y and z of a .spz file point. By the format right, up and back, where training has right, down
/// and forward; but what converts PLY files to it leaves their axes as they are.
enum class SpzAxes {
  automatic,      ///< as a record in the file says; else trained
  trained,        ///< as they stand there
  right_up_back,  ///< y and z change sign
};

struct SplatReadOptions {
  bool skip_invalid = false;  ///< drop splats with NaN or infinite numbers; else they are an error
  SpzAxes spz_axes = SpzAxes::automatic;
  /// Read splats that move by themselves, too, into LoadedSplats::motion; else they are an error.
  bool motion = false;
};

struct LoadedSplats {
  SplatCloud splats;  ///< in the axes of training, y down and z forward; velocities as stored, at frame 0
  std::vector<std::string> notes;     ///< what a person should know about how this was read
  ReadReport report;                  ///< what was read, and what was not
  std::optional<SplatMotion> motion;  ///< of SpacetimeGaussians' PLY files, where asked for
};

/// Whether the name's extension is one of those that only splats have; .ply is not among them. So is the
/// meta.json of a .sog that was unpacked, into which it looks.
[[nodiscard]] bool is_splat_file_name(const std::string& path);

/// Whether read_splats() is the reader for this file: its name says so, or it is a PLY file whose header
/// declares trained splats. False where it cannot be read: the reader of points then says why.
[[nodiscard]] bool holds_splats(const std::string& path);

/// Reads one file whole. Errors: unreadable or malformed files, no splats, variants that are not known,
/// non-finite numbers, quaternions of length zero; each names the file, the field and the splat. Infinite
/// opacities as logits are 0 and 1.
[[nodiscard]] Result<LoadedSplats> read_splats(const std::string& path, const SplatReadOptions& options = {});

}  // namespace swept
