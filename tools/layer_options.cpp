#include "tools/layer_options.h"

#include <algorithm>
#include <iterator>
#include <utility>

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
          "coverage; all "
          "of the nearest surface in the middle of the exposure; samples: instants that were averaged; "
          "error: the "
          "root mean square error that is expected (both: sampled)")
      ->delimiter(',')
      ->type_name("normal,motion,coverage,samples,error")
      ->check(CLI::IsMember({"normal", "motion", "coverage", "samples", "error"}).name(""));
  return options;
}

void add_layers(const LayerOptions& options, std::vector<PixelLayer> layers, Rendered& rendered) {
  rendered.image.channels = std::move(layers);
  for (PixelLayer& layer : rendered.layers) {
    const bool samples = layer.name == "instants";
    if (samples) layer.name = "samples";
    if (samples ? options.samples : layer.name == "error" && options.error)
      rendered.image.channels.push_back(std::move(layer));
  }
}

}  // namespace swept
