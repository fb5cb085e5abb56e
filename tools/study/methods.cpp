#include "tools/study/methods.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <fmt/core.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "abuffer/stochastic/stochastic.h"
#include "tools/gpu_method.h"
#include "tools/study/raycast.h"

namespace swept {
namespace {

using Renderer = std::function<Result<Rendered>(const Scene&)>;

constexpr const char* reference_id = "reference";

RenderControl control_of(const MethodOptions& options) {
  RenderControl control;
  control.threads = options.threads;
  return control;
}

Renderer abuffer(Normalisation normalisation, const MethodOptions& options) {
  AbufferOptions abuffer;
  abuffer.normalisation = normalisation;
  return [abuffer, control = control_of(options)](const Scene& scene) {
    return render_abuffer(scene, abuffer, control);
  };
}

Renderer gpu(bool still_frames, int subframes, const MethodOptions& options) {
  GpuChoice choice;
  choice.still_frames = still_frames;
  choice.subframes = subframes;
  choice.device = options.gpu;
  const std::shared_ptr<FrameRenderer> frames = gpu_frames(choice);
  return [frames](const Scene& scene) -> Result<Rendered> {
    if (const Status submitted = frames->submit(scene); !submitted) return submitted.error();
    return frames->collect();
  };
}

}  // namespace

const std::vector<StudyMethod>& study_methods() {
  static const std::vector<StudyMethod> methods = {
      {"abuffer",
       "Exact A-buffer",
       "Every fragment resolved over time and depth; as many linear segments as keep points within 0.1 px.",
       "",
       "",
       {0},
       {0}},
      {"abuffer-segments",
       "A-buffer, segments given",
       "The same with the motion cut into this many linear segments, whatever that costs in accuracy.",
       "segment",
       "segments",
       {1, 2, 4, 8, 16, 32},
       {1, 4, 16}},
      {"abuffer-pixel",
       "A-buffer, normalised per pixel",
       "The same with one normalisation for the whole exposure of a pixel, as in Heinzle et al. 2010.",
       "",
       "",
       {0},
       {0}},
      {"gpu",
       "Six GPU passes",
       "Heinzle et al. 2010, section 5, with the exposure in this many sub-frames.",
       "sub-frame",
       "sub-frames",
       {1, 2, 4, 8, 16, 32},
       {1, 4, 16}},
      {"gpu-still",
       "Still frames averaged, GPU",
       "Temporal supersampling with the same shaders in the same context.",
       "still",
       "stills",
       {4, 8, 16, 32, 64, 128},
       {4, 16}},
      {"sampled",
       "Sampled engine, instants given",
       "The mean of still images at this many instants, a cell of the film at a time.",
       "instant",
       "instants",
       {4, 8, 16, 32, 64, 128},
       {4, 16, 64}},
      {"sampled-error",
       "Sampled engine, error given",
       "The same with as many instants in each cell as an error of this many dB is expected to take.",
       "dB",
       "dB",
       {45, 60, 75},
       {45, 60, 75}},
      {"stochastic",
       "Stochastic sampling",
       "Samples at random times within strata of the exposure, discs through the pixel's centre, tile by "
       "tile.",
       "sample per pixel",
       "samples per pixel",
       {4, 16, 64, 256},
       {4, 16}},
      {"raycast",
       "Stochastic ray casting",
       "Rays at random times within strata of the exposure, through the same discs, by Embree.",
       "sample per pixel",
       "samples per pixel",
       {4, 16, 64, 256},
       {4, 16}}};
  return methods;
}

const StudyMethod* find_study_method(const std::string& id) {
  const auto& methods = study_methods();
  const auto found =
      std::find_if(methods.begin(), methods.end(), [&](const StudyMethod& m) { return m.id == id; });
  return found == methods.end() ? nullptr : &*found;
}

std::string setting_id(const Setting& setting) {
  return setting.value > 0 ? fmt::format("{}-{}", setting.method, setting.value) : setting.method;
}

std::string setting_text(const Setting& setting) {
  const StudyMethod* method = find_study_method(setting.method);
  if (setting.value == 0 || method == nullptr) return "";
  return fmt::format("{} {}", setting.value, setting.value == 1 ? method->unit : method->unit_plural);
}

Setting reference_setting(int samples) { return {reference_id, samples}; }

void apply_to_scene(const Setting& setting, Scene& scene) {
  if (setting.method != "abuffer-segments") return;
  scene.model.segments = setting.value;
  for (Object& object : scene.objects) object.segments = 0;
}

Result<Renderer> renderer_of(const Setting& setting, const MethodOptions& options) {
  const int value = setting.value;
  if (setting.method == reference_id) {
    ReferenceOptions reference;
    reference.samples = value;
    reference.motion = ReferenceMotion::smooth;
    return Renderer([reference, control = control_of(options)](const Scene& scene) {
      return render_reference(scene, reference, control);
    });
  }
  if (setting.method == "abuffer") return abuffer(Normalisation::interval, options);
  if (setting.method == "abuffer-segments") return abuffer(Normalisation::interval, options);
  if (setting.method == "abuffer-pixel") return abuffer(Normalisation::pixel, options);
  if (setting.method == "gpu") return gpu(false, value, options);
  if (setting.method == "gpu-still") return gpu(true, value, options);
  if (setting.method == "sampled" || setting.method == "sampled-error") {
    SampledOptions sampled;
    if (setting.method == "sampled")
      sampled.samples = value;
    else
      sampled.max_error_db = value;
    return Renderer([sampled, control = control_of(options)](const Scene& scene) {
      return render_sampled(scene, sampled, control);
    });
  }
  if (setting.method == "stochastic") {
    StochasticOptions stochastic;
    stochastic.samples = value;
    return Renderer([stochastic, control = control_of(options)](const Scene& scene) {
      return render_stochastic(scene, stochastic, control);
    });
  }
  if (setting.method == "raycast") {
    RaycastOptions rays;
    rays.samples = value;
    rays.threads = options.threads;
    return Renderer([=](const Scene& scene) { return render_raycast(scene, rays); });
  }
  return Error{"", setting.method, "there is no such method"};
}

}  // namespace swept
