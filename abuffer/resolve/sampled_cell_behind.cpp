// What lies behind a cell's front surfaces, where those let light through.
#include <algorithm>
#include <limits>

#include "abuffer/resolve/sampled_cell.h"
#include "splat/interval/composite.h"

namespace swept {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// Fragments behind front surfaces that are held at once, unless a single row has more.
constexpr std::size_t most_behind = std::size_t{1} << 22;

/// Surfaces of a pixel that are picked one by one before what is left is sorted.
constexpr int picked_layers = 6;

/// Most that one packet can show in a cell.
constexpr std::size_t packet_fragments = static_cast<std::size_t>(packet_size) * cell_floats;

}  // namespace

/// Appends what lies behind, in the order of the points. Returns false where that becomes too much to hold.
bool SampledCell::gather_behind(std::span<const ObjectInstant> instants, bool may_give_up) {
  behind_count_ = 0;
  for (std::size_t i = 0; i < visible_.size(); ++i) {
    if (!lit(visible_[i])) continue;
    if (!visible_[i].placed) place(i, instants);
    const PlacedPacket& placed = placed_[i];
    const Visible& v = visible_[i];
    const std::size_t room =
        behind_count_ + packet_fragments + (v.general_end - v.general_begin) * cell_floats;
    if (behind_.size() < room) behind_.resize(std::max(room, behind_.size() + behind_.size() / 2));
    behind_count_ +=
        math_.find_behind(placed, placed.seen, static_cast<std::uint32_t>(i * packet_size), cell_.x, cell_.y,
                          cell_.width, cell_.height, rule_, *buffers_, behind_.data() + behind_count_);
    for (std::size_t g = v.general_begin; g < v.general_end; ++g)
      find_general_behind(general_[g], static_cast<std::uint32_t>(g));
    if (may_give_up && behind_count_ > most_behind) return false;
  }
  return true;
}

/// Of rows [y_begin, y_end), by halves where they hold too much.
void SampledCell::shade_behind(std::span<const ObjectInstant> instants, int y_begin, int y_end) {
  if (y_end - y_begin < cell_.height) {
    float* const behind = buffers_->behind;
    std::fill(behind, behind + cell_floats, infinity);
    std::copy(behind_limits_.begin() + y_begin * cell_pitch, behind_limits_.begin() + y_end * cell_pitch,
              behind + y_begin * cell_pitch);
  }
  if (!gather_behind(instants, y_end - y_begin > 1)) {
    if (y_end - y_begin == cell_.height)
      behind_limits_.assign(buffers_->behind, buffers_->behind + cell_floats);
    const int middle = (y_begin + y_end) / 2;
    shade_behind(instants, y_begin, middle);
    shade_behind(instants, middle, y_end);
    return;
  }
  counters.fragments_behind += behind_count_;

  // A stable counting sort: within a pixel fragments keep the order of the points.
  starts_.assign(cell_floats + 1, 0);
  for (std::size_t i = 0; i < behind_count_; ++i) ++starts_[behind_[i].pixel + 1];
  for (std::size_t p = 0; p < cell_floats; ++p) starts_[p + 1] += starts_[p];
  sorted_.resize(behind_count_);
  for (std::size_t i = 0; i < behind_count_; ++i)
    sorted_[starts_[behind_[i].pixel]++] = static_cast<std::uint32_t>(i);
  for (std::size_t begin = 0; begin < behind_count_;) {
    const std::uint32_t pixel = behind_[sorted_[begin]].pixel;
    const std::size_t end = starts_[pixel];
    // What blocks find beyond the cell's own pixels is not seen.
    const int x = static_cast<int>(pixel) % cell_pitch, y = static_cast<int>(pixel) / cell_pitch;
    if (x < cell_.width && y < cell_.height) shade_layers(begin, end);
    begin = end;
  }
}

float SampledCell::tolerance_of(std::uint32_t disc) const {
  const std::uint32_t i = disc & disc_index;
  return disc & general_flag ? general_[i].tolerance : placed_[i / packet_size].tolerance[i % packet_size];
}

const float* SampledCell::color_of(std::uint32_t disc, float (&rgba)[4]) const {
  const std::uint32_t i = disc & disc_index;
  if (disc & general_flag) return general_[i].rgba;
  const PlacedPacket& placed = placed_[i / packet_size];
  const std::uint32_t lane = i % packet_size;
  rgba[0] = placed.red[lane], rgba[1] = placed.green[lane], rgba[2] = placed.blue[lane],
  rgba[3] = placed.alpha[lane];
  return rgba;
}

/// As side_number().
int SampledCell::side_of(const Layer& fragment) {
  return (fragment.disc & disc_front ? 1 : 0) - (fragment.disc & disc_back ? 1 : 0);
}

void SampledCell::add_to_layer(const Layer& fragment, LayerSum& sum) const {
  float own[4];
  const float* rgba = color_of(fragment.disc, own);
  sum.weight += fragment.weight;
  for (int c = 0; c < 4; ++c) sum.rgba[c] += fragment.weight * rgba[c];
  sum.depth += fragment.weight * fragment.depth;
}

void SampledCell::shade_layer(const LayerSum& sum, std::uint32_t pixel, float& through) {
  if (!(sum.weight >= std::numeric_limits<float>::min())) return;
  const float divisor = rule_.hard || sum.weight >= rule_.edge_weight ? sum.weight : rule_.edge_weight;
  const float inverse = 1.0f / divisor, alpha = std::min(sum.rgba[3] / divisor, 1.0f);
  if (keeps_surfaces_)
    surfaces_.push_back({static_cast<int>(pixel) % cell_pitch,
                         static_cast<int>(pixel) / cell_pitch,
                         sum.depth / sum.weight,
                         {sum.rgba[0] * inverse, sum.rgba[1] * inverse, sum.rgba[2] * inverse, alpha}});
  buffers_->red[pixel] += through * (sum.rgba[0] * inverse);
  buffers_->green[pixel] += through * (sum.rgba[1] * inverse);
  buffers_->blue[pixel] += through * (sum.rgba[2] * inverse);
  buffers_->alpha[pixel] += through * alpha;
  buffers_->depth[pixel] += through * (alpha * (sum.depth / sum.weight));
  through *= 1.0f - alpha;
}

/// The surfaces behind a pixel's front one: the same rule, one after the other, until no light is left.
void SampledCell::shade_layers(std::size_t begin, std::size_t end) {
  const std::uint32_t pixel = behind_[sorted_[begin]].pixel;
  layers_.clear();
  for (std::size_t i = begin; i < end; ++i) {
    const FragmentBehind& f = behind_[sorted_[i]];
    layers_.push_back({f.depth, f.weight, f.disc, static_cast<std::uint32_t>(i)});
  }
  float through = buffers_->weight[pixel];
  // Light rarely gets through many: each of the first few is picked out of what is left, which stays in
  // order.
  for (int layer = 0; layer < picked_layers && !layers_.empty() && through > opaque_transmittance; ++layer) {
    float nearest = infinity, limit = 0.0f;
    int side = 0;
    for (const Layer& f : layers_) {
      if (f.depth > nearest || (f.depth == nearest && side_of(f) < side)) continue;
      const float reached = f.depth + tolerance_of(f.disc);
      limit = f.depth == nearest && side_of(f) == side ? std::max(limit, reached) : reached;
      nearest = f.depth;
      side = side_of(f);
    }
    LayerSum sum;
    std::size_t kept = 0;
    for (const Layer& f : layers_) {
      if (f.depth <= limit && side * side_of(f) >= 0)
        add_to_layer(f, sum);
      else
        layers_[kept++] = f;
    }
    layers_.resize(kept);
    shade_layer(sum, pixel, through);
  }
  if (layers_.empty() || !(through > opaque_transmittance)) return;

  std::sort(layers_.begin(), layers_.end(), [&](const Layer& a, const Layer& b) {
    return a.depth != b.depth ? a.depth < b.depth : rule_.sides && side_of(a) > side_of(b);
  });
  const auto at = [&](std::size_t i) { return layers_.begin() + static_cast<std::ptrdiff_t>(i); };
  for (std::size_t first = 0; first < layers_.size() && through > opaque_transmittance;) {
    const int side = side_of(layers_[first]);
    float limit = layers_[first].depth + tolerance_of(layers_[first].disc);
    std::size_t last = first + 1;
    for (; last < layers_.size() && layers_[last].depth == layers_[first].depth &&
           side_of(layers_[last]) == side;
         ++last)
      limit = std::max(limit, layers_[last].depth + tolerance_of(layers_[last].disc));
    while (last < layers_.size() && layers_[last].depth <= limit) ++last;
    // What shows the other side is another surface, behind this one.
    if (rule_.sides)
      last = static_cast<std::size_t>(
          std::stable_partition(at(first), at(last), [&](const Layer& f) { return side * side_of(f) >= 0; }) -
          layers_.begin());
    std::sort(at(first), at(last), [](const Layer& a, const Layer& b) { return a.order < b.order; });
    LayerSum sum;
    for (std::size_t i = first; i < last; ++i) add_to_layer(layers_[i], sum);
    shade_layer(sum, pixel, through);
    first = last;
  }
}

}  // namespace swept
