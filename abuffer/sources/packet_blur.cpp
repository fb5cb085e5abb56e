#include "abuffer/sources/packet_blur.h"

#include <algorithm>
#include <cmath>

#include "abuffer/sources/object_instant.h"

namespace swept {

PacketBlur::PacketBlur(const Scene& scene, const Exposure& exposure,
                       const std::vector<PointPackets>& objects) {
  const double frame = exposure.middle();
  const double most = scene.film.width + scene.film.height;
  for (const PointPackets& object : objects) {
    std::vector<float>& of_packets = px_.emplace_back(object.count);
    const ObjectInstant at(scene, object, frame);
    for (std::size_t p = 0; p < object.count; ++p) {
      const double z = std::max(at.center(object, p).z(), scene.camera.near);
      of_packets[p] = static_cast<float>(std::min(most, 2.0 * at.lens_px * std::abs(1.0 / z - at.per_focus)));
    }
  }
}

double PacketBlur::of(std::span<const PacketRef> packets) const {
  double squares = 0.0, count = 0.0;
  for (const PacketRef packet : packets) {
    const double px = double{px_[packet.object][packet.packet]};
    squares += px * px;
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(squares / count) : 0.0;
}

}  // namespace swept
