#include "abuffer/resolve/cell_image.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace swept {
namespace {

/// body(place in the cell, place in the image) for the cell's pixels in the window.
template <class Body>
void for_each_pixel(const Cell& cell, const Image& image, const Body& body) {
  for (int y = std::max(cell.y, image.y); y < std::min(cell.y + cell.height, image.y + image.height); ++y)
    for (int x = std::max(cell.x, image.x); x < std::min(cell.x + cell.width, image.x + image.width); ++x)
      body(static_cast<std::size_t>((y - cell.y) * cell_px + (x - cell.x)),
           static_cast<std::size_t>(y - image.y) * static_cast<std::size_t>(image.width) +
               static_cast<std::size_t>(x - image.x));
}

}  // namespace

bool in_window(const Cell& cell, const Image& image) {
  return cell.x < image.x + image.width && cell.x + cell.width > image.x && cell.y < image.y + image.height &&
         cell.y + cell.height > image.y;
}

void store_cell(const Cell& cell, const CellImage& pixels, const Eigen::Vector4f& background, Image& image) {
  for_each_pixel(cell, image, [&](std::size_t from, std::size_t to) {
    const double* rgba = &pixels.rgba[4 * from];
    const double left = std::max(0.0, 1.0 - rgba[3]);
    for (std::size_t c = 0; c < 4; ++c)
      image.rgba[4 * to + c] = static_cast<float>(rgba[c] + left * double{background[static_cast<int>(c)]});
    image.depth[to] = rgba[3] > 0.0 ? static_cast<float>(pixels.depth[from] / rgba[3])
                                    : std::numeric_limits<float>::infinity();
  });
}

void store_cell_error(const Cell& cell, std::span<const float> squares, const Image& image,
                      std::vector<float>& channel) {
  for_each_pixel(cell, image,
                 [&](std::size_t from, std::size_t to) { channel[to] = std::sqrt(squares[from] / 3.0f); });
}

}  // namespace swept
