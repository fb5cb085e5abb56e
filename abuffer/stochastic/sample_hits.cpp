#include "abuffer/stochastic/sample_hits.h"

#include <algorithm>
#include <array>
#include <tuple>

namespace swept::stochastic {
namespace {

bool nearer(const LayerHit& a, const LayerHit& b) {
  if (a.z != b.z) return a.z < b.z;
  return std::lexicographical_compare(a.rgba, a.rgba + 4, b.rgba, b.rgba + 4);
}

/// An order of the discs' content alone; of equally near ones the one that leads is model section 1.2's.
bool leads(const DiscHit& a, const DiscHit& b) {
  const auto key = [](const DiscHit& hit) {
    return std::make_tuple(hit.z, rank_of(hit.side), -hit.tolerance, -hit.weight, hit.rgba);
  };
  return key(a) < key(b);
}

/// Sorts by sample, those of one sample by `before`; where each sample's begin, and the last ones' end.
template <class Hit, class Before>
std::vector<std::uint32_t> sort_by_sample(std::vector<Hit>& hits, std::size_t samples, const Before& before) {
  if (hits.empty()) return {};
  std::vector<std::uint32_t> begin(samples + 1, 0);
  for (const Hit& hit : hits) ++begin[hit.sample + 1];
  for (std::size_t i = 0; i < samples; ++i) begin[i + 1] += begin[i];
  std::vector<Hit> sorted(hits.size());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (const Hit& hit : hits) sorted[next[hit.sample]++] = hit;
  for (std::size_t i = 0; i < samples; ++i)
    if (begin[i + 1] - begin[i] > 1)
      std::sort(sorted.begin() + begin[i], sorted.begin() + begin[i + 1], before);
  hits.swap(sorted);
  return begin;
}

}  // namespace

void SampleHits::start(std::size_t samples) {
  nearest_.assign(samples, {0, std::numeric_limits<double>::infinity(), {0.0f, 0.0f, 0.0f, 0.0f}});
  layers_.clear();
  discs_.clear();
}

void SampleHits::add(const LayerHit& hit, bool opaque) {
  if (!opaque)
    layers_.push_back(hit);
  else if (nearer(hit, nearest_[hit.sample]))
    nearest_[hit.sample] = hit;
}

void SampleHits::finish() {
  layer_begin_ = sort_by_sample(layers_, nearest_.size(), nearer);
  disc_begin_ = sort_by_sample(discs_, nearest_.size(), leads);
}

void SampleHits::gather_surfaces(std::size_t sample) {
  surfaces_.clear();
  if (disc_begin_.empty()) return;
  rest_.assign(discs_.begin() + disc_begin_[sample], discs_.begin() + disc_begin_[sample + 1]);
  while (!rest_.empty()) {
    const DiscHit first = rest_.front();
    const double limit = first.z + double{first.tolerance};
    Surface surface{};
    double depth = 0.0, weight = 0.0;
    const auto belongs = [&](const DiscHit& hit) {
      return hit.z <= limit && !both_sides(hit.side, first.side);
    };
    std::size_t kept = 0;
    for (const DiscHit& hit : rest_) {
      if (!belongs(hit)) {
        rest_[kept++] = hit;
        continue;
      }
      surface.sum.weight += hit.weight;
      for (int c = 0; c < 4; ++c) surface.sum.rgba[c] += hit.weight * hit.rgba[static_cast<std::size_t>(c)];
      depth += double{hit.weight} * hit.z;
      weight += double{hit.weight};
    }
    rest_.resize(kept);
    if (!(weight > 0.0)) continue;
    surface.depth = static_cast<float>(depth / weight);
    surface.sum.depth = static_cast<float>(depth);
    surfaces_.push_back(surface);
  }
}

PixelSum SampleHits::compose(std::size_t first, std::size_t count, const SurfaceModel& model) {
  PixelSum pixel;
  for (std::size_t sample = first; sample < first + count; ++sample) {
    gather_surfaces(sample);
    const LayerHit *layer = nullptr, *layers_end = nullptr;
    if (!layer_begin_.empty()) {
      layer = layers_.data() + layer_begin_[sample];
      layers_end = layers_.data() + layer_begin_[sample + 1];
    }
    const LayerHit* opaque =
        nearest_[sample].z < std::numeric_limits<double>::infinity() ? &nearest_[sample] : nullptr;
    float left = 1.0f;
    std::size_t disc = 0;
    while (left > opaque_transmittance) {
      const LayerHit* triangle = opaque;
      if (layer != layers_end && (opaque == nullptr || layer->z <= opaque->z)) triangle = layer;
      if (disc < surfaces_.size() &&
          (triangle == nullptr || !(triangle->z < double{surfaces_[disc].depth}))) {
        model.add(surfaces_[disc++].sum, 1.0, left, pixel);
        continue;
      }
      if (triangle == nullptr) break;
      const double share = double{left}, alpha = std::min(1.0, double{triangle->rgba[3]});
      for (int c = 0; c < 3; ++c) pixel.rgba[c] += share * double{triangle->rgba[c]};
      pixel.rgba[3] += share * alpha;
      pixel.depth += share * alpha * triangle->z;
      if (triangle == opaque) break;
      left *= 1.0f - static_cast<float>(alpha);
      ++layer;
    }
  }
  return pixel;
}

}  // namespace swept::stochastic
