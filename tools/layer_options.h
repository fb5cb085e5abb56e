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
  bool error = false;    ///< how far each pixel is expected to be off

  [[nodiscard]] bool any() const { return samples || error || choice.any(); }
  /// ", layers normal motion", for what tells pictures apart; empty: none.
  [[nodiscard]] std::string text() const;
};

/// --layers.
[[nodiscard]] std::shared_ptr<const LayerOptions> add_layer_options(CLI::App& command);

/// Puts `layers` before the channels that the image has, and "samples", from what its renderer tells, behind.
void add_layers(const LayerOptions& options, std::vector<ImageChannel> layers, Rendered& rendered);

}  // namespace swept
