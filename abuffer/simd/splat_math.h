// The hot arithmetic of Gaussian splats, over plain pointers: sixteen splats placed at an instant, and what
// they show in one tile of the film. Source: model section 14.
//
// Every implementation gives the same bits, as those of sampled_math.h do: lanes never meet, nothing is
// contracted, and what is computed for a pixel depends on splats and pixel alone, never on the crop.
#pragma once

#include <cstddef>
#include <cstdint>

#include "abuffer/simd/sampled_math.h"

namespace swept {

/// Side of a tile: squares of the film's own grid. A tile is 8 × 8 blocks of 4 × 4 pixels, block by block.
inline constexpr int tile_px = 32, tile_blocks = 64, tile_floats = tile_px * tile_px;
inline constexpr int tiles_a_cell = (cell_px / tile_px) * (cell_px / tile_px);

/// A packet's splats, field by field, sixteen floats each.
struct SplatFields {
  const float* offset;     ///< 3, object space from the packet's origin
  const float* axes;       ///< 9: the columns of rotation · scale
  const float* velocity;   ///< 3, or null: they stand still
  const float* opacity;    ///< 1
  const float* harmonics;  ///< 3 a coefficient, colours inner
  int coefficients;
  std::uint32_t lanes;  ///< those that hold a splat
};

/// What all packets of an object share at an instant.
struct SplatView {
  float linear[9];                     ///< from object to camera space, row by row
  float turn[9];                       ///< from camera space to the directions that colours depend on
  float frames;                        ///< since the positions hold
  float focal_x, focal_y;              ///< px
  float low_x, high_x, low_y, high_y;  ///< x/z and y/z in the Jacobian stay between these
  float dilation_px2, near;
  float least_alpha;
  bool antialiased, flat, orthographic;
  int film_width, film_height;
};

/// Where a packet's origin is at an instant.
struct SplatOrigin {
  float x, y, z;  ///< camera space
  /// Places on the film are counted from the pixel of this direction; 0 of an orthographic camera, which
  /// counts them from the pixel of a place across.
  float tangent_x, tangent_y;
  float rest_x, rest_y;          ///< x − tangent_x · z, and the same in y
  int pixel_x, pixel_y;          ///< that pixel
  float fraction_x, fraction_y;  ///< and where in it, [0, 1)
};

/// A splat at an instant. With (dx, dy) a pixel's centre seen from the splat's own, in pixels,
///   α = opacity · 2^−(u² + v²),   u = ux·dx + uy·dy,   v = vy·dy,
/// and of a disc u and v are divided by W = 1 − gx·dx − gy·dy, and the low-pass counts where it is larger.
struct PlacedSplat {
  float pixel_x, pixel_y;  ///< whole numbers: dx = (x − pixel_x) + center_x
  float center_x, center_y;
  float ux, uy, vy;
  float opacity;
  float red, green, blue;
  float depth;
  float gx, gy;  ///< of no disc: u² + v² where α falls to the least, or a little more, and 0
  std::uint16_t x_first, x_last, y_first, y_last;  ///< pixels of the film that contain it

  [[nodiscard]] float limit() const { return gx; }
};
static_assert(sizeof(PlacedSplat) == 64);

struct SplatRule {
  float least_alpha, most_alpha, least_light;
  float near;
  bool linear;          ///< blended in light; else in values of sRGB
  float background[3];  ///< linear
  float encoded[3];     ///< the same in the values in which splats are blended
};

/// One instant of a block of 4 × 4 pixels, row by row.
struct alignas(64) SplatBlock {
  float light[16];  ///< transmittance; negative where no more is drawn
  float red[16], green[16], blue[16];
  float depth[16];  ///< weighted by what each adds to alpha
};

/// One instant of one tile. What a splat changes lies side by side: arrays of their own would be apart by
/// multiples of 4096 bytes, which processors take for the same place at first.
struct SplatTile {
  SplatBlock blocks[tile_blocks];
};

/// Depths between which splats are drawn, pixel by pixel of a tile: from ≤ z < to.
struct SplatRange {
  alignas(64) float from[tile_floats], to[tile_floats];
};

/// What a surface shows in a tile's pixels: premultiplied, linear.
struct SurfaceLayer {
  alignas(64) float red[tile_floats], green[tile_floats], blue[tile_floats], alpha[tile_floats];
  alignas(64) float depth[tile_floats];
};

/// Sums over the instants of a tile, block by block, in each row by row.
struct SplatSums {
  alignas(64) float red[tile_floats], green[tile_floats], blue[tile_floats];  ///< over the background
  alignas(64) float alpha[tile_floats], depth[tile_floats];                   ///< without it
  alignas(64) float alternating_red[tile_floats], alternating_green[tile_floats],
      alternating_blue[tile_floats];
  alignas(64) float even[tile_floats], odd[tile_floats];
};

/// Splats of a tile, nearest first: each an index into one of two rows of splats, with flags.
struct SplatList {
  const PlacedSplat* rows[2];
  const std::uint32_t* index;
  std::size_t count;
};
inline constexpr std::uint32_t second_row = 1u << 31, disc_flag = 1u << 30, splat_index = disc_flag - 1;

/// The arithmetic for one instruction set.
struct SplatMath {
  const char* name;

  /// Returns which lanes are seen; their splats are written, in their order, to as many of `placed`.
  std::uint32_t (*place)(const SplatFields& splats, const SplatView& view, const SplatOrigin& origin,
                         PlacedSplat* placed);

  /// Blends `list` into the pixels of the tile whose first is (x, y). Returns how many places of a splat and
  /// a block of pixels were looked at.
  std::size_t (*draw)(const SplatList& list, int x, int y, const SplatRule& rule, SplatTile& tile);

  /// The same of splats between depths that differ from pixel to pixel.
  std::size_t (*draw_between)(const SplatList& list, int x, int y, const SplatRule& rule,
                              const SplatRange& range, SplatTile& tile);

  /// What is seen of `count` surfaces and the runs of splats before, between and behind them, over the
  /// background: linear colours, which no background has to be added to.
  void (*fold)(const SplatTile* runs, const SurfaceLayer* surfaces, std::size_t count, const SplatRule& rule,
               SplatTile& seen);

  void (*clear)(SplatTile& tile);
  /// Adds an instant to the sums, and to those that the error is estimated from.
  void (*add_instant)(const SplatTile& tile, const SplatRule& rule, const InstantWeights& weights,
                      SplatSums& sums);
};

/// Those this processor can run, in the order of sampled_maths().
struct SplatMaths {
  const SplatMath* first;
  std::size_t count;
};
[[nodiscard]] SplatMaths splat_maths();

}  // namespace swept
