#include "abuffer/visibility.h"

#include <cassert>
#include <string>
#include <utility>

#include "abuffer/exact_meshes.h"
#include "abuffer/reference/visible_at.h"
#include "abuffer/render_valid.h"

namespace swept {
namespace {

Status check(const Scene& scene, const std::vector<double>& times) {
  if (Status status = refuse_splats(scene, "visibility accuracy"); !status) return status;
  if (Status status = refuse_row_delay(scene, "visibility accuracy"); !status) return status;
  if (scene.camera.aperture.radius > 0.0)
    return Error{"", "/camera/aperture", "has a radius, and visibility accuracy is of a pinhole",
                 ErrorKind::unsupported};
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (scene.objects[i].triangles.empty())
      return Error{"", "/objects/" + std::to_string(i),
                   "has no triangles, which is what visibility accuracy is about", ErrorKind::unsupported};
  if (scene.film.has_overscan())
    return Error{"", "/film", "has overscan, which visibility accuracy leaves out", ErrorKind::unsupported};
  for (std::size_t i = 0; i < times.size(); ++i)
    if (!(times[i] >= 0.0 && times[i] < 1.0 && (i == 0 || times[i] > times[i - 1])))
      return Error{"", "times", "must be in [0, 1), and rise"};
  return Done{};
}

}  // namespace

Result<VisibleTriangles> visible_by_intervals(const Scene& scene, const std::vector<double>& times,
                                              const AbufferOptions& options, const RenderControl& control) {
  if (Status status = check(scene, times); !status) return status.error();
  MeshProbe probe{times, {}};
  VisibleTriangles visible;
  const Result<Rendered> rendered =
      render_valid(scene, options, control,
                   [&](const Scene& valid, const AbufferOptions& as_asked, const RenderControl& within)
                       -> Result<Rendered> { return render_exact_meshes(valid, as_asked, within, &probe); });
  if (!rendered) return rendered.error();
  visible.width = rendered->image.width, visible.height = rendered->image.height;
  visible.times = times.size();
  visible.triangle = std::move(probe.triangles);
  return visible;
}

Result<VisibleTriangles> visible_at_instants(const Scene& scene, const std::vector<double>& times,
                                             const RenderControl& control) {
  if (Status status = check(scene, times); !status) return status.error();
  if (Status status = control.validate(); !status) return status.error();
  if (Status status = scene.validate(); !status) return status.error();
  return run_in_arena(control,
                      [&]() -> Result<VisibleTriangles> { return reference::triangles_at(scene, times); });
}

VisibilityAccuracy visibility_accuracy(const VisibleTriangles& a, const VisibleTriangles& b) {
  assert(a.triangle.size() == b.triangle.size());
  VisibilityAccuracy of;
  for (std::size_t i = 0; i < a.triangle.size(); ++i) {
    if (a.triangle[i] == no_triangle && b.triangle[i] == no_triangle) continue;
    ++of.samples;
    of.same += a.triangle[i] == b.triangle[i] ? 1 : 0;
  }
  return of;
}

}  // namespace swept
