// The .splat format of antimatter15's viewer: 32 bytes a splat, without a header.
#include <cstring>

#include "splat/io/read_splats.h"
#include "splat/io/splat_builder.h"

namespace swept::io {
namespace {

constexpr std::size_t splat_bytes = 32;

std::string name_of(SplatPart part, std::size_t) {
  switch (part) {
    case SplatPart::position:
      return "position";
    case SplatPart::scale:
      return "scale";
    case SplatPart::rotation:
      return "rotation";
    default:
      return "color";
  }
}

SplatRow splat_at(const char* from) {
  float numbers[6];
  unsigned char bytes[8];
  std::memcpy(numbers, from, sizeof numbers);
  std::memcpy(bytes, from + sizeof numbers, sizeof bytes);
  SplatRow row;
  for (int k = 0; k < 3; ++k) {
    row.position[k] = static_cast<double>(numbers[k]);
    row.scale[k] = static_cast<double>(numbers[3 + k]);
    row.harmonics[0][k] = (bytes[k] / 255.0 - 0.5) / first_harmonic;
  }
  row.opacity = bytes[3] / 255.0;
  // Writers differ by less than a step in what 1 is stored as; length is not kept.
  for (int k = 0; k < 4; ++k) row.rotation[k] = bytes[4 + k] / 127.5 - 1.0;
  return row;
}

}  // namespace

Result<LoadedSplats> read_splat(const std::string& path, std::string_view bytes,
                                const SplatReadOptions& options) {
  if (bytes.size() % splat_bytes != 0)
    return Error{path, "",
                 "has " + std::to_string(bytes.size()) + " bytes, which is no multiple of the 32 of a splat"};
  // No header says so: the file may as well have been cut off.
  if (bytes.empty()) return Error{path, "", "has no splats"};
  const std::size_t count = bytes.size() / splat_bytes;
  SplatBuilder builder(path, count, 0, false, options, name_of);
  for (std::size_t i = 0; i < count; ++i)
    if (Status s = builder.add(splat_at(bytes.data() + i * splat_bytes)); !s) return s.error();
  builder.loaded.report.used = {{"position", {"position"}},
                                {"scale", {"scale"}},
                                {"rotation", {"rotation"}},
                                {"opacity", {"color"}},
                                {"color", {"color"}}};
  builder.loaded.report.assumed.push_back(
      "3D Gaussian splats with y down, as they are trained; colours sRGB");
  return builder.finish();
}

}  // namespace swept::io
