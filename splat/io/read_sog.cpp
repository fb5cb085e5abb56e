// The SOG format of PlayCanvas, version 2: meta.json and lossless images, a pixel per splat, in a zip archive
// or beside each other in a folder. Source: the specification in PlayCanvas' user manual, "The SOG Format",
// and splat-transform's reader.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "splat/io/file_bytes.h"
#include "splat/io/guarded.h"
#include "splat/io/json_node.h"
#include "splat/io/json_text.h"
#include "splat/io/packed_quaternion.h"
#include "splat/io/read_splats.h"
#include "splat/io/splat_builder.h"
#include "splat/io/webp_image.h"
#include "splat/io/zip_file.h"

namespace swept::io {
namespace {

constexpr std::size_t codebook_size = 256, most_meta_bytes = std::size_t{16} << 20;
constexpr std::size_t palette_columns = 64, most_palette = 65536;

using Codebook = std::array<double, codebook_size>;

/// A file of the bundle by its name, of at most so many bytes. Errors without file and field.
using Member = std::function<Result<std::string>(const std::string& name, std::size_t most)>;

class Reader {
 public:
  /// `packed_bytes` in all files together.
  Reader(const std::string& path, std::size_t packed_bytes, Member member, const SplatReadOptions& options)
      : path_(path),
        packed_bytes_(packed_bytes),
        options_(options),
        member_(std::move(member)),
        meta_(meta()) {}

  Result<LoadedSplats> read() {
    const JsonNode root(meta_, path_);
    const std::optional<JsonNode> version = root.find("version");
    if (!version) root.fail("has no \"version\", as version 1 of SOG, which is not known");
    if (version->number() != 2.0) version->fail("is not 2, the one that is known");
    count_ = static_cast<std::size_t>(root.require("count").integer(0, 1LL << 32));
    if (count_ == 0) return Error{path_, "", "has no splats", ErrorKind::empty};
    if (const auto antialias = root.find("antialias")) antialiased_ = antialias->boolean();

    const std::optional<JsonNode> harmonics = root.find("shN");
    if (harmonics) read_palette(*harmonics);
    // Before any of their images is unpacked.
    if (const Status s = may_hold(packed_bytes_, count_, degree_); !s)
      return named(s.error(), path_, root.require("count").pointer());
    const JsonNode means = root.require("means"), scales = root.require("scales"),
                   colors = root.require("sh0");
    low_ = image_of_splats(means, 0, 2);
    high_ = image_of_splats(means, 1, 2);
    mins_ = means.require("mins").vector3();
    maxs_ = means.require("maxs").vector3();
    quats_ = image_of_splats(root.require("quats"), 0, 1);
    scales_ = image_of_splats(scales, 0, 1);
    scale_book_ = codebook(scales);
    colors_ = image_of_splats(colors, 0, 1);
    color_book_ = codebook(colors);
    if (harmonics && degree_ > 0) labels_ = image_of_splats(*harmonics, 1, 2);

    SplatBuilder builder(path_, count_, degree_, false, options_, name_of);
    for (std::size_t i = 0; i < count_; ++i)
      if (Status s = builder.add(splat(i)); !s) return s.error();
    report(builder.loaded);
    return builder.finish();
  }

 private:
  nlohmann::json meta() const {
    const Result<std::string> text = member_("meta.json", most_meta_bytes);
    if (!text) throw named(text.error(), path_, "meta.json");
    Result<nlohmann::json> meta = parse_json(path_, *text);
    if (!meta) throw meta.error();
    return *std::move(meta);
  }

  /// File `which` of the `of` that the node lists.
  ByteImage image(const JsonNode& node, std::size_t which, std::size_t of, std::size_t least,
                  std::size_t most) const {
    const JsonNode files = node.require("files");
    if (files.elements().size() != of) files.fail("must list " + std::to_string(of) + " files");
    const JsonNode name = files.at(which);
    // Even noise takes little more than its pixels.
    const Result<std::string> bytes = member_(name.string(), 5 * most + 4096);
    if (!bytes) throw named(bytes.error(), path_, name.string());
    Result<ByteImage> read = read_webp(*bytes, least, most);
    if (!read) throw named(read.error(), path_, name.string());
    return *std::move(read);
  }

  ByteImage image_of_splats(const JsonNode& node, std::size_t which, std::size_t of) const {
    // Sides are rounded up.
    return image(node, which, of, count_, 2 * count_ + 65536);
  }

  Codebook codebook(const JsonNode& node) {
    const JsonNode book = node.require("codebook");
    const std::vector<JsonNode> numbers = book.elements();
    if (numbers.size() != codebook_size)
      book.fail("has " + std::to_string(numbers.size()) + " numbers, not " + std::to_string(codebook_size));
    Codebook values{};
    for (std::size_t k = 0; k < codebook_size; ++k) {
      const bool lost = k == 0 && numbers[k].json().is_null();
      values[k] = lost ? NAN : numbers[k].number();
      if (lost) lost_first_ = true;
    }
    // Some writers lose the first; PlayCanvas' own readers put it a mean step before the second.
    if (std::isnan(values[0])) values[0] = values[1] - (values[255] - values[1]) / 255.0;
    return values;
  }

  void read_palette(const JsonNode& node) {
    const ByteImage centroids = image(node, 0, 2, palette_columns, most_palette * 15);
    for (int degree = 1; degree <= 3; ++degree)
      if (centroids.width == palette_columns * static_cast<std::size_t>(SplatCloud::coefficients(degree) - 1))
        degree_ = degree;
    if (degree_ == 0)
      node.require("files").at(0).fail(
          "is " + std::to_string(centroids.width) +
          " pixels wide, not the 192, 512 or 960 of harmonics of degree 1, 2 or 3");
    if (const auto bands = node.find("bands"); bands && bands->integer(0, 99) != degree_)
      bands->fail("is not " + std::to_string(degree_) + ", as the width of the centroids has it");
    palette_size_ = palette_columns * centroids.height;
    if (const auto count = node.find("count")) {
      const auto size = static_cast<std::size_t>(count->integer(1, most_palette));
      if (size > palette_size_)
        count->fail("is " + std::to_string(size) + ", and the centroids are " +
                    std::to_string(palette_size_));
      palette_size_ = size;
    }
    const Codebook book = codebook(node);
    palette_.reserve(4 * centroids.pixels());
    for (const std::uint8_t byte : centroids.rgba) palette_.push_back(static_cast<float>(book[byte]));
    palette_width_ = centroids.width;
  }

  [[nodiscard]] SplatRow splat(std::size_t i) const {
    SplatRow row;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      const double t = (low_.at(i)[k] + 256.0 * high_.at(i)[k]) / 65535.0;
      const double n = mins_[axis] * (1.0 - t) + maxs_[axis] * t;
      row.position[axis] = std::copysign(std::expm1(std::abs(n)), n);
      row.scale[axis] = std::exp(scale_book_[scales_.at(i)[k]]);
      row.harmonics[0][axis] = color_book_[colors_.at(i)[k]];
    }
    row.opacity = colors_.at(i)[3] / 255.0;
    const std::uint8_t* const q = quats_.at(i);
    constexpr int first_kind = 252;
    if (q[3] < first_kind)
      throw Error{path_, "quats",
                  "splat " + std::to_string(i) + " has a rotation of kind " + std::to_string(q[3]) +
                      "; 252 to 255 are known",
                  ErrorKind::unsupported};
    const Eigen::Vector3d three = (Eigen::Vector3d(q[0], q[1], q[2]) / 255.0).array() - 0.5;
    row.rotation = with_largest(three * std::numbers::sqrt2, q[3] - first_kind);
    if (degree_ > 0) add_harmonics(i, row);
    return row;
  }

  void add_harmonics(std::size_t i, SplatRow& row) const {
    const std::size_t label = labels_.at(i)[0] + std::size_t{256} * labels_.at(i)[1];
    if (label >= palette_size_)
      throw Error{path_, "shN",
                  "splat " + std::to_string(i) + " has entry " + std::to_string(label) + " of a palette of " +
                      std::to_string(palette_size_)};
    const std::size_t coefficients = palette_width_ / palette_columns;
    const std::size_t first =
        label / palette_columns * palette_width_ + label % palette_columns * coefficients;
    for (std::size_t k = 0; k < coefficients; ++k)
      for (std::size_t channel = 0; channel < 3; ++channel)
        row.harmonics[k + 1][static_cast<Eigen::Index>(channel)] =
            static_cast<double>(palette_[4 * (first + k) + channel]);
  }

  static std::string name_of(SplatPart part, std::size_t) {
    switch (part) {
      case SplatPart::position:
        return "/means";
      case SplatPart::scale:
        return "/scales/codebook";
      case SplatPart::rotation:
        return "quats";
      case SplatPart::opacity:
        return "sh0";
      default:
        return "/sh0/codebook, /shN/codebook";
    }
  }

  void report(LoadedSplats& loaded) const {
    if (antialiased_) loaded.splats.filter = SplatFilter::antialiased;
    loaded.report.used = {{"position", {"means"}},
                          {"scale", {"scales"}},
                          {"rotation", {"quats"}},
                          {"opacity", {"sh0"}},
                          {"color", {"sh0"}}};
    if (degree_ > 0) loaded.report.used.push_back({"harmonics", {"shN"}});
    loaded.report.assumed.push_back("3D Gaussian splats with y down, as they are trained; colours sRGB");
    if (lost_first_)
      loaded.report.assumed.push_back(
          "the first number of a codebook is not there: a mean step before the second");
  }

  const std::string& path_;
  std::size_t packed_bytes_;
  const SplatReadOptions& options_;
  Member member_;
  nlohmann::json meta_;
  std::size_t count_ = 0, palette_size_ = 0, palette_width_ = 0;
  int degree_ = 0;
  bool antialiased_ = false, lost_first_ = false;
  Eigen::Vector3d mins_, maxs_;
  ByteImage low_, high_, quats_, scales_, colors_, labels_;
  Codebook scale_book_{}, color_book_{};
  std::vector<float> palette_;  ///< numbers of the centroids, four per pixel
};

/// What stands beside meta.json. Nothing else is opened, whatever that says.
Result<std::string> file_beside(const std::filesystem::path& folder, const std::string& name,
                                std::size_t most) {
  const std::filesystem::path file(name);
  if (!file.has_filename() || file != file.filename() || name == ".." || name == ".")
    return Error{"", "", "must be the name of a file beside meta.json"};
  std::error_code code;
  const std::uintmax_t size = std::filesystem::file_size(folder / file, code);
  if (!code && size > most) return Error{"", "", "is larger than " + std::to_string(most) + " bytes"};
  Result<std::string> bytes = read_bytes((folder / file).string());
  if (!bytes) return Error{"", "", bytes.error().reason, bytes.error().kind};
  return bytes;
}

}  // namespace

Result<LoadedSplats> read_sog(const std::string& path, std::string_view bytes,
                              const SplatReadOptions& options) {
  return guarded(path, [&]() -> Result<LoadedSplats> {
    const Result<ZipFile> zip = ZipFile::open(bytes);
    if (!zip) return named(zip.error(), path, "");
    return Reader(
               path, bytes.size(),
               [&](const std::string& name, std::size_t most) { return zip->read(name, most); }, options)
        .read();
  });
}

Result<LoadedSplats> read_sog_folder(const std::string& path, std::string_view meta,
                                     const SplatReadOptions& options) {
  return guarded(path, [&]() -> Result<LoadedSplats> {
    std::size_t packed_bytes = meta.size();
    std::error_code code;
    for (const std::string& image : images_beside(path)) {
      const std::uintmax_t size = std::filesystem::file_size(image, code);
      if (!code) packed_bytes += static_cast<std::size_t>(size);
    }
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    return Reader(
               path, packed_bytes,
               [&](const std::string& name, std::size_t most) -> Result<std::string> {
                 if (name == "meta.json") return std::string(meta);
                 return file_beside(folder, name, most);
               },
               options)
        .read();
  });
}

bool is_sog_meta(const std::string& path) {
  if (std::filesystem::path(path).filename() != "meta.json") return false;
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return false;
  std::string head(std::size_t{1} << 16, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  // A scene may have that name, too; it has its own version.
  return head.find("\"means\"") != std::string::npos && head.find("\"swept\"") == std::string::npos;
}

std::vector<std::string> images_beside(const std::string& path) {
  std::vector<std::string> images;
  std::error_code code;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  for (std::filesystem::directory_iterator entry(folder.empty() ? "." : folder, code), end;
       !code && entry != end; entry.increment(code))
    if (entry->path().extension() == ".webp") images.push_back(entry->path().string());
  std::sort(images.begin(), images.end());
  return images;
}

}  // namespace swept::io
