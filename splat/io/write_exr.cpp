#include <exception>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfOutputFile.h>
#include <ImfThreading.h>
#include <half.h>

#include "splat/io/atomic_file.h"
#include "splat/io/exr_header.h"
#include "splat/io/guarded.h"
#include "splat/io/image_file.h"

namespace swept {
namespace {

/// Slices of both signs of window offset; OpenEXR takes const images by a mutable pointer.
template <class T>
Imf::Slice slice_of(Imf::PixelType type, const std::vector<T>& values, std::size_t offset, std::size_t stride,
                    const Image& image) {
  return Imf::Slice::Make(type, values.data() + offset, Imath::V2i(image.x, image.y), image.width,
                          image.height, stride * sizeof(T),
                          stride * sizeof(T) * static_cast<std::size_t>(image.width));
}

void write_pixels(Imf::OStream& stream, const Image& image, const ImageMetadata& metadata, ExrPixels pixels) {
  constexpr const char* kNames[] = {"R", "G", "B", "A"};
  const bool narrow = pixels == ExrPixels::float16;
  const std::vector<half> halves =
      narrow ? std::vector<half>(image.rgba.begin(), image.rgba.end()) : std::vector<half>();

  Imf::Header header =
      header_of({image.x, image.y, image.width, image.height, image.film_width, image.film_height}, metadata);
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < 4; ++c) {
    header.channels().insert(kNames[c], Imf::Channel(narrow ? Imf::HALF : Imf::FLOAT));
    frame.insert(kNames[c], narrow ? slice_of(Imf::HALF, halves, c, 4, image)
                                   : slice_of(Imf::FLOAT, image.rgba, c, 4, image));
  }
  if (!image.depth.empty()) {
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    frame.insert("Z", slice_of(Imf::FLOAT, image.depth, 0, 1, image));
  }
  for (const ImageChannel& channel : image.channels) {
    header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
    frame.insert(channel.name, slice_of(Imf::FLOAT, channel.values, 0, 1, image));
  }
  // As many threads as the process lets OpenEXR have: none unless it asked for some.
  Imf::OutputFile file(stream, header, Imf::globalThreadCount());
  file.setFrameBuffer(frame);
  file.writePixels(image.height);
}

}  // namespace

Status write_exr(const std::string& path, const Image& image, const ImageMetadata& metadata, ExrPixels pixels,
                 IfExists existing) {
  return io::guarded(path, [&]() -> Status {
    for (const Status& status : {image.validate(), check(metadata)}) {
      if (!status) return Error{path, status.error().field, status.error().reason, status.error().kind};
    }
    return write_exr_file(path, existing,
                          [&](FileStream& stream) { write_pixels(stream, image, metadata, pixels); });
  });
}

}  // namespace swept
