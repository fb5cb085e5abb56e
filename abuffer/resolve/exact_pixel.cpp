#include "abuffer/resolve/exact_pixel.h"

#include <algorithm>

#include "abuffer/resolve/place_depths.h"
#include "abuffer/resolve/texel_cuts.h"
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
    places_.cut(of.intervals.subspan(first, last - first), of.triangles, ray);
    LightSum of_place;
    for (const PlacePiece& piece : places_.pieces()) {
      const std::span<const std::uint32_t> seen(places_.seen().data() + piece.first, piece.count);
      const bool even =
          std::all_of(seen.begin(), seen.end(), [&](std::uint32_t t) { return of.triangles[t].plain; });
      throw_if_stopped(places_.stop);
      for (const std::uint32_t t : seen)
        if (of.triangles[t].texture != nullptr)
          add_texel_cuts(of.triangles[t], ray, piece.begin, piece.end, cuts_);
      between_cuts(piece.begin, piece.end, cuts_, [&](double begin, double end) {
        add_light(
            of.light.share(begin), of.light.share(end), even, of.light,
            [&](double time) { return light_at(seen, of.triangles, ray, time); }, of_place,
            [&](double first_share, double last_share) {
              if (by_depth != nullptr)
                add_depths(seen, of.triangles, ray, of.light, first_share, last_share, 1.0 / pixel_places,
                           *by_depth);
            });
      });
    }
    sum.add(of_place, 1.0 / pixel_places);
    first = last;
  }
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
