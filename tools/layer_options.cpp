#include "tools/layer_options.h"

#include <algorithm>
#include <iterator>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

namespace swept {
namespace {

struct Name {
  const char* name;
  bool& (*member)(LayerOptions&);
};
constexpr Name names[] = {{"normal", [](LayerOptions& o) -> bool& { return o.choice.normal; }},
                          {"motion", [](LayerOptions& o) -> bool& { return o.choice.motion; }},
                          {"coverage", [](LayerOptions& o) -> bool& { return o.choice.coverage; }},
                          {"samples", [](LayerOptions& o) -> bool& { return o.samples; }},
                          {"error", [](LayerOptions& o) -> bool& { return o.error; }}};

}  // namespace

std::string LayerOptions::text() const {
  LayerOptions own = *this;
  std::string text;
  for (const Name& name : names)
    if (name.member(own)) text += (text.empty() ? ", layers " : " ") + std::string(name.name);
  return text;
}

std::shared_ptr<const LayerOptions> add_layer_options(CLI::App& command) {
  auto options = std::make_shared<LayerOptions>();
  const auto set = [options](const std::vector<std::string>& wanted) {
    for (const std::string& word : wanted)
      std::find_if(std::begin(names), std::end(names), [&](const Name& n) {
        return word == n.name;
      })->member(*options) = true;
  };
  command
      .add_option_function<std::vector<std::string>>(
          "--layers", set,
          "Write these too: normal.x, .y, .z; motion as forward.u, .v and backward.u, .v, px per frame; "
          "coverage; all of the nearest surface in the middle of the exposure; samples: instants that were "
          "averaged (sampled); error: the expected one of each pixel (sampled)")
      ->delimiter(',')
      ->type_name("normal,motion,coverage,samples,error")
      ->check(CLI::IsMember({"normal", "motion", "coverage", "samples", "error"}).name(""));
  return options;
}

namespace {

ImageChannel samples_channel(const Rendered& rendered) {
  const Image& image = rendered.image;
  ImageChannel channel{"samples", std::vector<float>(image.pixel_count())};
  for (const FilmPart& part : rendered.parts)
    for (int y = std::max(part.y, image.y); y < std::min(part.y + part.height, image.y + image.height); ++y)
      for (int x = std::max(part.x, image.x); x < std::min(part.x + part.width, image.x + image.width); ++x)
        channel.values[static_cast<std::size_t>(y - image.y) * static_cast<std::size_t>(image.width) +
                       static_cast<std::size_t>(x - image.x)] = static_cast<float>(part.instants);
  return channel;
}

}  // namespace

void add_layers(const LayerOptions& options, std::vector<ImageChannel> layers, Rendered& rendered) {
  std::vector<ImageChannel>& channels = rendered.image.channels;
  channels.insert(channels.begin(), std::make_move_iterator(layers.begin()),
                  std::make_move_iterator(layers.end()));
  if (options.samples) channels.push_back(samples_channel(rendered));
}

}  // namespace swept
