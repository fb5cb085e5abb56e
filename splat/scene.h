// Everything a renderer needs to know, with nothing left to look up in a file.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "splat/camera.h"
#include "splat/export.h"
#include "splat/exposure.h"
#include "splat/splat_cloud.h"
#include "splat/surfel.h"
#include "splat/texture.h"

namespace SWEPT_API swept {

inline constexpr int max_segments = 4096;

/// How much light the shutter lets in while it is open. τ is 0 where it opens and 1 where it closes.
enum class ShutterShape {
  box,        ///< evenly
  trapezoid,  ///< more and more until it is open, all of it, less and less until it is closed
  gaussian,   ///< exp(−δ(2τ − 1)²) (Heinzle et al. 2010)
  table,      ///< as given
};

/// Shutter times in frames relative to the frame being rendered. open == close is a still image.
struct Shutter {
  double open = -0.25, close = 0.25;
  ShutterShape curve = ShutterShape::box;
  double opening = 0.25, closing = 0.25;  ///< trapezoid: the shares of τ that its ramps take, ≤ 1 in all
  double delta = 3.0;                     ///< gaussian: δ
  std::vector<double> rates = {};         ///< table: light at evenly spaced τ, linear in between; any unit
  double row_delay = 0.0;                 ///< as Exposure::row_delay
};

struct FrameRate {
  int numerator = 24, denominator = 1;
};

/// How a surface's silhouette is covered (model section 1.4).
enum class Coverage {
  soft,  ///< min(1, Σρ / edge_weight): antialiased
  hard,  ///< 1 wherever any kernel covers the pixel centre (Heinzle 2010)
};

/// What defines the image. Every method that renders a scene honours all of this, or refuses the scene. The
/// table of splat/fields.h has the range of every member.
struct ImageModel {
  double delta = 3.0;             ///< δ of exp(−δ(u²+v²))
  double filter_radius_px = 1.0;  ///< pixel filter's radius at the cut-off; 0: none
  Coverage coverage = Coverage::soft;
  double edge_weight = 0.5;      ///< ρ_edge of soft coverage
  double depth_tolerance = 1.0;  ///< ternary depth tolerance in units of the filtered disc's radius
  int segments = 0;              ///< linear motion segments over the shutter; 0: linear_segments()

  [[nodiscard]] Status validate() const;
};

/// Settings of motion for the whole scene.
struct MotionModel {
  /// How points of keyed files move from key to key. It is used when clouds are loaded; renderers use
  /// SurfelCloud::path.
  KeyPath path = KeyPath::linear;
  /// How far chords of a path may be from it, px, if paths are cut into segments point by point. Rims may be
  /// off by 0.75 times as much, pixel filters by 0.6 times. 0: 0.1 px for objects that cuts_by_point() names,
  /// such as those that curve, turn or come nearer; the points of other objects are cut alike
  /// (linear_segments()).
  double tolerance_px = 0.0;
};

/// The values in which splats are blended.
enum class SplatBlending {
  file,    ///< those of SplatCloud::colors
  srgb,    ///< those of the sRGB curve, as nearly all splats are trained
  linear,  ///< linear light
};

/// How Gaussian splats are drawn (model section 14): constants in which renderers differ. Defaults are those
/// of Kerbl et al. 2023. Ranges are in the table of splat/fields.h.
struct SplatModel {
  double dilation_px2 = 0.3;       ///< added to the variances on the film
  double least_alpha = 1.0 / 255;  ///< a splat below this is left out of the pixel
  double most_alpha = 0.99;        ///< alpha is cut to this
  double least_light = 1e-4;  ///< a splat that would leave less light is not drawn, nor what lies behind it
  double near = 0.2;          ///< world units: splats whose centres are no deeper are left out
  SplatBlending blending = SplatBlending::file;
  /// Frames from training time 0 to 1 of splats that were trained in motion. It is used when splats are
  /// loaded; renderers use SplatMotion::frames.
  double clip_frames = usual_clip_frames;
};

/// A material of some of a mesh's triangles: it multiplies their colours and opacities.
struct Material {
  std::string name;
  Eigen::Vector3f color = Eigen::Vector3f::Ones();  ///< linear Rec.709
  float opacity = 1.0f;                             ///< [0, 1]
  std::shared_ptr<const Texture> texture;           ///< or null; multiplies them, too

  /// The factor of premultiplied RGBA, without the texture.
  [[nodiscard]] Eigen::Vector4f tint() const {
    Eigen::Vector4f tint;
    tint << opacity * color, opacity;
    return tint;
  }
};

/// Discs, triangles or splats.
struct Object {
  std::string name;
  SurfelCloud cloud;
  /// Triangles between points of the cloud. If there are any, they are drawn in place of discs, with colours
  /// and opacities that are linear from corner to corner (model section 15). Points have the normals of their
  /// discs.
  std::vector<Triangle> triangles;
  /// A texture that multiplies colour and opacity of all triangles, and the places of their corners on it,
  /// one entry a triangle. Both or none.
  std::shared_ptr<const Texture> texture;
  std::vector<TextureCorners> texture_corners;
  /// The materials, and the index of each triangle's material. Both or none; not together with `texture`. If
  /// any material has a texture, texture_corners are the places on it.
  std::vector<Material> materials;
  std::vector<std::uint32_t> material_of;
  SplatCloud splats;  ///< this or the cloud is empty
  TransformTrack transform;
  bool two_sided =
      true;  ///< else a disc is seen only from the side a₁ × a₂ points to, a triangle from its front
  int segments = 0;  ///< linear motion segments; 0: as the image model says

  /// The number of discs that are drawn.
  [[nodiscard]] std::size_t discs() const { return triangles.empty() ? cloud.size() : 0; }
  /// The texture of a triangle; null: it has none.
  [[nodiscard]] const Texture* texture_of(std::size_t triangle) const {
    return material_of.empty() ? texture.get() : materials[material_of[triangle]].texture.get();
  }
  /// The factor of the premultiplied RGBA of a triangle's corners.
  [[nodiscard]] Eigen::Vector4f tint_of(std::size_t triangle) const {
    return material_of.empty() ? Eigen::Vector4f(Eigen::Vector4f::Ones())
                               : materials[material_of[triangle]].tint();
  }
};

struct Scene {
  double frame =
      0.0;  ///< the frame this scene was made for; all keys are absolute, the shutter is relative to it
  Film film;
  CameraTrack camera;
  Shutter shutter;
  FrameRate fps;
  Eigen::Vector4f background = Eigen::Vector4f::Zero();  ///< linear, premultiplied RGBA
  ImageModel model;
  MotionModel motion;
  SplatModel splats;
  std::vector<Object> objects;

  /// The shutter's times as absolute frames.
  [[nodiscard]] Exposure exposure() const;

  /// Ranges and counts of all the parts; the error's field is a JSON-pointer-like path.
  [[nodiscard]] Status validate() const;
};

// Each of the functions below is for a renderer, named by `renderer`, that cannot draw something of a scene.
// It returns an error that names what that is, or success if the scene has none of it.

/// For a renderer that exposes all rows at once: an error that names the shutter's row delay.
[[nodiscard]] Status refuse_row_delay(const Scene& scene, std::string_view renderer);

/// For a renderer whose rays all begin in the eye: an error that names an orthographic camera.
[[nodiscard]] Status refuse_orthographic(const Scene& scene, std::string_view renderer);

/// For a renderer that shows points throughout: an error that names the first object with points that come or
/// go while the shutter is open.
[[nodiscard]] Status refuse_lifetimes(const Scene& scene, std::string_view renderer);

/// For a renderer that draws no splats: an error that names the first object of splats, "…, which `renderer`
/// does not draw".
[[nodiscard]] Status refuse_splats(const Scene& scene, std::string_view renderer);
/// For a renderer that draws no triangles: likewise, the first object of triangles.
[[nodiscard]] Status refuse_triangles(const Scene& scene, std::string_view renderer);

}  // namespace swept
