// Fuzzes one reader of point files, SWEPT_READER: whatever the bytes, it returns points that keep the
// promises of point_file.h, or an error; and what it accepts can be made into discs.
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "splat/io/cloud_source.h"
#include "splat/io/read_formats.h"
#include "tests/fuzz/check.h"

namespace swept {
namespace {

constexpr const char* path = "fuzzed";

template <class T>
void check_count(const std::vector<T>& optional, std::size_t points) {
  SWEPT_HOLDS(optional.empty() || optional.size() == points);
}

template <class Vector>
void check_finite(const std::vector<Vector>& vectors) {
  for (const Vector& v : vectors) SWEPT_HOLDS(v.allFinite());
}

void check_points(const PointSet& set) {
  SWEPT_HOLDS(set.size() > 0);
  check_count(set.normal, set.size());
  check_count(set.radius, set.size());
  check_count(set.axis_u, set.size());
  check_count(set.axis_v, set.size());
  check_count(set.color, set.size());
  check_count(set.opacity, set.size());
  check_count(set.velocity, set.size());
  check_count(set.id, set.size());
  SWEPT_HOLDS(set.axis_u.size() == set.axis_v.size());
  check_finite(set.position);
  check_finite(set.axis_u);
  check_finite(set.axis_v);
  check_finite(set.color);
  check_finite(set.velocity);
  // Three components rounded to float, and the length itself.
  for (const Eigen::Vector3f& n : set.normal)
    SWEPT_HOLDS(n.isZero(0.0f) || std::abs(n.cast<double>().norm() - 1.0) <= 4 * 0x1p-24);
  for (const float radius : set.radius) SWEPT_HOLDS(radius >= 0.0f && std::isfinite(radius));
  for (const float opacity : set.opacity) SWEPT_HOLDS(opacity >= 0.0f && opacity <= 1.0f);
  SWEPT_HOLDS(set.report.points == set.size() + set.report.dropped);
  for (const std::string& line : set.report.lines()) SWEPT_HOLDS(!line.empty() && line.size() < 4096);
  for (const auto& triangle : set.triangle)
    for (const std::uint32_t corner : triangle) SWEPT_HOLDS(corner < set.size());
  check_count(set.texture_corners, set.triangle.size());
  check_count(set.materials.of_triangle, set.triangle.size());
  SWEPT_HOLDS(set.materials.on_texture.size() == set.materials.of_triangle.size());
  for (const std::uint32_t material : set.materials.of_triangle)
    SWEPT_HOLDS(material < set.materials.names.size());
}

void read(std::string_view bytes, const ReadOptions& options) {
  Result<PointSet> set = SWEPT_READER(path, bytes, options);
  if (!set) return fuzz::check_error(set.error(), path);
  check_points(*set);
  // Discs of many points take long, and are no other code.
  if (set->size() > 200 || set->triangle.size() > 400) return;
  CloudSource source;
  source.triangles = options.corner_normals;
  const Result<LoadedCloud> cloud = cloud_from_points(*std::move(set), 0.0, source);
  if (cloud)
    SWEPT_HOLDS(cloud->cloud.validate());
  else
    fuzz::check_error(cloud.error(), "");
}

}  // namespace
}  // namespace swept

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  swept::ReadOptions options;
  swept::read(bytes, options);
  options.corner_normals = options.materials = true;
  swept::read(bytes, options);
  options.skip_invalid = true;
  swept::read(bytes, options);
  options.color_range = 1e-6;
  options.color_space = swept::ColorSpace::srgb;
  swept::read(bytes, options);
#ifdef SWEPT_READER_OF_COLUMNS
  options.attributes = {{"position", "1,2,3"}, {"color", "4,5,6,7"}, {"width", "8"}};
  swept::read(bytes, options);
#endif
  return 0;
}
