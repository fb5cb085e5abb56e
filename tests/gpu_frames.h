// A renderer and a small scene, for tests of several frames.
#pragma once

#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "gpu_passes/gpu_renderer.h"
#include "gpu_stage.h"

namespace swept {

inline GpuRenderOptions six(int subframes) { return {GpuMethod::six_pass, subframes, false}; }

/// A striped ball that flies through a small film.
inline Scene ball(int width = 48, int height = 32) {
  Scene scene;
  scene.film = {width, height, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats.emplace_back();
  scene.camera.look_ats.back().eye.z() = 3.5;
  scene.background = {0.05f, 0.1f, 0.2f, 1.0f};
  scene.objects = {striped_sphere(0.8, 600)};
  TransformKey key;
  key.translate = {-0.4, 0.0, 0.0};
  scene.objects[0].transform.keys.push_back(key);
  key.frame = 1.0;
  key.translate = {0.4, 0.1, 0.2};
  scene.objects[0].transform.keys.push_back(key);
  return scene;
}

/// One renderer, as create() made it last.
class GpuFrames : public testing::Test {
 protected:
  void SetUp() override { create({}); }
  void create(const GpuOptions& options) {
    Result<GpuRenderer> renderer = GpuRenderer::create(options);
    if (!renderer) GTEST_SKIP() << renderer.error().message();
    renderer_.emplace(std::move(*renderer));
  }

  void submit(const Scene& scene, const GpuRenderOptions& options) {
    const Status status = renderer_->submit(scene, options);
    EXPECT_TRUE(status) << status.error().message();
  }
  Rendered collect() {
    Result<Rendered> rendered = renderer_->collect();
    EXPECT_TRUE(rendered) << rendered.error().message();
    return rendered ? std::move(*rendered) : Rendered{};
  }
  Image render(const Scene& scene, const GpuRenderOptions& options) {
    Result<Rendered> rendered = renderer_->render(scene, options);
    EXPECT_TRUE(rendered) << rendered.error().message();
    return rendered ? std::move(rendered->image) : Image{};
  }

  std::optional<GpuRenderer> renderer_;
};

}  // namespace swept
