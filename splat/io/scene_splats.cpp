#include "splat/io/scene_splats.h"

#include <string>
#include <utility>
#include <variant>

namespace swept::io {
namespace {

/// A member of the object that means nothing to splats; empty: there is none.
std::string disc_member(const ObjectSource& source, const Object& object) {
  const auto& file = std::get<FileSource>(source.points);
  if (source.color || source.color_by_normals) return "color";
  if (source.radius) return "radius";
  if (source.radius_scale != 1.0) return "radius_scale";
  if (!object.two_sided || source.sideless) return "facing";
  if (!file.attributes.empty()) return "source/attributes";
  if (!file.end_path.empty()) return "source/end_file";
  if (source.stamps) return "stamps";
  if (file.stored.range) return "source/color_range";
  if (file.stored.space) return "source/color_space";
  return {};
}

}  // namespace

bool draws_splats(const ObjectSource& source) {
  const auto* file = std::get_if<FileSource>(&source.points);
  if (file == nullptr || (source.draw && source.draw != DrawAs::splats)) return false;
  return source.draw == DrawAs::splats || holds_splats(file->path);
}

Result<LoadedSplats> load_splats(const ObjectSource& source, const Object& object, const FrameRate& fps) {
  if (const std::string member = disc_member(source, object); !member.empty())
    return Error{"", member,
                 "means nothing to Gaussian splats; \"draw\": \"surfels\" has them read as discs"};
  const auto& file = std::get<FileSource>(source.points);
  SplatReadOptions options;
  options.skip_invalid = file.skip_invalid;
  Result<LoadedSplats> loaded = read_splats(file.path, options);
  if (!loaded) return loaded;
  SplatCloud& splats = loaded->splats;
  splats.frame = file.frame;
  if (source.velocity == VelocityUnit::ignore) splats.velocity.clear();
  if (source.velocity == VelocityUnit::per_second)
    for (Eigen::Vector3f& velocity : splats.velocity)
      velocity = (velocity.cast<double>() * fps.denominator / fps.numerator).cast<float>();
  return loaded;
}

}  // namespace swept::io
