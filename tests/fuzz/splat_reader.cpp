// Fuzzes one reader of splats, SWEPT_READER: whatever the bytes, it returns a cloud that keeps the promises
// of splat_cloud.h, or an error. Where a format packs all of its bytes, they are given to it packed besides,
// or no change to them would come past a checksum.
#include <string>
#include <string_view>

#include "splat/io/read_splats.h"
#include "tests/fuzz/check.h"
#include "tests/packed_bytes.h"

namespace swept {
namespace {

constexpr const char* path = "fuzzed";

void read(std::string_view bytes, const SplatReadOptions& options) {
  const Result<LoadedSplats> file = io::SWEPT_READER(path, bytes, options);
  if (!file) {
    // A glTF may name other files, which then are what is wrong.
    SWEPT_HOLDS(!file.error().file.empty() && !file.error().reason.empty());
    SWEPT_HOLDS(file.error().message().size() < 4096);
    return;
  }
  SWEPT_HOLDS(file->splats.size() > 0);
  SWEPT_HOLDS(file->splats.validate());
  SWEPT_HOLDS(file->report.points == file->splats.size() + file->report.dropped);
  if (file->motion) SWEPT_HOLDS(file->motion->validate(file->splats.size()));
  for (const std::string& line : file->report.lines()) SWEPT_HOLDS(!line.empty() && line.size() < 4096);
}

#ifdef SWEPT_READER_OF_BUNDLES
/// The bytes as meta.json of a bundle, with images of two by two pixels.
std::string packed(std::string_view bytes) {
  std::string rgba;
  for (int k = 0; k < 16; ++k) rgba += static_cast<char>(k % 4 == 3 ? 252 + k / 4 : 40 + k);
  std::string labels("\0\0\0\xff\1\0\0\xff\2\0\0\xff\3\0\0\xff", 16);
  static const std::string image = swept_test::webp(2, 2, rgba), indices = swept_test::webp(2, 2, labels),
                           palette = swept_test::webp(192, 1, std::string(4 * 192, '\7'));
  return swept_test::zip({{"a", image}, {"l", indices}, {"c", palette}, {"meta.json", std::string(bytes)}});
}
#else
std::string packed(std::string_view bytes) { return swept_test::gzip(std::string(bytes)); }
#endif

}  // namespace
}  // namespace swept

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  swept::SplatReadOptions options;
  swept::read(bytes, options);
  swept::read(swept::packed(bytes), options);
  options.skip_invalid = options.motion = true;
  options.spz_axes = swept::SpzAxes::right_up_back;
  swept::read(bytes, options);
  return 0;
}
