// Pictures of a scene as tests ask for them. An error is thrown, and fails the test.
#pragma once

#include <stdexcept>
#include <utility>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/reference/splat_reference.h"
#include "abuffer/sampled.h"

namespace swept::test {

template <class T>
T value_of(Result<T> result) {
  if (!result.ok()) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

/// The mean of so many instants.
inline Rendered rendered(const Scene& scene, int samples, int implementation = -1, int threads = 0) {
  SampledOptions options;
  options.samples = samples;
  options.implementation = implementation;
  RenderControl control;
  control.threads = threads;
  return value_of(render_sampled(scene, options, control));
}
inline Image sampled(const Scene& scene, int samples, int implementation = -1) {
  return rendered(scene, samples, implementation).image;
}

inline Rendered exact(const Scene& scene, const AbufferOptions& options = {}, int threads = 0) {
  RenderControl control;
  control.threads = threads;
  return value_of(render_abuffer(scene, options, control));
}

inline Image reference(const Scene& scene, int samples, ReferenceMotion motion = ReferenceMotion::smooth) {
  return value_of(render_reference(scene, {samples, motion})).image;
}

/// In double, of splats beside all else.
inline Image splat_reference(const Scene& scene, int samples) {
  return value_of(render_splat_reference(scene, {samples, 0})).image;
}

}  // namespace swept::test
