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
  double opening = 0.25, closing = 0.25;  ///< of a trapezoid: the shares of τ that its ramps take, ≤ 1 in all
  double delta = 3.0;                     ///< δ of a Gaussian
  std::vector<double> rates = {};         ///< of a table: light at evenly spaced τ, lines between; any unit
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

/// What the image is. Every method that renders a scene honours all of it, or refuses. Ranges are in the
/// table of splat/fields.h, where every member has its entry.
struct ImageModel {
  double delta = 3.0;             ///< δ of exp(−δ(u²+v²))
  double filter_radius_px = 1.0;  ///< pixel filter's radius at the cut-off; 0: none
  Coverage coverage = Coverage::soft;
  double edge_weight = 0.5;      ///< ρ_edge of soft coverage
  double depth_tolerance = 1.0;  ///< ternary depth tolerance in units of the filtered disc's radius
  int segments = 0;              ///< linear motion segments over the shutter; 0: as many as it takes

  [[nodiscard]] Status validate() const;
};

/// What is said of motion for the whole scene.
struct MotionModel {
  /// How points of keyed files move from key to key. It is read when clouds are loaded; what is rendered
  /// follows SurfelCloud::path.
  KeyPath path = KeyPath::linear;
  /// How far chords of a path may be from it, px, where paths are cut into linear segments point by point;
  /// rims and pixel filters may be off by 0.75 times as much. 0: 0.1 px for what curves, turns or comes
  /// nearer, and the other objects are cut all alike (linear_segments()).
  double tolerance_px = 0.0;
};

/// In what values splats are blended.
enum class SplatBlending {
  file,    ///< SplatCloud::colors
  srgb,    ///< of the sRGB curve, as nearly all are trained
  linear,  ///< of light
};

/// How Gaussian splats become a picture (model section 14): constants by which renderers differ. Defaults are
/// those of Kerbl et al. 2023. Ranges are in the table of splat/fields.h.
struct SplatModel {
  double dilation_px2 = 0.3;       ///< added to the variances on the film
  double least_alpha = 1.0 / 255;  ///< less is left out
  double most_alpha = 0.99;        ///< more is cut to this
  double least_light = 1e-4;  ///< a splat that would let less light through is not drawn, nor what is behind
  double near = 0.2;          ///< world units: centres no farther than this are left out
  SplatBlending blending = SplatBlending::file;
  /// Frames from training time 0 to 1 of splats that were trained in motion. It is read when splats are
  /// loaded; what is rendered follows SplatMotion::frames.
  double clip_frames = usual_clip_frames;
};

/// What multiplies colours and opacities of some of a mesh's triangles.
struct Material {
  std::string name;
  Eigen::Vector3f color = Eigen::Vector3f::Ones();  ///< linear Rec.709
  float opacity = 1.0f;                             ///< [0, 1]
  std::shared_ptr<const Texture> texture;           ///< or null: multiplies them, too

  /// Of premultiplied colours, before the texture.
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
  /// Between points of the cloud. Not empty: these are drawn in place of discs, with colours and opacities
  /// that change evenly from corner to corner (model section 15). Normals of points are those of their discs.
  std::vector<Triangle> triangles;
  /// Of these, with their corners' places on it, one a triangle: multiplies colour and opacity. Both or none.
  std::shared_ptr<const Texture> texture;
  std::vector<TextureCorners> texture_corners;
  /// What the triangles are made of, and of which each is. Both or none; not beside `texture`. Where any has
  /// a texture, texture_corners are the places on it.
  std::vector<Material> materials;
  std::vector<std::uint32_t> material_of;
  SplatCloud splats;  ///< empty, or the cloud is
  TransformTrack transform;
  bool two_sided =
      true;  ///< else a disc is seen only from the side a₁ × a₂ points to, a triangle from its front
  int segments = 0;  ///< linear motion segments; 0: as the image model says

  /// What is drawn of the cloud.
  [[nodiscard]] std::size_t discs() const { return triangles.empty() ? cloud.size() : 0; }
  /// What is laid over a triangle; null: nothing.
  [[nodiscard]] const Texture* texture_of(std::size_t triangle) const {
    return material_of.empty() ? texture.get() : materials[material_of[triangle]].texture.get();
  }
  /// What multiplies the premultiplied colours of a triangle's corners.
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

/// An error that names the shutter's row delay, of a renderer that exposes all rows at once.
[[nodiscard]] Status refuse_row_delay(const Scene& scene, std::string_view renderer);

/// An error that names the camera, where it is orthographic, of a renderer whose rays all begin in the eye.
[[nodiscard]] Status refuse_orthographic(const Scene& scene, std::string_view renderer);

/// An error that names the first object with points that come or go while the shutter is open, of a renderer
/// that has them throughout.
[[nodiscard]] Status refuse_lifetimes(const Scene& scene, std::string_view renderer);

/// An error that names the first object of splats, of a renderer that draws none: "…, which `renderer` does
/// not draw".
[[nodiscard]] Status refuse_splats(const Scene& scene, std::string_view renderer);
/// The same of triangles.
[[nodiscard]] Status refuse_triangles(const Scene& scene, std::string_view renderer);

}  // namespace swept
