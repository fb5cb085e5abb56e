// Deep scan lines: as many samples a pixel as there are, each with a stretch of depth.
#include <algorithm>
#include <exception>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include "splat/io/atomic_file.h"
#include "splat/io/exr_header.h"
#include "splat/io/guarded.h"
#include "splat/io/image_file.h"

namespace swept {
namespace {

constexpr int rows_at_once = 16;

/// What a file says of its samples to those who read it.
constexpr const char* sample_meaning =
    "A and premultiplied R, G, B: of the light that the samples before leave, the mean over the exposure. "
    "Z, ZBack: where in depth along the camera's axis the sample begins and ends. "
    "Samples are sorted and do not overlap; flattened they are the image.";

template <class T>
void point_at(const std::vector<T>& values, std::size_t stride, std::size_t offset, const DeepImage& image,
              std::size_t pixel, std::size_t count, std::vector<const char*>& pointers) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto first = image.first[pixel + i];
    // A pixel without samples has no place among them.
    pointers[i] = first == image.first[pixel + i + 1]
                      ? nullptr
                      : reinterpret_cast<const char*>(values.data() + stride * first + offset);
  }
}

Imf::DeepSlice slice_of(Imf::PixelType type, std::vector<const char*>& pointers, const DeepImage& image,
                        int row, std::size_t bytes) {
  const auto width = static_cast<std::ptrdiff_t>(image.width);
  // The pointer of the pixel (0, 0), which may lie outside.
  char* const origin =
      reinterpret_cast<char*>(pointers.data()) -
      static_cast<std::ptrdiff_t>(sizeof(char*)) * (image.x + width * (std::ptrdiff_t{image.y} + row));
  return {type, origin, sizeof(char*), sizeof(char*) * static_cast<std::size_t>(image.width), bytes};
}

void write_samples(Imf::OStream& stream, const DeepImage& image, const ImageMetadata& metadata,
                   ExrPixels pixels) {
  constexpr const char* colors[] = {"R", "G", "B", "A"};
  constexpr const char* depths[] = {"Z", "ZBack"};
  const bool narrow = pixels == ExrPixels::float16;
  const std::vector<half> halves =
      narrow ? std::vector<half>(image.rgba.begin(), image.rgba.end()) : std::vector<half>();

  Imf::Header header =
      header_of({image.x, image.y, image.width, image.height, image.film_width, image.film_height}, metadata);
  header.setType(Imf::DEEPSCANLINE);
  header.compression() = Imf::ZIPS_COMPRESSION;
  Imf::addDeepImageState(header, Imf::DIS_TIDY);
  header.insert("deepSamples", Imf::StringAttribute(sample_meaning));
  for (const char* name : colors)
    header.channels().insert(name, Imf::Channel(narrow ? Imf::HALF : Imf::FLOAT));
  for (const char* name : depths) header.channels().insert(name, Imf::Channel(Imf::FLOAT));

  Imf::DeepScanLineOutputFile file(stream, header, 0);
  const auto width = static_cast<std::size_t>(image.width);
  std::vector<unsigned int> counts(width * rows_at_once);
  std::vector<const char*> pointers[6];
  for (auto& of_channel : pointers) of_channel.resize(counts.size());
  for (int row = 0; row < image.height; row += rows_at_once) {
    const int rows = std::min(rows_at_once, image.height - row);
    const std::size_t pixel = width * static_cast<std::size_t>(row),
                      count = width * static_cast<std::size_t>(rows);
    for (std::size_t i = 0; i < count; ++i)
      counts[i] = static_cast<unsigned int>(image.first[pixel + i + 1] - image.first[pixel + i]);
    Imf::DeepFrameBuffer frame;
    const std::ptrdiff_t before =
        image.x + static_cast<std::ptrdiff_t>(width) * (std::ptrdiff_t{image.y} + row);
    frame.insertSampleCountSlice(
        {Imf::UINT,
         reinterpret_cast<char*>(counts.data()) - static_cast<std::ptrdiff_t>(sizeof(unsigned int)) * before,
         sizeof(unsigned int), sizeof(unsigned int) * width});
    for (std::size_t c = 0; c < 4; ++c) {
      if (narrow)
        point_at(halves, 4, c, image, pixel, count, pointers[c]);
      else
        point_at(image.rgba, 4, c, image, pixel, count, pointers[c]);
      frame.insert(colors[c], slice_of(narrow ? Imf::HALF : Imf::FLOAT, pointers[c], image, row,
                                       4 * (narrow ? sizeof(half) : sizeof(float))));
    }
    for (std::size_t c = 0; c < 2; ++c) {
      point_at(image.depth, 2, c, image, pixel, count, pointers[4 + c]);
      frame.insert(depths[c], slice_of(Imf::FLOAT, pointers[4 + c], image, row, 2 * sizeof(float)));
    }
    file.setFrameBuffer(frame);
    file.writePixels(rows);
  }
}

}  // namespace

Status write_deep_exr(const std::string& path, const DeepImage& image, const ImageMetadata& metadata,
                      ExrPixels pixels, IfExists existing) {
  return io::guarded(path, [&]() -> Status {
    for (const Status& status : {image.validate(), check(metadata)}) {
      if (!status) return Error{path, status.error().field, status.error().reason, status.error().kind};
    }
    return write_exr_file(path, existing,
                          [&](FileStream& stream) { write_samples(stream, image, metadata, pixels); });
  });
}

}  // namespace swept
