// The channels that an EXR gets besides R, G, B, A and Z.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "abuffer/layers.h"
#include "splat/rendered.h"

namespace swept {

struct LayerOptions {
  LayerChoice choice;
  bool samples = false;  ///< at how many instants each pixel was looked at
  bool error = false;    ///< that is expected

  /// Whether the renderer has to tell what it did.
  [[nodiscard]] bool of_renderer() const { return samples || error; }
  /// ", layers normal motion", for what tells pictures apart; empty: none.
  [[nodiscard]] std::string text() const;
};

/// --layers.
[[nodiscard]] std::shared_ptr<const LayerOptions> add_layer_options(CLI::App& command);

/// Gives the image its channels: `layers`, and what is wanted of those of its renderer.
void add_layers(const LayerOptions& options, std::vector<PixelLayer> layers, Rendered& rendered);

}  // namespace swept
