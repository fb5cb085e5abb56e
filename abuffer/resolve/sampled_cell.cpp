#include "abuffer/resolve/sampled_cell.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "splat/interval/composite.h"

namespace swept {
namespace {

/// Whether there are discs that show their backs, and are known to.
bool tells_sides_apart(const std::vector<PointPackets>& objects) {
  return std::any_of(objects.begin(), objects.end(), [](const PointPackets& object) {
    return !object.oriented.empty() && object.object->two_sided;
  });
}

/// Instants that are added up as floats before they join the doubles: their roundings stay near 10⁻⁷.
constexpr int instants_a_flush = 32;

constexpr float infinity = std::numeric_limits<float>::infinity();

/// Packets between two looks at how far one can see.
constexpr std::size_t packets_a_look = 8;

}  // namespace

SampledCell::SampledCell(const Scene& scene, const std::vector<PointPackets>& objects,
                         const SampledMath& math)
    : scene_(scene),
      math_(math),
      rule_{static_cast<float>(scene.model.delta),
            static_cast<float>(scene.model.edge_weight),
            static_cast<float>(scene.camera.near),
            scene.model.coverage == Coverage::hard,
            tells_sides_apart(objects),
            scene.camera.orthographic},
      background_{scene.background[0], scene.background[1], scene.background[2]},
      buffers_(std::make_unique<CellBuffers>()),
      sums_(std::make_unique<CellSums>()) {
  for (const PointPackets& object : objects) all_objects_.push_back(&object);
  total_.rgba.resize(4 * cell_px * cell_px);
  total_.depth.resize(cell_px * cell_px);
}

void SampledCell::begin(const Cell& cell, std::span<const PacketRef> packets) {
  cell_ = cell;
  packets_ = packets;
  objects_ = all_objects_;
  *sums_ = {};
  // What the last cell left.
  buffers_->touched = all_strips;
  unflushed_ = 0;
  flushed_ = false;
}

void SampledCell::begin(const Cell& cell, CellPackets packets) {
  own_ = std::move(packets);
  begin(cell, own_.refs);
  objects_ = own_.objects;
}

void SampledCell::resume(const CellImage& so_far) {
  total_ = so_far;
  flushed_ = true;
}

void SampledCell::select(std::span<const ObjectInstant> instants) {
  visible_.clear();
  general_.clear();
  for (const PacketRef ref : packets_) {
    const ObjectInstant& at = instants[ref.object];
    const PointPackets& object = *objects_[ref.object];
    Visible v;
    v.ref = ref;
    v.center = at.center(object, ref.packet);
    v.bounds = at.bounds(v.center, double{object.radius[ref.packet]});
    if (v.bounds.empty() || v.bounds.x_max < cell_.x || v.bounds.x_min > cell_.x + cell_.width ||
        v.bounds.y_max < cell_.y || v.bounds.y_min > cell_.y + cell_.height)
      continue;
    const auto patch = [](double px) {
      return static_cast<int>(std::clamp(px, 0.0, cell_px - 1.0)) / patch_px;
    };
    v.patch_x_first = patch(v.bounds.x_min - cell_.x);
    v.patch_x_last = patch(v.bounds.x_max - cell_.x);
    v.patch_y_first = patch(v.bounds.y_min - cell_.y);
    v.patch_y_last = patch(v.bounds.y_max - cell_.y);
    visible_.push_back(v);
  }
  if (placed_.size() < visible_.size()) placed_.resize(std::max(visible_.size(), 2 * placed_.size()));
  nearest_first_.resize(visible_.size());
  std::iota(nearest_first_.begin(), nearest_first_.end(), 0u);
  std::sort(nearest_first_.begin(), nearest_first_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return visible_[a].bounds.nearest < visible_[b].bounds.nearest;
  });
}

bool SampledCell::hidden(const Visible& v) const {
  const auto nearest = static_cast<float>(v.bounds.nearest * (1.0 - 1e-6));
  for (int y = v.patch_y_first; y <= v.patch_y_last; ++y)
    for (int x = v.patch_x_first; x <= v.patch_x_last; ++x)
      if (nearest <= buffers_->patch_limit[y * cell_patches + x]) return false;
  return true;
}

bool SampledCell::lit(const Visible& v) const {
  for (int y = v.patch_y_first; y <= v.patch_y_last; ++y)
    for (int x = v.patch_x_first; x <= v.patch_x_last; ++x)
      if (buffers_->patch_leaks[y * cell_patches + x]) return true;
  return false;
}

void SampledCell::place(std::size_t i, std::span<const ObjectInstant> instants) {
  Visible& v = visible_[i];
  PlacedPacket& placed = placed_[i];
  const PointPackets& object = *objects_[v.ref.object];
  const ObjectInstant& at = instants[v.ref.object];
  const std::size_t p = v.ref.packet;
  v.placed = true;
  v.general_begin = v.general_end = general_.size();
  if (v.center.z() > 0.0) {
    PacketScratch scratch;
    math_.place(object.at(p, at, scratch), at.place, at.on_film(v.center), cell_.x, cell_.y, cell_.width,
                cell_.height, placed);
  } else {
    placed.seen = placed.front = placed.back = 0;
    placed.general = object.lanes[p];
  }
  object.color(p, at, placed);
  for (std::uint32_t lanes = placed.general; lanes != 0; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(__builtin_ctz(lanes));
    const auto disc = GeneralDisc::make(scene_, *object.object, at, object.points[p * packet_size + lane]);
    if (!disc || disc->x_begin >= cell_.x + cell_.width || disc->x_end <= cell_.x ||
        disc->y_begin >= cell_.y + cell_.height || disc->y_end <= cell_.y)
      continue;
    general_.push_back(*disc);
    ++counters.general_discs;
  }
  v.general_end = general_.size();
}

namespace {

/// The strip of a pixel of the cell's arrays.
std::uint32_t strip_of(int pixel) {
  return 1u << (pixel / cell_pitch / patch_px * cell_strips + pixel % cell_pitch / strip_px);
}

/// Calls visit(index into the cell's arrays, fragment) for the pixels of the cell that the disc covers.
template <class Visit>
void for_each_fragment(const GeneralDisc& disc, const Cell& cell, const Visit& visit) {
  for (int y = std::max(disc.y_begin, cell.y); y < std::min(disc.y_end, cell.y + cell.height); ++y)
    for (int x = std::max(disc.x_begin, cell.x); x < std::min(disc.x_end, cell.x + cell.width); ++x)
      if (const auto fragment = disc.meet(x, y)) visit((y - cell.y) * cell_pitch + (x - cell.x), *fragment);
}

}  // namespace

/// Than the front surface of that pixel.
bool SampledCell::shows_other_side(const GeneralDisc::Fragment& f, int pixel) const {
  return rule_.sides && f.side * buffers_->side[pixel] < 0.0f;
}

void SampledCell::bring_general_to_front(const GeneralDisc& disc) {
  for_each_fragment(disc, cell_, [&](int i, const GeneralDisc::Fragment& f) {
    buffers_->touched |= strip_of(i);
    const float reached = f.depth + disc.tolerance;
    const bool equal = f.depth == buffers_->front[i];
    if (f.depth < buffers_->front[i] || (equal && rule_.sides && buffers_->side[i] < f.side)) {
      buffers_->front[i] = f.depth;
      buffers_->limit[i] = reached;
      buffers_->side[i] = f.side;
    } else if (equal && (!rule_.sides || buffers_->side[i] == f.side)) {
      buffers_->limit[i] = std::max(buffers_->limit[i], reached);
    }
  });
}

void SampledCell::add_general_to_front(const GeneralDisc& disc) {
  for_each_fragment(disc, cell_, [&](int i, const GeneralDisc::Fragment& f) {
    if (!(f.depth <= buffers_->limit[i]) || shows_other_side(f, i)) return;
    buffers_->weight[i] += f.weight;
    buffers_->red[i] += f.weight * disc.rgba[0];
    buffers_->green[i] += f.weight * disc.rgba[1];
    buffers_->blue[i] += f.weight * disc.rgba[2];
    buffers_->alpha[i] += f.weight * disc.rgba[3];
    buffers_->depth[i] += f.weight * f.depth;
  });
}

void SampledCell::find_general_behind(const GeneralDisc& disc, std::uint32_t index) {
  for_each_fragment(disc, cell_, [&](int i, const GeneralDisc::Fragment& f) {
    const float limit = buffers_->behind[i];
    if (limit < f.depth || (limit < infinity && shows_other_side(f, i)))
      behind_[behind_count_++] = {f.depth, f.weight,
                                  general_flag | index |
                                      (f.side > 0.0f   ? disc_front
                                       : f.side < 0.0f ? disc_back
                                                       : 0u),
                                  static_cast<std::uint32_t>(i)};
  });
}

void SampledCell::add(std::span<const ObjectInstant> instants, const InstantWeights& weights) {
  draw(instants);
  math_.add_instant(*buffers_, weights, background_, *sums_, cell_.height);
  if (++unflushed_ == instants_a_flush) flush();
}

const std::vector<SampledCell::Surface>& SampledCell::surfaces(std::span<const ObjectInstant> instants) {
  surfaces_.clear();
  keeps_surfaces_ = true;
  draw(instants);
  keeps_surfaces_ = false;
  return surfaces_;
}

void SampledCell::draw(std::span<const ObjectInstant> instants) {
  ++counters.instants;
  select(instants);
  counters.packets += visible_.size();
  CellBuffers& cell = *buffers_;
  math_.clear(cell, cell_.height);
  std::size_t since_look = 0;
  for (const std::uint32_t i : nearest_first_) {
    if (since_look == packets_a_look) {
      math_.measure_patches(cell, cell_.height);
      since_look = 0;
    }
    if (hidden(visible_[i])) continue;
    ++since_look;
    place(i, instants);
    const PlacedPacket& placed = placed_[i];
    math_.bring_to_front(placed, placed.seen, cell_.x, cell_.y, cell_.width, cell_.height, rule_, cell);
    for (std::size_t g = visible_[i].general_begin; g < visible_[i].general_end; ++g)
      bring_general_to_front(general_[g]);
  }
  math_.measure_patches(cell, cell_.height);
  for (std::size_t i = 0; i < visible_.size(); ++i) {
    const Visible& v = visible_[i];
    if (!v.placed || hidden(v)) {
      ++counters.packets_hidden;
      continue;
    }
    const PlacedPacket& placed = placed_[i];
    math_.add_to_front(placed, placed.seen, cell_.x, cell_.y, cell_.width, cell_.height, rule_, cell);
    for (std::size_t g = v.general_begin; g < v.general_end; ++g) add_general_to_front(general_[g]);
  }
  const bool leaks = math_.shade_front(rule_, cell, cell_.height);
  if (keeps_surfaces_)
    for (int y = 0; y < cell_.height; ++y)
      for (int x = 0; x < cell_.width; ++x) {
        const int i = y * cell_pitch + x;
        const float alpha = cell.alpha[i];
        if (alpha > 0.0f)
          surfaces_.push_back(
              {x, y, cell.depth[i] / alpha, {cell.red[i], cell.green[i], cell.blue[i], alpha}});
      }
  if (leaks) shade_behind(instants, 0, cell_.height);
}

void SampledCell::flush() {
  if (!flushed_) {
    std::fill(total_.rgba.begin(), total_.rgba.end(), 0.0);
    std::fill(total_.depth.begin(), total_.depth.end(), 0.0);
    flushed_ = true;
  }
  for (int y = 0; y < cell_.height; ++y)
    for (int x = 0; x < cell_.width; ++x) {
      const int from = y * cell_pitch + x;
      const auto to = static_cast<std::size_t>(y * cell_px + x);
      const float* colors[4] = {sums_->red, sums_->green, sums_->blue, sums_->alpha};
      for (std::size_t c = 0; c < 4; ++c) total_.rgba[4 * to + c] += double{colors[c][from]};
      total_.depth[to] += double{sums_->depth[from]};
    }
  for (float* sum : {sums_->red, sums_->green, sums_->blue, sums_->alpha, sums_->depth})
    std::fill(sum, sum + cell_floats, 0.0f);
  unflushed_ = 0;
}

SampledCell::Squares SampledCell::squares() const {
  Squares squares;
  for (int y = 0; y < cell_.height; ++y)
    for (int x = 0; x < cell_.width; ++x) {
      const int i = y * cell_pitch + x;
      const double red = double{sums_->alternating_red[i]}, green = double{sums_->alternating_green[i]},
                   blue = double{sums_->alternating_blue[i]};
      const double even = double{sums_->even[i]}, odd = double{sums_->odd[i]};
      squares.alternating += red * red + green * green + blue * blue;
      squares.grey += (red + green + blue) * (red + green + blue);
      squares.quarter += even * even + odd * odd;
    }
  return squares;
}

void SampledCell::alternating_squares(double scale, std::vector<float>& out) const {
  out.assign(cell_px * cell_px, 0.0f);
  for (int y = 0; y < cell_.height; ++y)
    for (int x = 0; x < cell_.width; ++x) {
      double squares = 0.0;
      for (const float* sum : {sums_->alternating_red, sums_->alternating_green, sums_->alternating_blue})
        squares += double{sum[y * cell_pitch + x]} * double{sum[y * cell_pitch + x]};
      out[static_cast<std::size_t>(y * cell_px + x)] = static_cast<float>(scale * squares);
    }
}

void SampledCell::alternate_from_sums(double weight) {
  flush();
  float* const sums[3] = {sums_->alternating_red, sums_->alternating_green, sums_->alternating_blue};
  for (int y = 0; y < cell_.height; ++y)
    for (int x = 0; x < cell_.width; ++x) {
      const double* rgba = &total_.rgba[4 * static_cast<std::size_t>(y * cell_px + x)];
      for (std::size_t c = 0; c < 3; ++c)
        sums[c][y * cell_pitch + x] =
            static_cast<float>(rgba[c] + (weight - rgba[3]) * double{background_[c]});
    }
}

void SampledCell::image(double total, CellImage& out) {
  flush();
  out.rgba.resize(total_.rgba.size());
  out.depth.resize(total_.depth.size());
  for (std::size_t i = 0; i < total_.rgba.size(); ++i) out.rgba[i] = total_.rgba[i] / total;
  for (std::size_t i = 0; i < total_.depth.size(); ++i) out.depth[i] = total_.depth[i] / total;
}

}  // namespace swept
