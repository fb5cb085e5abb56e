// Fuzzes the reading of MTL files: whatever the bytes, materials whose numbers are in their ranges, or an
// error that names the line.
#include <cmath>
#include <string>
#include <string_view>

#include "splat/io/obj_materials.h"
#include "tests/fuzz/check.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const swept::Result<swept::MtlFile> file = swept::read_mtl("fuzzed", bytes);
  if (!file) {
    swept::fuzz::check_error(file.error(), "fuzzed");
    SWEPT_HOLDS(file.error().field.rfind("line ", 0) == 0);
    return 0;
  }
  for (const swept::MtlMaterial& material : file->materials) {
    SWEPT_HOLDS(material.color.cwiseAbs().maxCoeff() <= double{swept::most_color});
    SWEPT_HOLDS(material.opacity >= 0.0 && material.opacity <= 1.0);
  }
  SWEPT_HOLDS(file->unread.size() <= 100);
  for (const std::string& line : file->unread) SWEPT_HOLDS(!line.empty() && line.size() < 200);
  return 0;
}
