#include "splat/motion/look.h"

namespace swept {

bool looks_change(const SurfelCloud& cloud, double first, double last) {
  return cloud.looks.size() > 1 && first < last && first < cloud.looks.back().frame &&
         last > cloud.looks.front().frame;
}

std::vector<double> look_corners(const SurfelCloud& cloud, double first, double last) {
  std::vector<double> corners;
  if (!looks_change(cloud, first, last)) return corners;
  for (const LookKey& look : cloud.looks)
    if (look.frame > first && look.frame < last) corners.push_back(look.frame);
  return corners;
}

LooksAt::LooksAt(const SurfelCloud& cloud, double frame)
    : first_{&cloud.color, &cloud.opacity}, second_(first_) {
  if (cloud.looks.empty()) return;
  const LookPlace place = look_place(cloud.looks, frame);
  const auto look_of = [&](std::size_t k) { return Look{&cloud.looks[k].color, &cloud.looks[k].opacity}; };
  first_ = look_of(place.before);
  second_ = look_of(place.after);
  share_ = place.share;
}

}  // namespace swept
