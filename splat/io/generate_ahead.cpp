// Generated clouds of a scene file, several at once.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "splat/io/scene_clouds.h"

namespace swept {

void SceneFile::generate_ahead(double frame, const Generator& generator, int threads) noexcept {
  try {
    if (!(std::abs(frame) <= most_frame)) return;
    clouds_->objects.resize(sources_.size());
    if (clouds_->ahead_frame != frame) clouds_->ahead.clear();
    clouds_->ahead_frame = frame;
    std::vector<std::size_t> wanted;
    for (std::size_t i = 0; i < sources_.size(); ++i)
      if (std::holds_alternative<GeneratorSource>(sources_[i].points) && !clouds_->objects[i].keep)
        wanted.push_back(i);
    const std::size_t most =
        threads > 0 ? static_cast<std::size_t>(threads) : std::max(1u, std::thread::hardware_concurrency());
    if (wanted.size() < 2 || most < 2) return;
    // The largest first, so that none is left to the end.
    const auto points = [&](std::size_t i) { return std::get<GeneratorSource>(sources_[i].points).points; };
    std::stable_sort(wanted.begin(), wanted.end(),
                     [&](std::size_t a, std::size_t b) { return points(a) > points(b); });
    const Scene at = settings(frame);
    std::vector<std::unique_ptr<LoadedObject>> loaded(wanted.size());
    std::atomic<std::size_t> next{0};
    const auto work = [&]() noexcept {
      for (std::size_t k; (k = next++) < wanted.size();) try {
          Result<LoadedObject> object = load_object(wanted[k], at, generator);
          if (object) loaded[k] = std::make_unique<LoadedObject>(*std::move(object));
        } catch (...) {  // scene_at() will find it, too
        }
    };
    {
      std::vector<std::jthread> others;
      try {
        while (others.size() + 1 < std::min(most, wanted.size())) others.emplace_back(work);
      } catch (const std::system_error&) {  // those that there are do it
      }
      work();
    }
    for (std::size_t k = 0; k < wanted.size(); ++k)
      if (loaded[k]) clouds_->ahead[wanted[k]] = std::move(*loaded[k]);
  } catch (...) {
    clouds_->ahead.clear();
  }
}

}  // namespace swept
