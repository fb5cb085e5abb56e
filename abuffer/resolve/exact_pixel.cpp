#include "abuffer/resolve/exact_pixel.h"

#include <algorithm>

#include "abuffer/resolve/place_depths.h"
#include "abuffer/resolve/texel_cuts.h"
#include "splat/interval/depth_sum.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

void put(const LightSum& sum, PixelSum& pixel) {
  for (int c = 0; c < 4; ++c) pixel.rgba[c] += sum.v[c];
  pixel.depth += sum.v[4];
}

/// Lays the surfaces of discs, piece by piece, among those of triangles.
class AmongTriangles final : public PieceSink {
 public:
  AmongTriangles(MeshPixel& meshes, const SurfaceModel& model, const LightOverTime& light,
                 std::span<const Ticks> breaks, LightSum& sum)
      : meshes_(meshes), model_(model), light_(light), breaks_(breaks), sum_(sum), done_(light.from()) {}

  void piece(Ticks begin, Ticks end, std::span<const MovingSurface> surfaces) override {
    const double from = time(begin), to = time(end);
    meshes_.add(done_, from, sum_);
    meshes_.add(from, to, surfaces, model_, sum_);
    done_ = to;
  }
  [[nodiscard]] Ticks end_after(Ticks begin) override {
    while (next_ < breaks_.size() && breaks_[next_] <= begin) ++next_;
    return next_ < breaks_.size() ? breaks_[next_] : shutter_close;
  }
  [[nodiscard]] float nearest() const override { return meshes_.nearest(); }
  void finish() { meshes_.add(done_, light_.to(), sum_); }

 private:
  [[nodiscard]] double time(Ticks ticks) const {
    return ticks == 0 ? light_.from() : ticks == shutter_close ? light_.to() : light_.time(share_of(ticks));
  }

  MeshPixel& meshes_;
  const SurfaceModel& model_;
  const LightOverTime& light_;
  std::span<const Ticks> breaks_;
  LightSum& sum_;
  double done_;
  std::size_t next_ = 0;
};

}  // namespace

void ExactPixel::add(const TrianglesOfPixel& of, PixelSum& pixel) {
  LightSum sum;
  const std::uint32_t mesh = of.triangles[of.intervals.front().source].mesh;
  if (std::all_of(of.intervals.begin(), of.intervals.end(),
                  [&](const PlaceInterval& i) { return of.triangles[i.source].mesh == mesh; })) {
    add_one_mesh(of, sum, pixel.by_depth);
  } else {
    ++pixels_of_several_meshes;
    meshes_.begin(of.intervals, of.triangles, of.rays, of.light, places_, pixel.by_depth);
    meshes_.add(of.light.from(), of.light.to(), sum);
  }
  put(sum, pixel);
}

/// Place by place.
void ExactPixel::add_one_mesh(const TrianglesOfPixel& of, LightSum& sum, DepthSum* by_depth) {
  for (std::size_t first = 0; first < of.intervals.size();) {
    std::size_t last = first + 1;
    while (last < of.intervals.size() && of.intervals[last].place == of.intervals[first].place) ++last;
    const Eigen::Vector3d& ray = of.rays[of.intervals[first].place % pixel_places];
    const std::span<PlaceInterval> intervals = of.intervals.subspan(first, last - first);
    LightSum of_place, of_events;
    const bool peels = PlacePeel::is_for(intervals, of.triangles);
    if (peels) peel_.add(intervals, of.triangles, ray, of.light, places_.stop, places_.counters, of_place);
    // Samples by depth are those of events. The picture does not depend on whether they are asked for.
    if (!peels || by_depth != nullptr) {
      view_.clear();
      places_.cut(intervals, of.triangles, ray, view_);
      add_place(of, ray, of_events, by_depth);
      if (!peels) of_place = of_events;
    }
    sum.add(of_place, 1.0 / pixel_places);
    first = last;
  }
}

void ExactPixel::add_place(const TrianglesOfPixel& of, const Eigen::Vector3d& ray, LightSum& sum,
                           DepthSum* by_depth) {
  const auto add_by_depth = [&](const PlacePiece& piece, double first, double last) {
    if (by_depth != nullptr) add_depths(of, ray, piece, first, last, *by_depth);
  };
  for (const PlacePiece& piece : view_.pieces) {
    throw_if_stopped(places_.stop);
    bool even = true, plain = true;
    for (std::uint32_t i = piece.first; i < piece.first + piece.count; ++i) {
      const TriangleStretch& triangle = of.triangles[view_.layers[view_.seen[i]].source];
      plain = plain && triangle.plain;
      even = even && (triangle.plain || (triangle.one_color && triangle.even_alpha && of.light.even()));
    }
    if (even) add_even(of, ray, piece, sum);
    if (plain) add_by_depth(piece, of.light.share(piece.begin), of.light.share(piece.end));
    if (plain || (even && by_depth == nullptr)) continue;
    for (std::uint32_t i = piece.first; i < piece.first + piece.count; ++i)
      if (const TriangleStretch& triangle = of.triangles[view_.layers[view_.seen[i]].source];
          triangle.texture != nullptr)
        add_texel_cuts([&](double time) { return triangle.on_texture(ray, time); }, piece.begin, piece.end,
                       cuts_);
    // Else what is seen is noted already, and depths alone are wanted.
    LightSum noted;
    LightSum& to = even ? noted : sum;
    between_cuts(piece.begin, piece.end, cuts_, [&](double begin, double end) {
      add_light(
          of.light.share(begin), of.light.share(end), of.light,
          [&](double time) { return light_at(of, ray, piece, time); }, to,
          [&](double first, double last) { add_by_depth(piece, first, last); });
    });
  }
  for (std::uint32_t layer = 0; layer < view_.layers.size(); ++layer) add_noted(of, ray, layer, sum);
}

/// Opacities do not change, and depths do, and colours along the way over a texture. What goes on as it was
/// before is only noted: what begins or ends behind a triangle, or in front of it with the same opacity, is
/// no event to it.
void ExactPixel::add_even(const TrianglesOfPixel& of, const Eigen::Vector3d& ray, const PlacePiece& piece,
                          LightSum& sum) {
  double left = 1.0;
  for (std::uint32_t i = piece.first; i < piece.first + piece.count; ++i) {
    PlaceLayer& layer = view_.layers[view_.seen[i]];
    if (layer.until != piece.begin || layer.weight != left) {
      add_noted(of, ray, view_.seen[i], sum);
      layer.weight = left;
      layer.from = piece.begin;
    }
    layer.until = piece.end;
    left *= 1.0 - double{of.triangles[layer.source].rgba[0][3]};
    if (left < double{opaque_transmittance}) break;
  }
}

void ExactPixel::add_noted(const TrianglesOfPixel& of, const Eigen::Vector3d& ray, std::uint32_t layer,
                           LightSum& sum) {
  const PlaceLayer noted = view_.layers[layer];
  const double first = of.light.share(noted.from), last = of.light.share(noted.until);
  if (noted.weight == 0.0 || !(first < last)) return;
  const TriangleStretch& triangle = of.triangles[noted.source];
  const float(&rgba)[4] = triangle.rgba[0];
  const PlaceDepth& depth = view_.depth(layer, of.triangles, ray);
  const double weight = noted.weight * (last - first);
  if (triangle.texture != nullptr) add_texels(of, ray, noted, sum);
  for (int c = triangle.texture == nullptr ? 0 : 3; c < 4; ++c) sum.v[c] += weight * double{rgba[c]};
  sum.v[4] += noted.weight * double{rgba[3]} *
              smooth_integral(of.light, first, last, [&](double time) { return depth.at(time); });
}

/// Red, green and blue.
void ExactPixel::add_texels(const TrianglesOfPixel& of, const Eigen::Vector3d& ray, const PlaceLayer& noted,
                            LightSum& sum) {
  const TriangleStretch& triangle = of.triangles[noted.source];
  if (way_.find(triangle, ray, noted.from, noted.until)) {
    LightLeft::Part part;
    part.begin = noted.from, part.end = noted.until, part.is_even = true, part.even = noted.weight;
    way_.see(part);
    way_.add_light(triangle, sum);
    return;
  }
  LightSum seen;
  add_texel_cuts([&](double time) { return triangle.on_texture(ray, time); }, noted.from, noted.until, cuts_);
  between_cuts(noted.from, noted.until, cuts_, [&](double begin, double end) {
    add_light(
        begin, end, of.light,
        [&](double time) {
          LightSum at;
          std::copy_n(triangle.look(ray, time).rgba, 3, at.v);
          return at;
        },
        seen, [](double, double) {});
  });
  for (int c = 0; c < 3; ++c) sum.v[c] += noted.weight * seen.v[c];
}

LightSum ExactPixel::light_at(const TrianglesOfPixel& of, const Eigen::Vector3d& ray, const PlacePiece& piece,
                              double time) const {
  LightSum sum;
  double left = 1.0;
  for (std::uint32_t i = piece.first; i < piece.first + piece.count; ++i) {
    const TriangleStretch::Look look = of.triangles[view_.layers[view_.seen[i]].source].look(ray, time);
    for (int c = 0; c < 4; ++c) sum.v[c] += left * look.rgba[c];
    sum.v[4] += left * look.rgba[3] * look.depth;
    left *= 1.0 - look.rgba[3];
    if (left < double{opaque_transmittance}) break;
  }
  return sum;
}

/// Of what light_at() sees at the nodes of these shares of light.
void ExactPixel::add_depths(const TrianglesOfPixel& of, const Eigen::Vector3d& ray, const PlacePiece& piece,
                            double first, double last, DepthSum& by_depth) const {
  for_each_node(first, last, of.light, [&](double time, double weight, double begin, double end) {
    double left = 1.0;
    for (std::uint32_t i = piece.first; i < piece.first + piece.count; ++i) {
      const TriangleStretch& triangle = of.triangles[view_.layers[view_.seen[i]].source];
      const TriangleStretch::Look look = triangle.look(ray, time);
      double rgba[4];
      for (int c = 0; c < 4; ++c) rgba[c] = weight / pixel_places * left * look.rgba[c];
      by_depth.add(triangle.look(ray, begin).depth, triangle.look(ray, end).depth, rgba);
      left *= 1.0 - look.rgba[3];
      if (left < double{opaque_transmittance}) break;
    }
  });
}

void ExactPixel::add(const DiscsOfPixel& discs, const TrianglesOfPixel& of, PixelSum& pixel,
                     SweepCounters& counters) {
  LightSum sum;
  meshes_.begin(of.intervals, of.triangles, of.rays, of.light, places_, pixel.by_depth);
  breaks_.clear();
  for (const double time : meshes_.times()) {
    const Ticks ticks = ticks_of(std::clamp(of.light.share(time), 0.0, 1.0));
    if (ticks > 0 && ticks < shutter_close) breaks_.push_back(ticks);
  }
  AmongTriangles sink(meshes_, model_, of.light, breaks_, sum);
  sweep_.resolve_into(sink, discs.fragments, discs.shades, discs.indices.data(), discs.indices.size(),
                      counters, discs.changes);
  sink.finish();
  put(sum, pixel);
}

}  // namespace swept
