#include "tools/render_frames.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <future>
#include <limits>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/core.h>

#include "datasets/generators.h"
#include "splat/io/image_file.h"
#include "splat/stopwatch.h"
#include "tools/progress.h"

namespace swept {
namespace {

ImageMetadata metadata_of(const Scene& scene, const std::string& scene_hash, std::string whole_hash,
                          const RunStatistics& run) {
  const double length = scene.shutter.close - scene.shutter.open;
  ImageMetadata metadata;
  metadata.fps_numerator = scene.fps.numerator;
  metadata.fps_denominator = scene.fps.denominator;
  metadata.exposure_seconds = length * scene.fps.denominator / scene.fps.numerator;
  metadata.shutter_open = scene.shutter.open;
  metadata.shutter_close = scene.shutter.close;
  const double middle = scene.frame + scene.shutter.open + 0.5 * length;
  const CameraInstant camera = scene.camera.at(middle);
  metadata.world_to_camera = camera.camera_from_world.matrix();
  metadata.tan_half_fov_y = camera.tan_half_fov_y;
  metadata.lens = camera.lens;
  metadata.orthographic = camera.orthographic;
  metadata.near = scene.camera.near;
  metadata.scene_hash = scene_hash;
  metadata.whole_hash = std::move(whole_hash);
  metadata.method = run.picture;
  metadata.software = run.software;
  return metadata;
}

/// A frame that was submitted, with all that is needed of its scene to write it.
struct PendingFrame {
  const FrameOutput* output = nullptr;
  ImageMetadata metadata;
  FrameStatistics* statistics = nullptr;
  std::vector<ImageChannel> layers;
  bool holds_something = false;  ///< and is no part of the film, which may well show nothing
};

bool holds_something(const Scene& scene) {
  return scene.film.crop_width == 0 &&
         std::any_of(scene.objects.begin(), scene.objects.end(), [](const Object& object) {
           return object.cloud.size() > 0 || object.splats.size() > 0;
         });
}

bool shows_nothing(const Image& image) {
  return std::all_of(image.depth.begin(), image.depth.end(),
                     [](float depth) { return depth == std::numeric_limits<float>::infinity(); });
}

/// Whether a half float would be infinite.
bool exceeds_halves(const Image& image) {
  constexpr float rounded_up = 65520.0f;
  return std::any_of(image.rgba.begin(), image.rgba.end(),
                     [](float value) { return std::abs(value) >= rounded_up; });
}

class FrameLoop {
 public:
  FrameLoop(SceneFile& file, FrameRenderer& renderer, RunStatistics& run, Progress& progress,
            const FrameRemarks& remarks)
      : file_(file), renderer_(renderer), run_(run), progress_(progress), remarks_(remarks) {}

  /// `next` is the frame to be submitted after this one, to be loaded meanwhile; null: none.
  Status submit(const FrameOutput& output, const FrameOutput* next, FrameStatistics& statistics) {
    progress_.begin_frame(output.frame);
    Stopwatch watch;
    if (ahead_.valid()) ahead_.get();
    file_.generate_ahead(output.frame, generate, run_.layer_control.threads);
    const Result<const Scene*> scene = file_.scene_at(output.frame, generate);
    if (!scene) return of_frame(output, scene.error());
    Result<std::string> hash = file_.hash(output.frame);
    if (!hash) return of_frame(output, hash.error());
    statistics.scene_hash = std::move(*hash);
    std::string whole_hash;
    if ((*scene)->film.crop_width > 0) {
      Result<std::string> whole = file_.whole_hash(output.frame);
      if (!whole) return of_frame(output, whole.error());
      whole_hash = std::move(*whole);
    }
    statistics.load_seconds = watch.lap();
    statistics.notes = file_.notes();
    if (remarks_) tell(remarks_(**scene), statistics.notes);
    statistics.plan = effect_plan(**scene);
    if (next != nullptr) load_ahead(next->frame);
    if (Status status = renderer_.submit(**scene); !status) return of_frame(output, status.error());
    Result<std::vector<ImageChannel>> layers = render_layers(**scene, run_.layers.choice, run_.layer_control);
    if (!layers) return of_frame(output, layers.error());
    statistics.render_seconds = watch.lap();
    pending_.push_back({&output, metadata_of(**scene, statistics.scene_hash, std::move(whole_hash), run_),
                        &statistics, std::move(*layers), holds_something(**scene)});
    return Done{};
  }

  /// Writes the oldest frames until `most` are left.
  Status finish_all_but(std::size_t most) {
    while (pending_.size() > most) {
      PendingFrame frame = std::move(pending_.front());
      pending_.pop_front();
      if (Status status = finish(frame); !status) return of_frame(*frame.output, status.error());
    }
    return Done{};
  }

 private:
  /// Now, and not when the frame is done: whoever waits for it may want to give other options.
  void tell(std::vector<std::string> remarks, std::vector<std::string>& notes) {
    for (std::string& remark : remarks) {
      if (told_.insert(remark).second) progress_.note("note: " + remark);
      notes.push_back(std::move(remark));
    }
  }

  /// What the hash reads, too: all of the files.
  void load_ahead(double frame) {
    try {
      ahead_ = std::async(std::launch::async, [this, frame] {
        file_.load_ahead(frame, generate);
        static_cast<void>(file_.hash(frame));
      });
    } catch (const std::system_error&) {  // no thread to be had: it is loaded when its turn comes
    }
  }

  Status finish(PendingFrame& frame) {
    FrameStatistics& statistics = *frame.statistics;
    const FrameOutput& output = *frame.output;
    Stopwatch watch;
    Result<Rendered> rendered = renderer_.collect();
    if (!rendered) return rendered.error();
    statistics.render_seconds += watch.lap();
    statistics.statistics = std::move(rendered->statistics);
    if (!output.deep.empty() && !rendered->deep)
      return Error{output.deep, "--deep", "this method tells nothing by depth", ErrorKind::unsupported};
    add_layers(run_.layers, std::move(frame.layers), *rendered);
    // The image last: whoever finds it finds the frame done.
    if (!output.preview.empty())
      if (Status written = write_png(output.preview, rendered->image, output.preview_exists); !written)
        return written;
    if (!output.deep.empty())
      if (Status written =
              write_deep_exr(output.deep, *rendered->deep, frame.metadata, run_.pixels, output.deep_exists);
          !written)
        return written;
    if (Status written =
            write_exr(output.image, rendered->image, frame.metadata, run_.pixels, output.image_exists);
        !written)
      return written;
    statistics.write_seconds = watch.lap();
    if (frame.holds_something && shows_nothing(rendered->image) && !told_of_nothing_) {
      told_of_nothing_ = true;
      progress_.note(fmt::format(
          "note: frame {} shows nothing: all is behind the camera, beside the film, or too small or faint",
          output.frame));
    }
    if (run_.pixels == ExrPixels::float16 && exceeds_halves(rendered->image) && !told_of_halves_) {
      told_of_halves_ = true;
      progress_.note(fmt::format("note: frame {} has colours above 65504, which --half writes as infinite",
                                 output.frame));
    }
    for (const std::string& note : statistics.notes)
      if (told_.insert(note).second) progress_.note("note: " + note);
    progress_.end_frame(output.frame,
                        statistics.load_seconds + statistics.render_seconds + statistics.write_seconds,
                        output.image);
    return Done{};
  }

  Error of_frame(const FrameOutput& output, Error error) const {
    if (error.file.empty()) error.file = file_.path();
    error.reason += fmt::format(" (frame {})", output.frame);
    return error;
  }

  SceneFile& file_;
  FrameRenderer& renderer_;
  RunStatistics& run_;
  Progress& progress_;
  const FrameRemarks& remarks_;
  std::deque<PendingFrame> pending_;
  std::set<std::string> told_;
  bool told_of_nothing_ = false, told_of_halves_ = false;
  std::future<void> ahead_;  ///< last, so that it ends before anything else goes
};

/// What the frames are expected to be off by, where their renderer says so.
std::string expectation(const std::vector<FrameStatistics>& frames) {
  double worst = std::numeric_limits<double>::infinity();
  for (const FrameStatistics& frame : frames)
    worst = std::min(worst, frame.statistics.counter("expected_psnr_db").value_or(worst));
  if (!(worst < std::numeric_limits<double>::infinity())) return "";
  return fmt::format(", {:.1f} dB expected{}", worst, frames.size() > 1 ? " of the worst" : "");
}

}  // namespace

Status render_frames(SceneFile& file, const std::vector<FrameOutput>& outputs, FrameRenderer& renderer,
                     RunStatistics& run, bool ahead, const FrameRemarks& remarks) {
  Progress progress(outputs.size());
  renderer.on_progress([&progress](double share) { progress.within_frame(share); });
  FrameLoop loop(file, renderer, run, progress, remarks);
  std::vector<FrameStatistics> frames(outputs.size());
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const FrameOutput& output = outputs[i];
    frames[i].frame = output.frame;
    frames[i].output = output.image;
    frames[i].skipped = output.skip;
    if (output.skip) {
      progress.skip_frame(output.frame, output.image);
      continue;
    }
    const auto next = std::find_if(outputs.begin() + static_cast<std::ptrdiff_t>(i) + 1, outputs.end(),
                                   [](const FrameOutput& later) { return !later.skip; });
    const Status submitted =
        loop.submit(output, ahead && next != outputs.end() ? &*next : nullptr, frames[i]);
    // Frames before one that failed are as good as ever.
    if (Status finished = loop.finish_all_but(submitted ? renderer.most_pending() - 1 : 0); !finished)
      return finished;
    if (!submitted) return submitted;
  }
  if (Status finished = loop.finish_all_but(0); !finished) return finished;
  renderer.on_progress({});
  progress.finish(expectation(frames));
  for (FrameStatistics& frame : frames) run.frames.push_back(std::move(frame));
  return Done{};
}

}  // namespace swept
