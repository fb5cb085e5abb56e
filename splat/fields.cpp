#include "splat/fields.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <type_traits>
#include <utility>

namespace swept {
namespace {

constexpr double most_side_px = 65536.0;

template <auto... Members>
auto& member_of(auto& scene) {
  return (scene.*....*Members);
}

/// A member reached from Scene by these.
template <auto... Members>
FieldNumber number(std::string_view name, double low, double high, bool above_low = false) {
  using Value = std::remove_cvref_t<decltype(member_of<Members...>(std::declval<Scene&>()))>;
  return {name,
          low,
          high,
          above_low,
          std::is_integral_v<Value> || std::is_enum_v<Value>,
          [](const Scene& scene) { return static_cast<double>(member_of<Members...>(scene)); },
          [](Scene& scene, double value) {
            // An enum by way of int: no conversion goes from double to it.
            if constexpr (std::is_enum_v<Value>)
              member_of<Members...>(scene) = static_cast<Value>(static_cast<int>(value));
            else
              member_of<Members...>(scene) = static_cast<Value>(value);
          }};
}

template <Eigen::Index I>
FieldNumber background(std::string_view name, double low, double high) {
  return {name,
          low,
          high,
          false,
          false,
          [](const Scene& scene) { return static_cast<double>(scene.background[I]); },
          [](Scene& scene, double value) { scene.background[I] = static_cast<float>(value); }};
}

template <std::size_t I>
FieldNumber shutter_rate() {
  return {"RATE",
          0.0,
          1e9,
          false,
          false,
          [](const Scene& scene) { return scene.shutter.rates[I]; },
          [](Scene& scene, double value) { scene.shutter.rates[I] = value; }};
}

template <std::size_t... I>
std::vector<FieldNumber> shutter_rates(std::index_sequence<I...>) {
  return {shutter_rate<I>()...};
}

constexpr std::size_t most_rates = 64;

std::vector<Field> make_fields() {
  using S = Scene;
  using M = ImageModel;
  using G = SplatModel;
  constexpr double most_fps = 1e9, most_segments = max_segments, light = most_color;
  return {
      {.pointer = "/film/width",
       .option = "--size",
       .separator = 'x',
       .unit = "px",
       .help = "the film's width",
       .numbers = {number<&S::film, &Film::width>("WIDTH", 1, most_side_px)},
       .with_object = true},
      {.pointer = "/film/height",
       .option = "--size",
       .separator = 'x',
       .unit = "px",
       .help = "the film's height",
       .numbers = {number<&S::film, &Film::height>("HEIGHT", 1, most_side_px)},
       .with_object = true},
      {.pointer = "/film/crop",
       .option = "--crop",
       .unit = "px",
       .help = "the window of the film to compute, from the top left",
       .numbers = {number<&S::film, &Film::crop_x>("X", 0, most_side_px),
                   number<&S::film, &Film::crop_y>("Y", 0, most_side_px),
                   number<&S::film, &Film::crop_width>("WIDTH", 1, most_side_px),
                   number<&S::film, &Film::crop_height>("HEIGHT", 1, most_side_px)},
       .least = 4,
       .if_zero = "the whole film"},
      {.pointer = "/film/overscan",
       .option = "--overscan",
       .unit = "px",
       .help = "pixels that are computed beyond the film's edges",
       .numbers = {number<&S::film, &Film::overscan_left>("LEFT", 0, most_side_px),
                   number<&S::film, &Film::overscan_top>("TOP", 0, most_side_px),
                   number<&S::film, &Film::overscan_right>("RIGHT", 0, most_side_px),
                   number<&S::film, &Film::overscan_bottom>("BOTTOM", 0, most_side_px)},
       .least = 4,
       .if_zero = "none"},
      {.pointer = "/fps",
       .option = "--fps",
       .separator = '/',
       .help = "frames per second, as one whole number or as a fraction of two",
       .numbers = {number<&S::fps, &FrameRate::numerator>("FPS", 1, most_fps),
                   number<&S::fps, &FrameRate::denominator>("DIVISOR", 1, most_fps)}},
      {.pointer = "/shutter/open",
       .option = "--shutter",
       .unit = "frames",
       .help = "when the shutter opens, relative to the frame",
       .numbers = {number<&S::shutter, &Shutter::open>("OPEN", -most_frame, most_frame)},
       .with_object = true},
      {.pointer = "/shutter/close",
       .option = "--shutter",
       .unit = "frames",
       .help = "when it closes; as it opens: a still image. 180° is half a frame",
       .numbers = {number<&S::shutter, &Shutter::close>("CLOSE", -most_frame, most_frame)},
       .with_object = true},
      {.pointer = "/shutter/curve",
       .option = "--shutter-curve",
       .help = "how the light comes in while the shutter is open: evenly, with ramps, as a Gaussian, or as "
               "the rates say",
       .numbers = {number<&S::shutter, &Shutter::curve>("", 0, 3)},
       .words = {"box", "trapezoid", "gaussian", "table"}},
      {.pointer = "/shutter/opening",
       .option = "--shutter-ramps",
       .help = "share of the exposure in which a trapezoid opens",
       .numbers = {number<&S::shutter, &Shutter::opening>("OPENING", 0, 1)}},
      {.pointer = "/shutter/closing",
       .option = "--shutter-ramps",
       .help = "and in which it closes",
       .numbers = {number<&S::shutter, &Shutter::closing>("CLOSING", 0, 1)}},
      {.pointer = "/shutter/delta",
       .option = "--shutter-delta",
       .help = "sharpness δ of the Gaussian exp(−δ(2τ − 1)²), τ from 0 to 1",
       .numbers = {number<&S::shutter, &Shutter::delta>("DELTA", 0, 50, true)}},
      {.pointer = "/shutter/rates",
       .option = "--shutter-rates",
       .help = "light at so many evenly spaced times of the exposure, 2 to 64, with lines between",
       .numbers = shutter_rates(std::make_index_sequence<most_rates>()),
       .least = 2,
       .count = [](const Scene& scene) { return scene.shutter.rates.size(); },
       .resize = [](Scene& scene, std::size_t count) { scene.shutter.rates.resize(count); },
       .if_zero = "none"},
      {.pointer = "/shutter/row_delay",
       .option = "--row-delay",
       .unit = "frames",
       .help = "rolling shutter: by how much each row of the film is exposed later than the one above it",
       .numbers = {number<&S::shutter, &Shutter::row_delay>("FRAMES", -1, 1)}},
      {.pointer = "/motion/path",
       .option = "--path",
       .help = "how the points of keyed files move from key to key: straight, or along a spline",
       .numbers = {number<&S::motion, &MotionModel::path>("", 0, 1)},
       .words = {"linear", "spline"}},
      {.pointer = "/motion/tolerance_px",
       .option = "--motion-tolerance",
       .unit = "px",
       .help = "how far chords may be from a point's path where paths are cut, point by point",
       .numbers = {number<&S::motion, &MotionModel::tolerance_px>("PX", 0, 100, true)},
       .if_zero =
           "0.1 px where the paths of points curve, and elsewhere all points of an object are cut alike"},
      {.pointer = "/background",
       .option = "--background",
       .help = "what is behind everything: linear, premultiplied RGBA; three numbers are opaque",
       .numbers = {background<0>("R", -light, light), background<1>("G", -light, light),
                   background<2>("B", -light, light), background<3>("ALPHA", 0, 1)},
       .least = 3},
      {.pointer = "/image/delta",
       .option = "--delta",
       .help = "sharpness δ of the kernel exp(−δ r²), r = 1 at a disc's rim",
       .numbers = {number<&S::model, &M::delta>("DELTA", 0, 50, true)}},
      {.pointer = "/image/filter_radius_px",
       .option = "--filter-radius",
       .unit = "px",
       .help = "the pixel filter's radius at its cut-off; 0: none",
       .numbers = {number<&S::model, &M::filter_radius_px>("RADIUS", 0, 100)}},
      {.pointer = "/image/coverage",
       .option = "--coverage",
       .help = "antialiased silhouettes, or a pixel is covered or not",
       .numbers = {number<&S::model, &M::coverage>("", 0, 1)},
       .words = {"soft", "hard"}},
      {.pointer = "/image/edge_weight",
       .option = "--edge-weight",
       .help = "sum of the kernels at which soft coverage is full",
       .numbers = {number<&S::model, &M::edge_weight>("WEIGHT", 0, 1, true)}},
      {.pointer = "/image/depth_tolerance",
       .option = "--depth-tolerance",
       .unit = "radii",
       .help = "how far apart in depth discs may be and still be one surface",
       .numbers = {number<&S::model, &M::depth_tolerance>("TOLERANCE", 0, 100)}},
      {.pointer = "/image/segments",
       .option = "--segments",
       .help = "linear pieces that a path over the shutter is cut into",
       .numbers = {number<&S::model, &M::segments>("COUNT", 1, most_segments)},
       .if_zero = "as many, up to 64, as keep the chords of every path within 0.1 px of it"},
      {.pointer = "/splats/dilation_px2",
       .option = "--splat-dilation",
       .unit = "px²",
       .help = "what Gaussian splats' variances grow by on the film",
       .numbers = {number<&S::splats, &G::dilation_px2>("VARIANCE", 0, 100)}},
      {.pointer = "/splats/least_alpha",
       .option = "--splat-least-alpha",
       .help = "where a splat covers less of a pixel it is left out",
       .numbers = {number<&S::splats, &G::least_alpha>("ALPHA", 1e-6, 1)}},
      {.pointer = "/splats/most_alpha",
       .option = "--splat-most-alpha",
       .help = "most that a splat covers of a pixel",
       .numbers = {number<&S::splats, &G::most_alpha>("ALPHA", 0, 1, true)}},
      {.pointer = "/splats/least_light",
       .option = "--splat-least-light",
       .help = "share of light below which splats end: one that would let less through is not drawn, nor any "
               "behind it",
       .numbers = {number<&S::splats, &G::least_light>("SHARE", 0, 1)}},
      {.pointer = "/splats/near",
       .option = "--splat-near",
       .unit = "world units",
       .help = "splats whose centres are no farther away are left out",
       .numbers = {number<&S::splats, &G::near>("DISTANCE", 0, 1e9, true)}},
      {.pointer = "/splats/blending",
       .option = "--splat-blending",
       .help = "in what values splats are blended: as their file says, in those of sRGB as nearly all are "
               "trained, or in linear light",
       .numbers = {number<&S::splats, &G::blending>("", 0, 2)},
       .words = {"file", "srgb", "linear"}},
      {.pointer = "/splats/clip_frames",
       .option = "--clip-frames",
       .unit = "frames",
       .help =
           "how long the clip was of which splats were trained in motion, as those of SpacetimeGaussians; "
           "it begins at its file's frame",
       .numbers = {number<&S::splats, &G::clip_frames>("FRAMES", 0, 1e9, true)}},
  };
}

/// "1e9" rather than 1000000000, and without what a float's limit is off by.
std::string limit_text(double limit) {
  if (std::abs(limit) < 1e6) return shortest_text(limit);
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.6g", limit);
  std::string text = digits;
  text.erase(std::min(text.find('+'), text.size() - 1), 1);
  const std::size_t zero = text.find("e0");
  return zero == std::string::npos ? text : text.erase(zero + 1, 1);
}

std::string list_text(std::span<const std::string_view> words) {
  std::string list;
  for (const std::string_view word : words) (list += list.empty() ? "" : " or ") += word;
  return list;
}

Status validate_crop(const Film& film) {
  if (film.crop_width == 0 && film.crop_height == 0 && film.crop_x == 0 && film.crop_y == 0) return Done{};
  // Differences, not sums, which could overflow.
  if (film.crop_x > film.width - film.crop_width || film.crop_y > film.height - film.crop_height)
    return Error{"", "/film/crop", "the crop must be a window of at least one pixel inside the film"};
  return Done{};
}

/// Beyond an edge there is no crop, and no more than a film can have.
Status validate_overscan(const Film& film) {
  if (film.crop_width > 0) return Error{"", "/film/overscan", "goes without a crop"};
  if (film.window_width() > most_side_px || film.window_height() > most_side_px)
    return Error{"", "/film/overscan", "film and overscan may have 65536 px along each side"};
  return Done{};
}

}  // namespace

std::string_view Field::group() const {
  const std::size_t slash = pointer.rfind('/');
  return slash == 0 ? std::string_view() : pointer.substr(1, slash - 1);
}

std::string_view Field::name() const { return pointer.substr(pointer.rfind('/') + 1); }

std::vector<double> Field::get(const Scene& scene) const {
  std::vector<double> values;
  const std::size_t present = count != nullptr ? std::min(count(scene), numbers.size()) : numbers.size();
  for (std::size_t i = 0; i < present; ++i) values.push_back(numbers[i].get(scene));
  return values;
}

void Field::set(Scene& scene, std::span<const double> values) const {
  if (resize != nullptr) resize(scene, values.size());
  const std::size_t wanted = resize != nullptr ? values.size() : numbers.size();
  for (std::size_t i = 0; i < wanted; ++i) numbers[i].set(scene, i < values.size() ? values[i] : 1.0);
}

bool Field::unset(std::span<const double> values) const {
  return !if_zero.empty() && std::all_of(values.begin(), values.end(), [](double v) { return v == 0.0; });
}

Status Field::legal(std::span<const double> values) const {
  if (values.size() < least || values.size() > numbers.size())
    return Error{"", std::string(pointer),
                 "expected " + (least < numbers.size() ? std::to_string(least) + " to " : std::string()) +
                     std::to_string(numbers.size()) + " numbers, found " + std::to_string(values.size())};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const FieldNumber& number = numbers[i];
    std::string at(pointer), subject;
    if (numbers.size() > 1) {
      at += '/' + std::to_string(i);
      subject = "the ";
      for (const char c : number.name)
        subject += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      subject += ' ';
    }
    if (!std::isfinite(values[i])) return Error{"", at, subject + "must be a finite number"};
    if (number.whole && values[i] != std::floor(values[i]))
      return Error{"", at,
                   pointer == "/fps" ? "expected a whole number, or a fraction such as 24000/1001"
                                     : "expected a whole number"};
    const bool inside = number.above_low ? values[i] > number.low : values[i] >= number.low;
    if (!inside || values[i] > number.high) return Error{"", at, subject + "must be " + range_text(*this, i)};
  }
  return Done{};
}

const std::vector<Field>& scene_fields() {
  static const std::vector<Field> fields = make_fields();
  return fields;
}

const Field* find_field(std::string_view pointer) {
  const std::vector<Field>& fields = scene_fields();
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const Field& field) { return field.pointer == pointer; });
  return found == fields.end() ? nullptr : &*found;
}

Status validate_fields(const Scene& scene, std::string_view group) {
  for (const Field& field : scene_fields()) {
    if (!field.pointer.starts_with(group)) continue;
    const std::vector<double> values = field.get(scene);
    if (field.unset(values)) continue;
    if (Status status = field.legal(values); !status) return status;
    if (field.pointer == "/film/crop")
      if (Status status = validate_crop(scene.film); !status) return status;
    if (field.pointer == "/film/overscan")
      if (Status status = validate_overscan(scene.film); !status) return status;
    if (field.pointer == "/shutter/closing" && scene.shutter.curve == ShutterShape::trapezoid &&
        scene.shutter.opening + scene.shutter.closing > 1.0)
      return Error{"", "/shutter/closing", "the ramps take more than the whole exposure"};
    if (field.pointer == "/shutter/close" && scene.shutter.close < scene.shutter.open)
      return Error{"", "/shutter", "the shutter closes before it opens"};
  }
  const Shutter& shutter = scene.shutter;
  const auto lit = [](double rate) { return rate > 0.0; };
  if (std::string_view("/shutter/rates").starts_with(group) && shutter.curve == ShutterShape::table &&
      (shutter.rates.size() < 2 || std::none_of(shutter.rates.begin(), shutter.rates.end(), lit)))
    return Error{"", "/shutter/rates", "a table needs two rates or more, and one of them above 0"};
  return Done{};
}

std::string range_text(const Field& field, std::size_t i) {
  if (!field.words.empty()) return list_text(field.words);
  const FieldNumber& number = field.numbers[i];
  const std::string unit = field.unit.empty() ? "" : ' ' + std::string(field.unit);
  if (number.above_low)
    return "above " + limit_text(number.low) + " and at most " + limit_text(number.high) + unit;
  return "between " + limit_text(number.low) + " and " + limit_text(number.high) + unit;
}

std::string value_text(const Field& field, std::span<const double> values) {
  if (!field.words.empty()) return std::string(field.words[static_cast<std::size_t>(values[0])]);
  std::string text;
  for (const double value : values) (text += text.empty() ? "" : ", ") += shortest_text(value);
  return field.numbers.size() == 1 ? text : '[' + text + ']';
}

std::string shortest_text(double value) {
  // Counts in full: 1000000000, not 1e+09.
  constexpr double exact = 9007199254740992.0;
  if (value == std::floor(value) && std::abs(value) <= exact)
    return std::to_string(static_cast<long long>(value));
  char digits[32];
  const auto end = std::to_chars(std::begin(digits), std::end(digits), value).ptr;
  return {digits, end};
}

}  // namespace swept
