// Tiles or parts of the exposure, whichever promises to find samples in less time.
#pragma once

#include "abuffer/stochastic/primitives.h"
#include "abuffer/stochastic/stochastic.h"

namespace swept::stochastic {

/// What a traversal takes by a model of its steps, µs a primitive. The processor is an x86 of 2025; of
/// another one all may be another number, which changes the quotient little.
struct TraversalForecast {
  double tile = 0.0, interval = 0.0;
  [[nodiscard]] bool by_intervals() const { return interval < tile; }
};

/// From some hundred primitives of those that may be seen in the window, the same for any thread count.
[[nodiscard]] TraversalForecast forecast_traversals(const Primitives& primitives, const PixelRange& window,
                                                    const StochasticOptions& options,
                                                    const SampleSource& source);

}  // namespace swept::stochastic
