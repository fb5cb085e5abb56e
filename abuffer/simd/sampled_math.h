// The hot arithmetic of the sampled engine, over plain pointers: sixteen points placed at an instant, and
// what they add to the pixels of one cell of the film. Source: model sections 1, 2 and 5.
//
// Every implementation gives the same bits: lanes never meet, nothing is contracted, and divisions and roots
// are the processor's own. What is computed for a pixel depends on the point and the pixel alone, never on
// the cell.
#pragma once

#include <cstddef>
#include <cstdint>

namespace swept {

inline constexpr int packet_size = 16;  ///< points of a packet
inline constexpr int cell_px = 64;      ///< side of a cell, which is a square of the film's own grid
/// Blocks of 4 × 4 and 8 × 2 pixels begin anywhere in a cell, so its arrays have a border that is written and
/// never read.
inline constexpr int cell_pitch = cell_px + 8, cell_rows = cell_px + 4;
inline constexpr int cell_floats = cell_pitch * cell_rows;
/// Squares by which a cell remembers how far one can see.
inline constexpr int patch_px = 8, cell_patches = cell_px / patch_px;
/// Strips of 16 × 8 pixels by which it remembers where anything was drawn: a bit each, row by row.
inline constexpr int strip_px = 16, cell_strips = cell_px / strip_px;
inline constexpr std::uint32_t all_strips = ~std::uint32_t{0};
static_assert(cell_strips * cell_patches == 32);

/// Points in object space relative to the packet's origin, field by field: x[16] y[16] z[16]. The second pose
/// may be missing (null): then nothing of that field moves.
struct PacketPoints {
  const float *offset, *offset_after;  ///< 3 fields
  const float *axes, *axes_after;      ///< 6 fields: axis_u, axis_v
  float blend;                         ///< from the first pose to the second, [0, 1]
  std::uint32_t lanes;                 ///< those that hold a point
  std::uint32_t oriented;              ///< of these, those whose front and back are told apart
};

/// Where a packet's origin is at an instant: camera space, and the film.
struct PacketPlace {
  float depth;                   ///< z, > 0 but for an orthographic camera
  float tangent_x, tangent_y;    ///< x/z, y/z; an orthographic camera needs none
  int pixel_x, pixel_y;          ///< the pixel it projects into
  float fraction_x, fraction_y;  ///< and where in it, [0, 1)
};

/// What the packets of one object share at an instant.
struct ObjectPlace {
  float linear[9];  ///< from object to camera space, row by row
  float mirrored;   ///< −1 where that turns outside in, else 1
  bool one_sided;
  bool orthographic;
  float focal_px;
  float near;
  float filter_px;  ///< radius
  float max_tangent_x, max_tangent_y;
  float depth_tolerance;  ///< in units of the filtered disc
  int film_width, film_height;
};

/// Sixteen discs at an instant. With (dx, dy) a pixel's centre seen from the disc's own, in pixels,
///   W = 1 − gx·dx − gy·dy,   u = (ux·dx + uy·dy) / W,   v = vy·dy / W,   z = depth / W,
/// and of an orthographic camera W = 1 and z = depth + gx·dx + gy·dy.
struct PlacedPacket {
  float pixel_x[packet_size], pixel_y[packet_size];  ///< whole numbers: dx = (x − pixel_x) + center_x
  float center_x[packet_size], center_y[packet_size];
  float ux[packet_size], uy[packet_size], vy[packet_size];
  float gx[packet_size], gy[packet_size];
  float depth[packet_size], nearest[packet_size];  ///< of the centre, and the least of the disc
  float peak[packet_size], tolerance[packet_size];
  float x_begin[packet_size], x_end[packet_size];  ///< whole pixels of the film that contain the disc
  float y_begin[packet_size], y_end[packet_size];
  float red[packet_size], green[packet_size], blue[packet_size], alpha[packet_size];  ///< premultiplied
  std::uint32_t seen;         ///< lanes that all the above is said of
  std::uint32_t general;      ///< lanes that have to be placed by the general formulas: not seen
  std::uint32_t front, back;  ///< lanes that show that side; in neither: it is not known
};

/// One instant of one cell. The film's pixel (x, y) is at (y − y_film)·cell_pitch + (x − x_film).
struct CellBuffers {
  alignas(64) float front[cell_floats];   ///< depth of the nearest fragment; +∞: none
  alignas(64) float limit[cell_floats];   ///< depth to which the front surface reaches; +∞: none
  alignas(64) float side[cell_floats];    ///< that the front surface shows, as side_number(); where asked for
  alignas(64) float weight[cell_floats];  ///< Σρ of the front surface, then T, the light it lets through
  alignas(64) float red[cell_floats], green[cell_floats], blue[cell_floats], alpha[cell_floats];
  alignas(64) float depth[cell_floats];   ///< Σρz, then depth weighted by alpha
  alignas(64) float behind[cell_floats];  ///< limit where light gets through the front surface, +∞ elsewhere
  float patch_limit[cell_patches * cell_patches];  ///< largest limit of each patch
  bool patch_leaks[cell_patches *
                   cell_patches];  ///< whether light gets through a front surface somewhere in it
  /// Strips in which anything may have been drawn since clear(); it left the others as they are, but for
  /// `behind`, which means nothing there. All of them before the first clear().
  std::uint32_t touched = all_strips;
};

/// Sums over the instants of a cell.
struct CellSums {
  alignas(64) float red[cell_floats], green[cell_floats], blue[cell_floats], alpha[cell_floats];
  alignas(64) float depth[cell_floats];  ///< weighted by alpha
  alignas(64) float alternating_red[cell_floats], alternating_green[cell_floats],
      alternating_blue[cell_floats];
  alignas(64) float even[cell_floats], odd[cell_floats];  ///< grey, of every other instant, alternating
};

/// What an instant weighs in the sums.
struct InstantWeights {
  float weight = 1.0f;
  float alternating = 0.0f;
  float even = 0.0f, odd = 0.0f;  ///< one of them at most
};

struct SurfaceRule {
  float delta;
  float edge_weight;
  float near;
  bool hard;
  bool sides;         ///< whether front and back are told apart anywhere
  bool orthographic;  ///< as the camera is
};

/// 1 front, −1 back, 0 not known: two are of one surface where the product is not negative, and of equally
/// near ones the greatest leads.
inline float side_number(const PlacedPacket& placed, int lane) {
  return static_cast<float>(placed.front >> lane & 1u) - static_cast<float>(placed.back >> lane & 1u);
}
/// Bits of a disc's index that say what side it shows.
inline constexpr std::uint32_t disc_back = 1u << 30, disc_front = 1u << 29, disc_index = disc_front - 1u;

/// A fragment behind the front surface.
struct FragmentBehind {
  float depth, weight;
  std::uint32_t disc;   ///< index of packet · 16 + lane, as given, and the bit of its side
  std::uint32_t pixel;  ///< index into the cell's arrays
};

/// The arithmetic for one instruction set.
struct SampledMath {
  const char* name;

  /// Everything of `placed` but colours and what general lanes need.
  /// Discs that miss the pixels [x, x + width) × [y, y + height) of the film are not seen.
  void (*place)(const PacketPoints& points, const ObjectPlace& object, const PacketPlace& packet, int x,
                int y, int width, int height, PlacedPacket& placed);

  /// Lets the discs of `lanes` come to the front where they are nearest. Of equal depths the larger tolerance
  /// holds.
  void (*bring_to_front)(const PlacedPacket& placed, std::uint32_t lanes, int x_film, int y_film, int width,
                         int height, const SurfaceRule& rule, CellBuffers& cell);

  /// Adds the discs of `lanes`, in their order, to the front surfaces that they are part of.
  void (*add_to_front)(const PlacedPacket& placed, std::uint32_t lanes, int x_film, int y_film, int width,
                       int height, const SurfaceRule& rule, CellBuffers& cell);

  /// Appends what the discs of `lanes` show behind the front surfaces, at most one fragment a pixel and disc.
  /// Returns how many.
  std::size_t (*find_behind)(const PlacedPacket& placed, std::uint32_t lanes, std::uint32_t first_disc,
                             int x_film, int y_film, int width, int height, const SurfaceRule& rule,
                             const CellBuffers& cell, FragmentBehind* out);

  /// Of what was touched.
  void (*clear)(CellBuffers& cell, int height);
  void (*measure_patches)(CellBuffers& cell, int height);
  /// Turns sums of front surfaces into light: premultiplied colour, alpha, depth by alpha, and what is let
  /// through. Returns whether any pixel lets light through a surface.
  bool (*shade_front)(const SurfaceRule& rule, CellBuffers& cell, int height);
  /// Adds an instant to the sums, and to those that the error is estimated from; there over a background.
  void (*add_instant)(const CellBuffers& cell, const InstantWeights& weights, const float background[3],
                      CellSums& sums, int height);
};

/// Those this processor can run: first the plain loops that define what the others compute, last the widest.
struct SampledMaths {
  const SampledMath* first;
  std::size_t count;

  [[nodiscard]] const SampledMath* begin() const { return first; }
  [[nodiscard]] const SampledMath* end() const { return first + count; }
  [[nodiscard]] const SampledMath& widest() const { return first[count - 1]; }
};
[[nodiscard]] SampledMaths sampled_maths();

}  // namespace swept
