// Points as a file stores them, before it is decided how they move or how large they are.
//
// Formats, by extension: .ply (ASCII, both binary byte orders), .pcd, columns of text (.xyz .txt .asc .csv
// .pts .xyzn .xyzrgb), .obj, .off.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/io/read_report.h"
#include "splat/result.h"
#include "splat/texture.h"

namespace SWEPT_API swept {

/// How stored colours relate to light: linear, or by the sRGB curve.
enum class ColorSpace { linear, srgb };

/// Which properties of a file mean what, and what to do with bad rows.
struct ReadOptions {
  /// Attribute → comma-separated property names of the file, in place of the usual names
  /// (splat/io/attribute_names.cpp has the table of these). The attributes:
  ///   position, normal, velocity, acceleration, angular_velocity
  ///                                three properties, or one that holds three numbers
  ///   color                        three or, with alpha, four
  ///   radius, width (a diameter), opacity, intensity (a grey where there is no colour), id,
  ///   time                         when a point was seen; read only if `stamps` or its name here asks for it
  /// An empty string leaves the attribute unread. Case is ignored if no name fits otherwise. Columns of a
  /// text file also have the names 1, 2, 3, …
  std::map<std::string, std::string> attributes;
  double delta = 3.0;  ///< δ of the kernel that Gaussian files are fitted to, > 0
  /// The number that a full channel is stored as, > 0. By default it is that of the type: 255, 65535, or 1
  /// for reals. If the numbers show another one, that is taken, and the report says so.
  std::optional<double> color_range;
  /// By default linear for reals up to 1, else sRGB; intensities are sRGB.
  std::optional<ColorSpace> color_space;
  bool stamps = false;  ///< read `time` by its usual names
  bool texture =
      false;  ///< read texture coordinates: OBJ's vt, PLY's s and t of vertices or texcoord of faces
  bool materials = false;       ///< read OBJ's usemtl and mtllib, by name, and vt where corners have them
  bool corner_normals = false;  ///< read OBJ's vn by the corners of faces; false: only normals of points
  bool split_normals = false;   ///< also keep by corner what corner_normals reads
  bool skip_invalid = false;    ///< drop points with NaN or infinite numbers; else they are an error
};

/// Normals that a file gives the corners of a triangle: unit length, or zero where it gives none.
using CornerNormals = std::array<Eigen::Vector3f, 3>;

/// The materials of the triangles of an OBJ file, by name.
struct MaterialNames {
  std::vector<std::string> files;          ///< the names after mtllib
  std::vector<std::string> names;          ///< the names after usemtl; the first is "", for faces before any
  std::vector<std::uint32_t> of_triangle;  ///< indices of names
  std::vector<std::uint8_t> on_texture;    ///< by triangle: whether all its corners have a place on a texture
};

/// The points of one file, object space. Optional arrays are empty or have one entry per point.
struct PointSet {
  std::vector<Eigen::Vector3d> position;
  std::vector<Eigen::Vector3f> normal;  ///< unit length, or zero where the file gives none for a point
  std::vector<float> radius;            ///< at the kernel's cut-off, object units, ≥ 0
  std::vector<Eigen::Vector3f> axis_u;  ///< of Gaussian files: radii at the cut-off; comes with axis_v
  std::vector<Eigen::Vector3f> axis_v;
  std::vector<Eigen::Vector3f> color;     ///< linear Rec.709; intensities are greys
  std::vector<float> opacity;             ///< [0, 1]
  std::vector<Eigen::Vector3f> velocity;  ///< as stored: the file does not say per second or per frame
  std::vector<Eigen::Vector3f> acceleration, angular_velocity;  ///< likewise; the latter in radians
  std::vector<double> time;                                     ///< when each point was seen, as stored
  std::vector<std::int64_t> id;  ///< names of points, the same in every file of a sequence
  std::vector<std::array<std::uint32_t, 3>> triangle;  ///< of meshes, counter-clockwise from outside
  std::vector<TextureCorners> texture_corners;         ///< if ReadOptions asked for them: one a triangle
  std::vector<CornerNormals> corner_normals;           ///< likewise, of files that have any
  MaterialNames materials;                             ///< if ReadOptions asked for them, and there are any
  std::vector<std::string> notes;                      ///< what a person should know about how this was read
  ReadReport report;                                   ///< what was read, and what was not

  [[nodiscard]] std::size_t size() const { return position.size(); }

  /// There are points, counts agree, every number is finite and in its range, and corners of triangles are
  /// points. Normals may have any length. The error's field names the array and the first offending index;
  /// its file is left for the caller to fill in.
  [[nodiscard]] Status validate() const;
};

/// Whether the name's extension is one of those that read_points() knows.
[[nodiscard]] bool is_point_file_name(const std::string& path);

/// Reads one file whole. Gaussian splats are recognised by scale_0, scale_1[, scale_2] and rot_0…3: log
/// standard deviations σ become axes of length σ√(2δ), so that the kernel exp(−δ u²) is the Gaussian; of
/// three axes the shortest is dropped. Errors: unreadable or malformed files, no points, no x y z, unknown
/// properties in `attributes`, non-finite numbers; each names the file, the property and the point.
[[nodiscard]] Result<PointSet> read_points(const std::string& path, const ReadOptions& options = {});

}  // namespace swept
