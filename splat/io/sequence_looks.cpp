#include "splat/io/sequence_looks.h"

#include <algorithm>
#include <string>
#include <utility>

namespace swept::io {
namespace {

template <class A, class B>
bool same(const A& a, const B& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

LookKey look_of(const CloudSource& source, const SurfelCloud& cloud, double frame,
                std::vector<Eigen::Vector3f> color, std::vector<float> opacity) {
  LookKey look;
  look.frame = frame;
  const bool says_itself = source.color || source.color_by_normals;
  if (!says_itself && !color.empty() && !same(color, cloud.color)) look.color = std::move(color);
  if (!opacity.empty() && !same(opacity, cloud.opacity)) look.opacity = std::move(opacity);
  return look;
}

void take_looks(std::vector<LookKey> looks, SurfelCloud& cloud) {
  cloud.looks.clear();
  if (std::all_of(looks.begin(), looks.end(),
                  [](const LookKey& look) { return look.color.empty() && look.opacity.empty(); }))
    return;
  for (LookKey& look : looks) {
    if (look.color.empty()) look.color = cloud.color;
    if (look.opacity.empty()) look.opacity = cloud.opacity;
  }
  cloud.looks = std::move(looks);
}

std::string what_changes(const SurfelCloud& cloud) {
  bool colors = false, opacities = false;
  for (std::size_t k = 1; k < cloud.looks.size(); ++k) {
    colors = colors || !same(cloud.looks[k].color, cloud.looks[0].color);
    opacities = opacities || !same(cloud.looks[k].opacity, cloud.looks[0].opacity);
  }
  if (!colors && !opacities) return "";
  return std::string(!opacities ? "colours"
                     : colors   ? "colours and opacities"
                                : "opacities") +
         " change evenly from file to file";
}

}  // namespace swept::io
