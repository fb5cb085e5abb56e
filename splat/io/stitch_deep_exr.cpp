// Deep crops of one frame, put together line by line.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineInputFile.h>
#include <ImfDeepScanLineOutputFile.h>

#include "splat/io/stitch_part.h"

namespace swept::io {
namespace {

/// Pointers of a line's pixels, as if it stood at every y and began at `left`.
template <class T>
char* line_base(std::vector<T>& line, int left) {
  return reinterpret_cast<char*>(line.data()) - static_cast<std::ptrdiff_t>(sizeof(T)) * left;
}

/// One line of a deep file: how many samples its pixels have, and where they are.
struct DeepLine {
  DeepLine(const Imf::ChannelList& channels, int left, std::size_t width) : counts(width) {
    frame.insertSampleCountSlice({Imf::UINT, line_base(counts, left), sizeof(unsigned int), 0});
    for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
      std::vector<char*>& of_channel = samples[channel.name()];
      of_channel.resize(width);
      const Imf::PixelType type = channel.channel().type;
      frame.insert(channel.name(), {type, line_base(of_channel, left), sizeof(char*), 0, bytes_of(type)});
    }
  }
  DeepLine(const DeepLine&) = delete;  // `frame` points into it
  DeepLine& operator=(const DeepLine&) = delete;

  std::vector<unsigned int> counts;
  std::map<std::string, std::vector<char*>> samples;  ///< by channel
  Imf::DeepFrameBuffer frame;
};

/// A part that is open, and the line of it that was read last.
class OpenPart {
 public:
  OpenPart(const StitchPart& part, const Imf::ChannelList& channels)
      : part_(part),
        channels_(channels),
        file_(part.path.c_str(), 0),
        line_(channels, file_.header().dataWindow().min.x, static_cast<std::size_t>(part.window.width)) {
    // No compression makes a byte of more than 1032.
    std::error_code code;
    most_bytes_ = 1032.0 * static_cast<double>(std::filesystem::file_size(part.path, code));
    file_.setFrameBuffer(line_.frame);
  }

  [[nodiscard]] bool ends_before(int y) const { return part_.window.y + part_.window.height <= y; }

  /// Reads the film's row `y` and puts it into `film`.
  Status put(int y, DeepLine& film, std::vector<char>& covered) {
    if (Status read_line = read(file_.header().dataWindow().min.y + (y - part_.window.y)); !read_line)
      return read_line;
    for (std::size_t i = 0; i < line_.counts.size(); ++i) {
      const std::size_t at = static_cast<std::size_t>(part_.window.x) + i;
      if (covered[at] != 0) {
        if (Status same = compare(i, at, y, film); !same) return same;
        continue;
      }
      covered[at] = 1;
      film.counts[at] = line_.counts[i];
      for (auto& [channel, pixels] : line_.samples) film.samples[channel][at] = pixels[i];
    }
    return Done{};
  }

 private:
  Status read(int y) {
    file_.readPixelSampleCounts(y, y);
    std::size_t count = 0;
    for (const unsigned int of_pixel : line_.counts) count += of_pixel;
    for (auto channel = channels_.begin(); channel != channels_.end(); ++channel) {
      const std::size_t bytes = bytes_of(channel.channel().type);
      if (static_cast<double>(count) * static_cast<double>(bytes) > most_bytes_)
        return Error{part_.path, "sample counts", "promise more samples than the file can hold"};
      std::vector<char>& values = values_[channel.name()];
      values.resize(count * bytes);
      char* at = values.data();
      std::vector<char*>& pixels = line_.samples[channel.name()];
      for (std::size_t i = 0; i < pixels.size(); at += bytes * line_.counts[i++]) pixels[i] = at;
    }
    file_.readPixels(y, y);
    return Done{};
  }

  Status compare(std::size_t i, std::size_t at, int y, const DeepLine& film) const {
    for (auto channel = channels_.begin(); channel != channels_.end(); ++channel) {
      const std::string name = channel.name();
      const std::size_t bytes = line_.counts[i] * bytes_of(channel.channel().type);
      if (film.counts[at] != line_.counts[i] ||
          (bytes > 0 && std::memcmp(film.samples.at(name)[at], line_.samples.at(name)[i], bytes) != 0))
        return parts_differ(part_, name, static_cast<int>(at), y);
    }
    return Done{};
  }

  const StitchPart& part_;
  const Imf::ChannelList& channels_;
  Imf::DeepScanLineInputFile file_;
  std::map<std::string, std::vector<char>> values_;
  DeepLine line_;
  double most_bytes_ = 0.0;
};

/// Of the parts in the order of their first rows, those that hold a row.
class OpenParts {
 public:
  OpenParts(const std::vector<StitchPart>& parts, const Imf::ChannelList& channels) : channels_(channels) {
    for (const StitchPart& part : parts) waiting_.push_back(&part);
    std::stable_sort(waiting_.begin(), waiting_.end(),
                     [](const StitchPart* a, const StitchPart* b) { return a->window.y > b->window.y; });
  }

  Status put(int y, DeepLine& film, std::vector<char>& covered) {
    std::erase_if(open_, [&](const std::unique_ptr<OpenPart>& part) { return part->ends_before(y); });
    for (; !waiting_.empty() && waiting_.back()->window.y <= y; waiting_.pop_back())
      open_.push_back(std::make_unique<OpenPart>(*waiting_.back(), channels_));
    for (const std::unique_ptr<OpenPart>& part : open_)
      if (Status put = part->put(y, film, covered); !put) return put;
    return Done{};
  }

 private:
  const Imf::ChannelList& channels_;
  std::vector<const StitchPart*> waiting_;  ///< the next one last
  std::vector<std::unique_ptr<OpenPart>> open_;
};

}  // namespace

Status stitch_deep(const std::vector<StitchPart>& parts, const Imf::Header& header, Imf::OStream& stream) {
  const Imath::Box2i& film = header.dataWindow();
  const auto width = static_cast<std::size_t>(film.max.x - film.min.x + 1);
  for (const StitchPart& part : parts)
    if (!(Imf::DeepScanLineInputFile(part.path.c_str(), 0).header().channels() == header.channels()))
      return Error{part.path, "channels", "has other channels than the parts before it"};
  OpenParts open(parts, header.channels());
  Imf::DeepScanLineOutputFile file(stream, header, 0);
  DeepLine line(header.channels(), film.min.x, width);
  file.setFrameBuffer(line.frame);
  std::vector<char> covered(width);
  for (int y = film.min.y; y <= film.max.y; ++y) {
    std::fill(covered.begin(), covered.end(), 0);
    if (Status put = open.put(y - film.min.y, line, covered); !put) return put;
    file.writePixels(1);
  }
  return Done{};
}

}  // namespace swept::io
