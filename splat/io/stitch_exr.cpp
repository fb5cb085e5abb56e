#include "splat/io/stitch_exr.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <map>
#include <new>
#include <string_view>
#include <utility>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>

#include "splat/io/exr_header.h"
#include "splat/io/guarded.h"
#include "splat/io/image_file.h"
#include "splat/io/stitch_part.h"

namespace swept {
namespace {

using io::bytes_of;
using Part = io::StitchPart;

std::string text_of(const Imf::Header& header, const char* name) {
  const auto* attribute = header.findTypedAttribute<Imf::StringAttribute>(name);
  return attribute == nullptr ? std::string() : attribute->value();
}

/// Header::erase() of OpenEXR 3.1 does not free what it takes out.
Imf::Header without(const Imf::Header& header, std::initializer_list<std::string_view> names) {
  Imf::Header rest;
  for (auto attribute = header.begin(); attribute != header.end(); ++attribute)
    if (std::find(names.begin(), names.end(), attribute.name()) == names.end())
      rest.insert(attribute.name(), attribute.attribute());
  return rest;
}

/// The header alone; damaged and truncated files are errors.
Result<Part> look_at(const std::string& path) {
  Part part;
  part.path = path;
  Result<ExrOrigin> origin = read_exr_origin(path);
  if (!origin) return origin.error();
  Result<Image> window = read_exr_window(path);
  if (!window) return window.error();
  part.origin = *std::move(origin);
  part.window = *std::move(window);
  const Imf::InputFile file(path.c_str(), 0);
  const Imf::Header& header = file.header();
  part.deep = header.hasType() && header.type() == Imf::DEEPSCANLINE;
  if (!part.deep && header.hasType() && header.type() != Imf::SCANLINEIMAGE)
    return Error{path, "type", "is no image of scan lines, plain or deep, which are all that is put together",
                 ErrorKind::unsupported};
  part.whole = text_of(header, "wholeHash");
  if (part.whole.empty())
    return Error{path, "wholeHash",
                 "does not say of which frame it is a part: swept render --crop writes that"};
  return part;
}

Status check_same(const Part& first, const Part& other) {
  const auto differ = [&](const char* field, const std::string& a, const std::string& b) {
    return Error{other.path, field, "is of another frame than " + first.path + ": " + b + ", and not " + a};
  };
  if (first.deep != other.deep)
    return Error{other.path, "type",
                 (other.deep ? "is a deep image, unlike " : "is no deep image, unlike ") + first.path};
  if (first.whole != other.whole) return differ("wholeHash", first.whole, other.whole);
  if (first.origin.method != other.origin.method)
    return differ("method", first.origin.method, other.origin.method);
  const auto size = [](const Image& image) {
    return std::to_string(image.film_width) + " x " + std::to_string(image.film_height);
  };
  if (size(first.window) != size(other.window))
    return differ("displayWindow", size(first.window), size(other.window));
  return Done{};
}

/// Windows of the film that no part covers, as X,Y,WIDTH,HEIGHT, in strips between the parts' edges.
std::vector<std::string> missing(const std::vector<Part>& parts, int width, int height) {
  std::vector<int> edges = {0, height};
  for (const Part& part : parts)
    for (const int y : {part.window.y, part.window.y + part.window.height})
      if (y > 0 && y < height) edges.push_back(y);
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<std::string> windows;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    std::vector<std::pair<int, int>> spans;
    for (const Part& part : parts)
      if (part.window.y <= edges[i] && part.window.y + part.window.height >= edges[i + 1])
        spans.emplace_back(part.window.x, part.window.x + part.window.width);
    std::sort(spans.begin(), spans.end());
    spans.emplace_back(width, width);
    int covered = 0;
    for (const auto& [from, to] : spans) {
      if (from > covered)
        windows.push_back(std::to_string(covered) + "," + std::to_string(edges[i]) + "," +
                          std::to_string(std::min(from, width) - covered) + "," +
                          std::to_string(edges[i + 1] - edges[i]));
      covered = std::max(covered, to);
      if (covered >= width) break;
    }
  }
  return windows;
}

/// The film's pixels, channel by channel in their own types.
class Film {
 public:
  Film(const Imf::ChannelList& channels, int width, int height) : channels_(channels), width_(width) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    for (auto channel = channels.begin(); channel != channels.end(); ++channel)
      planes_[channel.name()].resize(pixels * bytes_of(channel.channel().type));
    covered_.resize(pixels);
  }

  Status put(const Part& part) {
    Imf::InputFile file(part.path.c_str(), 0);
    if (!(file.header().channels() == channels_))
      return Error{part.path, "channels", "has other channels than the parts before it"};
    const Imath::Box2i data = file.header().dataWindow();
    const Image& window = part.window;
    std::map<std::string, std::vector<char>> own;
    Imf::FrameBuffer frame;
    const std::size_t pixels = window.pixel_count();
    for (auto channel = channels_.begin(); channel != channels_.end(); ++channel) {
      const std::size_t bytes = bytes_of(channel.channel().type);
      std::vector<char>& values = own[channel.name()];
      values.resize(pixels * bytes);
      frame.insert(channel.name(), Imf::Slice::Make(channel.channel().type, values.data(), data, bytes,
                                                    bytes * static_cast<std::size_t>(window.width)));
    }
    file.setFrameBuffer(frame);
    file.readPixels(data.min.y, data.max.y);
    for (std::size_t i = 0; i < pixels; ++i) {
      const int x = window.x + static_cast<int>(i % static_cast<std::size_t>(window.width));
      const int y = window.y + static_cast<int>(i / static_cast<std::size_t>(window.width));
      const std::size_t at =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
      for (auto channel = channels_.begin(); channel != channels_.end(); ++channel) {
        const std::size_t bytes = bytes_of(channel.channel().type);
        const char* const from = own[channel.name()].data() + i * bytes;
        char* const to = planes_[channel.name()].data() + at * bytes;
        if (covered_[at] != 0 && std::memcmp(from, to, bytes) != 0)
          return io::parts_differ(part, channel.name(), x, y);
        std::memcpy(to, from, bytes);
      }
      covered_[at] = 1;
    }
    return Done{};
  }

  void write(Imf::OStream& stream, const Imf::Header& header, int height) const {
    Imf::OutputFile file(stream, header, 0);
    Imf::FrameBuffer frame;
    for (auto channel = channels_.begin(); channel != channels_.end(); ++channel) {
      const std::size_t bytes = bytes_of(channel.channel().type);
      frame.insert(channel.name(),
                   Imf::Slice::Make(channel.channel().type, planes_.at(channel.name()).data(),
                                    header.dataWindow(), bytes, bytes * static_cast<std::size_t>(width_)));
    }
    file.setFrameBuffer(frame);
    file.writePixels(height);
  }

 private:
  Imf::ChannelList channels_;
  int width_;
  std::map<std::string, std::vector<char>> planes_;
  std::vector<std::uint8_t> covered_;
};

Status check_parts(const std::vector<Part>& parts) {
  const Image& film = parts.front().window;
  for (const Part& part : parts) {
    if (Status same = check_same(parts.front(), part); !same) return same;
    const Image& w = part.window;
    if (w.x < 0 || w.y < 0 || w.width > film.film_width - w.x || w.height > film.film_height - w.y)
      return Error{part.path, "dataWindow", "is not within the film"};
  }
  const std::vector<std::string> gaps = missing(parts, film.film_width, film.film_height);
  if (gaps.empty()) return Done{};
  std::string text;
  constexpr std::size_t most_named = 8;
  for (std::size_t i = 0; i < std::min(gaps.size(), most_named); ++i) text += " --crop " + gaps[i];
  if (gaps.size() > most_named) text += " and " + std::to_string(gaps.size() - most_named) + " more";
  return Error{"", "", "parts of the film are missing:" + text};
}

Status stitch_flat(const std::vector<Part>& parts, const Imf::Header& header, Imf::OStream& stream) {
  const int height = parts.front().window.film_height;
  Film film(header.channels(), parts.front().window.film_width, height);
  for (const Part& part : parts)
    if (Status put = film.put(part); !put) return put;
  film.write(stream, header, height);
  return Done{};
}

Status stitch(const std::vector<std::string>& paths, const std::string& path, IfExists existing) {
  if (paths.empty()) return Error{path, "parts", "there are none"};
  std::vector<Part> parts;
  for (const std::string& name : paths) {
    Result<Part> part = look_at(name);
    if (!part) return part.error();
    parts.push_back(*std::move(part));
  }
  if (Status fits = check_parts(parts); !fits)
    return Error{fits.error().file.empty() ? path : fits.error().file, fits.error().field,
                 fits.error().reason, fits.error().kind};
  Imf::Header header =
      without(Imf::InputFile(parts.front().path.c_str(), 0).header(), {"wholeHash", "chunkCount"});
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
    if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1)
      return Error{parts.front().path, channel.name(), "has not a value for every pixel"};
  header.dataWindow() = header.displayWindow();
  header.insert("sceneHash", Imf::StringAttribute(parts.front().whole));
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  FileStream stream(path, file->stream());
  if (Status put =
          parts.front().deep ? io::stitch_deep(parts, header, stream) : stitch_flat(parts, header, stream);
      !put)
    return put;
  return file->commit(existing);
}

}  // namespace

Status stitch_exr(const std::vector<std::string>& parts, const std::string& path, IfExists existing) {
  return io::guarded(path, [&]() -> Status {
    try {
      return stitch(parts, path, existing);
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& problem) {
      return Error{path, "", std::string("cannot be put together: ") + problem.what(), ErrorKind::device};
    }
  });
}

}  // namespace swept
