#include <algorithm>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfStringAttribute.h>
#include <openexr.h>

#include "splat/io/exr_attributes.h"
#include "splat/io/guarded.h"
#include "splat/io/image_file.h"

namespace swept {
namespace {

constexpr int kRowsPerStrip = 64;

void stay_silent(exr_const_context_t, exr_result_t, const char*) {}

/// Whether every block of scan lines is there, within the file.
exr_result_t check_scanlines(exr_context_t context, std::uint64_t file_bytes) {
  exr_attr_box2i_t window{};
  std::int32_t rows = 0;
  exr_result_t code = exr_get_data_window(context, 0, &window);
  if (code == EXR_ERR_SUCCESS) code = exr_get_scanlines_per_chunk(context, 0, &rows);
  for (std::int64_t y = window.min.y; y <= window.max.y && code == EXR_ERR_SUCCESS; y += rows) {
    exr_chunk_info_t chunk{};
    code = exr_read_scanline_chunk_info(context, 0, static_cast<int>(y), &chunk);
    if (code == EXR_ERR_SUCCESS &&
        (chunk.data_offset > file_bytes || chunk.packed_size > file_bytes - chunk.data_offset))
      code = EXR_ERR_CORRUPT_CHUNK;
  }
  return code;
}

/// The header by OpenEXR's C reader, which holds what it says of pixels and chunks against the file's size.
/// The C++ reader below believes it.
Status check_header(const std::string& path, std::uint64_t file_bytes, bool with_scanlines = false) {
  exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
  options.error_handler_fn = stay_silent;
  exr_context_t context = nullptr;
  std::uint64_t chunk_bytes = 0;
  std::int32_t chunks = 0;
  exr_result_t code = exr_start_read(&context, path.c_str(), &options);
  if (code == EXR_ERR_SUCCESS) code = exr_get_chunk_count(context, 0, &chunks);
  if (code == EXR_ERR_SUCCESS) code = exr_get_chunk_unpacked_size(context, 0, &chunk_bytes);
  if (code == EXR_ERR_SUCCESS && with_scanlines) code = check_scanlines(context, file_bytes);
  if (context != nullptr) exr_finish(&context);
  if (code != EXR_ERR_SUCCESS) {
    return Error{path, "",
                 std::string("not a readable OpenEXR file: ") + exr_get_default_error_message(code)};
  }
  if (static_cast<std::uint64_t>(chunks) > file_bytes / sizeof(std::uint64_t) ||
      chunk_bytes > most_chunk_bytes(file_bytes)) {
    return Error{path, "dataWindow", "claims more pixels than a file of this size can hold"};
  }
  return Done{};
}

/// All pixels, in strips: memory grows with what the file really holds.
void read_pixels(Imf::InputFile& file, bool has_depth, Image& image) {
  const Imath::V2i origin = file.header().dataWindow().min;
  const auto width = static_cast<std::size_t>(image.width);
  for (int row = 0; row < image.height; row += kRowsPerStrip) {
    const int rows = std::min(kRowsPerStrip, image.height - row);
    const std::size_t begin = width * static_cast<std::size_t>(row);
    const std::size_t end = begin + width * static_cast<std::size_t>(rows);
    image.rgba.resize(4 * end);
    if (has_depth) image.depth.resize(end);

    const auto slice = [&](const float* first, std::size_t stride, double fill) {
      return Imf::Slice::Make(Imf::FLOAT, first, Imath::V2i(origin.x, origin.y + row), image.width, rows,
                              stride * sizeof(float), stride * sizeof(float) * width, 1, 1, fill);
    };
    Imf::FrameBuffer frame;
    float* rgba = &image.rgba[4 * begin];
    frame.insert("R", slice(rgba, 4, 0.0));
    frame.insert("G", slice(rgba + 1, 4, 0.0));
    frame.insert("B", slice(rgba + 2, 4, 0.0));
    frame.insert("A", slice(rgba + 3, 4, 1.0));
    if (has_depth) frame.insert("Z", slice(&image.depth[begin], 1, 0.0));
    file.setFrameBuffer(frame);
    file.readPixels(origin.y + row, origin.y + row + rows - 1);
  }
}

Error missing_channel(const std::string& path, const char* name, const Imf::ChannelList& channels) {
  std::string present;
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
    present += (present.empty() ? "" : ", ") + std::string(channel.name());
  }
  return {path, name, "no such channel; the file has " + (present.empty() ? "none" : present)};
}

/// The image without its pixels.
Result<Image> window_of(const std::string& path, const Imf::InputFile& file) {
  const Imf::ChannelList& channels = file.header().channels();
  for (const char* name : {"R", "G", "B"}) {
    if (channels.findChannel(name) == nullptr) return missing_channel(path, name, channels);
  }
  const Imath::Box2i display = file.header().displayWindow(), data = file.header().dataWindow();
  const auto difference = [](int a, int b) { return std::int64_t{a} - b; };
  const std::int64_t x = difference(data.min.x, display.min.x), y = difference(data.min.y, display.min.y);
  const std::int64_t width = difference(data.max.x, data.min.x) + 1;
  const std::int64_t height = difference(data.max.y, data.min.y) + 1;
  const std::int64_t film_width = difference(display.max.x, display.min.x) + 1;
  const std::int64_t film_height = difference(display.max.y, display.min.y) + 1;
  Image image;
  for (const auto& [from, to] : {std::pair{x, &image.x},
                                 {y, &image.y},
                                 {width, &image.width},
                                 {height, &image.height},
                                 {film_width, &image.film_width},
                                 {film_height, &image.film_height}}) {
    *to = static_cast<int>(from);
    if (*to != from) return Error{path, "dataWindow, displayWindow", "too large"};
  }
  return image;
}

Result<Image> read_window(const std::string& path) {
  const Imf::InputFile file(path.c_str(), 0);
  return window_of(path, file);
}

Result<Image> read_whole(const std::string& path) {
  Imf::InputFile file(path.c_str(), 0);
  Result<Image> window = window_of(path, file);
  if (!window) return window;
  Image image = *std::move(window);
  read_pixels(file, file.header().channels().findChannel("Z") != nullptr, image);
  if (const Status status = image.validate(); !status) {
    return Error{path, status.error().field, status.error().reason, in_a_file(status.error().kind)};
  }
  return image;
}

Status check_file(const std::string& path, bool with_scanlines) {
  std::error_code problem;
  const std::uintmax_t file_bytes = std::filesystem::file_size(path, problem);
  if (problem)
    return Error{path, "", "cannot be read: " + problem.message(),
                 problem == std::errc::no_such_file_or_directory ? ErrorKind::not_found : ErrorKind::device};
  if (Status status = check_exr_attributes(path, file_bytes); !status) return status;
  return check_header(path, file_bytes, with_scanlines);
}

}  // namespace

Result<ExrOrigin> read_exr_origin(const std::string& path) {
  return io::guarded(path, [&]() -> Result<ExrOrigin> {
    if (const Status status = check_file(path, true); !status) return status.error();
    try {
      const Imf::InputFile file(path.c_str(), 0);
      const auto text = [&](const char* name) {
        const auto* attribute = file.header().findTypedAttribute<Imf::StringAttribute>(name);
        return attribute == nullptr ? std::string() : attribute->value();
      };
      return ExrOrigin{text("sceneHash"), text("method")};
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& unreadable) {
      return Error{path, "", std::string("not a readable OpenEXR file: ") + unreadable.what()};
    }
  });
}

namespace {

/// `read` on a file whose header makes sense.
Result<Image> read_checked(const std::string& path, Result<Image> (*read)(const std::string&)) {
  return io::guarded(path, [&]() -> Result<Image> {
    if (const Status status = check_file(path, false); !status) return status.error();
    try {
      return read(path);
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& unreadable) {
      return Error{path, "", std::string("not a readable OpenEXR file: ") + unreadable.what()};
    }
  });
}

}  // namespace

Result<Image> read_exr(const std::string& path) { return read_checked(path, read_whole); }

Result<Image> read_exr_window(const std::string& path) { return read_checked(path, read_window); }

}  // namespace swept
