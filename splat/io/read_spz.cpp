// The .spz format of Niantic: up to version 3 one gzip stream, since version 4 a stream of zstd per
// attribute. Source: https://github.com/nianticlabs/spz, src/cc/load-spz.cc, README.md and
// extensions/README.md.
//
// Its README says that axes are right, up and back, where training has right, down and forward. But its own
// converter of PLY files leaves the axes as they are, unless told otherwise (issue 84 there), and so does
// splat-transform, of whose files that holds to the last bit that they keep. A record of version 4 may say
// what is so.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <vector>

#include "splat/io/packed_quaternion.h"
#include "splat/io/read_splats.h"
#include "splat/io/splat_builder.h"
#include "splat/io/unpack.h"

namespace swept::io {
namespace {

static_assert(std::endian::native == std::endian::little, "spz is little-endian");

constexpr std::uint8_t flag_antialiased = 1, flag_extensions = 2, flag_levels = 0x80;
constexpr std::size_t header_bytes = 16, header_4_bytes = 32, entry_bytes = 16;

enum Stream : std::size_t { positions, alphas, colors, scales, rotations, harmonics, streams };
constexpr std::array<const char*, streams> stream_names{"positions", "alphas",    "colors",
                                                        "scales",    "rotations", "harmonics"};

template <class T>
T load(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

std::uint8_t byte_at(std::string_view bytes, std::size_t offset) {
  return static_cast<std::uint8_t>(bytes[offset]);
}

double half_at(std::string_view bytes, std::size_t offset) {
  const auto half = load<std::uint16_t>(bytes, offset);
  const int exponent = (half >> 10) & 31, mantissa = half & 1023;
  const double sign = half >> 15 ? -1.0 : 1.0;
  if (exponent == 31) return mantissa == 0 ? sign * INFINITY : NAN;
  return sign * (exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25));
}

double int24_at(std::string_view bytes, std::size_t offset) {
  const std::uint32_t word = static_cast<std::uint32_t>(byte_at(bytes, offset)) << 8 |
                             static_cast<std::uint32_t>(byte_at(bytes, offset + 1)) << 16 |
                             static_cast<std::uint32_t>(byte_at(bytes, offset + 2)) << 24;
  return static_cast<double>(std::bit_cast<std::int32_t>(word) >> 8);
}

struct Header {
  std::uint32_t version = 0;
  std::size_t count = 0;
  int degree = 0;
  int fractional_bits = 0;
  std::uint8_t flags = 0;
  bool up_and_back = false;  ///< y and z have other signs than in training
  bool unread_extensions = false;

  [[nodiscard]] std::size_t coefficients() const {
    return static_cast<std::size_t>((degree + 1) * (degree + 1) - 1);
  }
  /// Degree 4 is left out.
  [[nodiscard]] int stored_degree() const { return std::min(degree, 3); }
  /// Of one splat in each stream.
  [[nodiscard]] std::array<std::size_t, streams> sizes() const {
    return {version == 1 ? 6u : 9u, 1, 3, 3, version < 3 ? 3u : 4u, 3 * coefficients()};
  }
};

/// Of the first 16 bytes.
Result<Header> header_of(const std::string& path, std::string_view bytes) {
  if (bytes.size() < header_bytes) return Error{path, "header", "the file ends here"};
  if (!bytes.starts_with("NGSP")) return Error{path, "header", "does not start with NGSP"};
  Header header;
  header.version = load<std::uint32_t>(bytes, 4);
  if (header.version < 1 || header.version > 4)
    return Error{path, "version", "is " + std::to_string(header.version) + "; 1 to 4 are known",
                 ErrorKind::unsupported};
  header.count = load<std::uint32_t>(bytes, 8);
  header.degree = byte_at(bytes, 12);
  header.fractional_bits = byte_at(bytes, 13);
  header.flags = byte_at(bytes, 14);
  if (header.count == 0) return Error{path, "", "has no splats", ErrorKind::empty};
  if (header.degree > 4)
    return Error{path, "shDegree", "is " + std::to_string(header.degree) + "; 0 to 4 are known",
                 ErrorKind::unsupported};
  if (header.flags & flag_levels)
    return Error{path, "flags", "levels of detail, as Spark writes them, are not known",
                 ErrorKind::unsupported};
  if (header.flags & ~(flag_antialiased | flag_extensions))
    return Error{path, "flags", "are " + std::to_string(header.flags) + ", of which only 1 and 2 are known",
                 ErrorKind::unsupported};
  return header;
}

/// What records between header and table of contents say.
Status read_extensions(const std::string& path, std::string_view records, Header& header) {
  constexpr std::uint32_t coordinate_system = 0xADBE0003, unspecified = 0, rub = 4, rdf = 6;
  while (!records.empty()) {
    if (records.size() < 8) return Error{path, "extensions", "end within a record"};
    const auto type = load<std::uint32_t>(records, 0), size = load<std::uint32_t>(records, 4);
    records.remove_prefix(8);
    if (size > records.size()) return Error{path, "extensions", "end within a record"};
    if (type == coordinate_system && size == 4) {
      const auto system = load<std::uint32_t>(records, 0);
      if (system != unspecified && system != rub && system != rdf)
        return Error{path, "extensions",
                     "say that axes are system " + std::to_string(system) +
                         "; known are 4, right up back, and 6, right down forward"};
      header.up_and_back = system != rdf;
    } else {
      header.unread_extensions = true;
    }
    records.remove_prefix(size);
  }
  return Done{};
}

using Streams = std::array<std::string, streams>;

Result<Streams> unpack_gzip(const std::string& path, const Header& header, std::size_t packed,
                            GzipStream& gzip) {
  Streams unpacked;
  if (const Status s = may_hold(packed, header.count, header.stored_degree()); !s)
    return named(s.error(), path, "numPoints");
  for (std::size_t k = 0; k < streams; ++k) {
    Result<std::string> bytes = gzip.next(header.sizes()[k] * header.count);
    if (!bytes) return named(bytes.error(), path, stream_names[k]);
    unpacked[k] = *std::move(bytes);
  }
  if (!(header.flags & flag_extensions) && !gzip.at_end())
    return Error{path, "", "goes on after its splats, or is damaged at its end"};
  return unpacked;
}

Result<Streams> unpack_zstd_streams(const std::string& path, Header& header, std::string_view bytes) {
  if (bytes.size() < header_4_bytes) return Error{path, "header", "the file ends here"};
  const std::size_t count = byte_at(bytes, 15), table = load<std::uint32_t>(bytes, 16);
  const std::size_t expected = header.degree > 0 ? streams : streams - 1;
  if (count != expected)
    return Error{path, "numStreams", "is " + std::to_string(count) + ", not " + std::to_string(expected)};
  if (table < header_4_bytes || table > bytes.size() || count * entry_bytes > bytes.size() - table)
    return Error{path, "tocByteOffset",
                 "is " + std::to_string(table) + ", where no table of contents fits in"};
  if (header.flags & flag_extensions) {
    const std::string_view records = bytes.substr(header_4_bytes, table - header_4_bytes);
    if (const Status s = read_extensions(path, records, header); !s) return s.error();
  }
  if (const Status s = may_hold(bytes.size(), header.count, header.stored_degree()); !s)
    return named(s.error(), path, "numPoints");
  std::size_t at = table + count * entry_bytes;
  Streams unpacked;
  for (std::size_t k = 0; k < count; ++k) {
    const auto packed_size = load<std::uint64_t>(bytes, table + k * entry_bytes);
    const auto size = load<std::uint64_t>(bytes, table + k * entry_bytes + 8);
    const std::size_t wanted = header.sizes()[k] * header.count;
    if (size != wanted)
      return Error{path, stream_names[k],
                   "unpacks to " + std::to_string(size) + " bytes, not the " + std::to_string(wanted) +
                       " of " + std::to_string(header.count) + " splats"};
    if (packed_size > bytes.size() - at)
      return Error{path, stream_names[k],
                   "promises " + std::to_string(packed_size) + " bytes, the file has " +
                       std::to_string(bytes.size() - at) + " left"};
    Result<std::string> stream = unpack_zstd(bytes.substr(at, packed_size), wanted);
    if (!stream) return named(stream.error(), path, stream_names[k]);
    unpacked[k] = *std::move(stream);
    at += packed_size;
  }
  if (at != bytes.size()) return Error{path, "", "goes on after its splats"};
  return unpacked;
}

/// w x y z.
Eigen::Vector4d rotation_at(const Header& header, std::string_view bytes, std::size_t i) {
  if (header.version < 3) {
    const Eigen::Vector3d v =
        Eigen::Vector3d(byte_at(bytes, 3 * i), byte_at(bytes, 3 * i + 1), byte_at(bytes, 3 * i + 2)) / 127.5 -
        Eigen::Vector3d::Ones();
    const Eigen::Vector4d q = with_largest(v, 3);
    return {q[3], q[0], q[1], q[2]};
  }
  const auto word = load<std::uint32_t>(bytes, 4 * i);
  Eigen::Vector3d three;
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t bits = word >> (10 * (2 - k));
    three[k] = (bits & 511) * (std::numbers::sqrt2 / 2.0 / 511.0) * ((bits >> 9) & 1 ? -1.0 : 1.0);
  }
  const Eigen::Vector4d q = with_largest(three, word >> 30);
  return {q[3], q[0], q[1], q[2]};
}

/// What a coefficient is multiplied with where y and z change sign: −1 if its basis function is odd in them
/// together. In the order of SplatCloud, without degree 0.
constexpr std::array<double, 15> flips{-1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1};

SplatRow splat_at(const Header& header, const Streams& in, std::size_t i, int degree) {
  SplatRow row;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    row.position[axis] = header.version == 1
                             ? half_at(in[positions], 6 * i + 2 * k)
                             : std::ldexp(int24_at(in[positions], 9 * i + 3 * k), -header.fractional_bits);
    row.scale[axis] = std::exp(byte_at(in[scales], 3 * i + k) / 16.0 - 10.0);
    row.harmonics[0][axis] = (byte_at(in[colors], 3 * i + k) / 255.0 - 0.5) / 0.15;
  }
  row.opacity = byte_at(in[alphas], i) / 255.0;
  row.rotation = rotation_at(header, in[rotations], i);
  if (header.up_and_back) {
    row.position.tail<2>() *= -1.0;
    row.rotation.tail<2>() *= -1.0;
  }
  const std::size_t bytes = 3 * header.coefficients();
  for (std::size_t k = 0; k + 1 < static_cast<std::size_t>(SplatCloud::coefficients(degree)); ++k)
    for (std::size_t channel = 0; channel < 3; ++channel)
      row.harmonics[k + 1][static_cast<Eigen::Index>(channel)] =
          (header.up_and_back ? flips[k] : 1.0) *
          (byte_at(in[harmonics], i * bytes + 3 * k + channel) - 128.0) / 128.0;
  return row;
}

std::string name_of(SplatPart part, std::size_t) {
  switch (part) {
    case SplatPart::position:
      return stream_names[positions];
    case SplatPart::rotation:
      return stream_names[rotations];
    default:
      return stream_names[scales];  // the others are in range whatever their bytes
  }
}

Result<LoadedSplats> splats_of(const std::string& path, const Header& header, const Streams& in,
                               const SplatReadOptions& options) {
  const int degree = header.stored_degree();
  SplatBuilder builder(path, header.count, degree, false, options, name_of);
  for (std::size_t i = 0; i < header.count; ++i)
    if (Status s = builder.add(splat_at(header, in, i, degree)); !s) return s.error();
  LoadedSplats& loaded = builder.loaded;
  if (header.flags & flag_antialiased) loaded.splats.filter = SplatFilter::antialiased;
  loaded.report.used = {{"position", {stream_names[positions]}},
                        {"scale", {stream_names[scales]}},
                        {"rotation", {stream_names[rotations]}},
                        {"opacity", {stream_names[alphas]}},
                        {"color", {stream_names[colors]}}};
  if (degree > 0) loaded.report.used.push_back({"harmonics", {stream_names[harmonics]}});
  if (header.degree > 3) loaded.report.unread.push_back("harmonics of degree 4");
  if (header.unread_extensions) loaded.report.unread.push_back("extensions");
  loaded.report.assumed.push_back(std::string("3D Gaussian splats with ") +
                                  (header.up_and_back ? "y up and z back, turned to y down and z forward"
                                                      : "y down and z forward, as they are trained") +
                                  "; colours sRGB");
  return builder.finish();
}

}  // namespace

Result<LoadedSplats> read_spz(const std::string& path, std::string_view bytes,
                              const SplatReadOptions& options) {
  if (bytes.starts_with("\x1f\x8b")) {
    GzipStream gzip(bytes);
    const Result<std::string> head = gzip.next(header_bytes);
    if (!head) return named(head.error(), path, "header");
    Result<Header> header = header_of(path, *head);
    if (!header) return header.error();
    header->up_and_back = options.spz_axes == SpzAxes::right_up_back;
    header->unread_extensions = (header->flags & flag_extensions) != 0;
    if (header->version > 3)
      return Error{path, "version", "is 4, which is not packed by gzip", ErrorKind::unsupported};
    const Result<Streams> in = unpack_gzip(path, *header, bytes.size(), gzip);
    if (!in) return in.error();
    return splats_of(path, *header, *in, options);
  }
  Result<Header> header = header_of(path, bytes);
  if (!header) return header.error();
  if (header->version < 4)
    return Error{path, "version", "is " + std::to_string(header->version) + ", which is packed by gzip",
                 ErrorKind::unsupported};
  const Result<Streams> in = unpack_zstd_streams(path, *header, bytes);
  if (!in) return in.error();
  if (options.spz_axes != SpzAxes::automatic)
    header->up_and_back = options.spz_axes == SpzAxes::right_up_back;
  return splats_of(path, *header, *in, options);
}

}  // namespace swept::io
