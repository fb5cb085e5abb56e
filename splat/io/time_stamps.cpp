// Points that were each seen at a time of their own, as a spinning lidar sees them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "splat/io/cloud_keys.h"

namespace swept::io {

Status take_stamps(const PointSet& set, const CloudSource& source, LoadedCloud& loaded) {
  const TimeStamps& stamps = *source.stamps;
  if (set.time.empty())
    return Error{"", "time",
                 "there are no time stamps; \"attributes\": {\"time\": NAME} says which they are"};
  SurfelCloud& cloud = loaded.cloud;
  const double frame = cloud.keys.front().frame;
  const double per_unit = stamps.unit == StampUnit::frames ? 1.0
                                                           : static_cast<double>(source.fps.numerator) /
                                                                 static_cast<double>(source.fps.denominator);
  std::vector<double> frames;
  frames.reserve(set.time.size());
  for (const double time : set.time) frames.push_back(frame + (time - stamps.zero) * per_unit);
  if (!stamps.sensor.keys.empty()) {
    SurfelPose& pose = cloud.keys.front().pose;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (!(std::abs(frames[i]) <= most_frame))
        return Error{"", "time", "point " + std::to_string(i) + " was seen at a frame beyond 1e9"};
      const Eigen::Affine3d sensor = stamps.sensor.at(frames[i]);
      const auto turn = [&](Eigen::Vector3f& v) { v = (sensor.linear() * v.cast<double>()).cast<float>(); };
      pose.position[i] = sensor * pose.position[i];
      turn(pose.axis_u[i]);
      turn(pose.axis_v[i]);
      for (auto* rates : {&cloud.velocity, &cloud.acceleration, &cloud.angular_velocity})
        if (!rates->empty()) turn((*rates)[i]);
    }
  }
  if (cloud.moves())
    if (Status s = shift_to_stamps(cloud, frames); !s) return s;
  const auto [first, last] = std::minmax_element(frames.begin(), frames.end());
  char text[96];
  std::snprintf(text, sizeof text, "points were seen from frame %.6g to %.6g, each at a time of its own",
                *first, *last);
  loaded.report.assumed.emplace_back(text);
  return Done{};
}

}  // namespace swept::io
