// The GPU's frames can be stopped, and heard of; the renderer stays usable.
#include <gtest/gtest.h>

#include "gpu_passes/gpu_renderer.h"
#include "small_scenes.h"

namespace swept {
namespace {

Scene moving_scene() {
  Scene scene = test::stage();
  Object& object = scene.objects.emplace_back(test::checkered_sphere(0.8, 400));
  object.cloud.velocity.assign(object.cloud.size(), {0.4f, 0.0f, 0.0f});
  return scene;
}

TEST(GpuStop, AStoppedFrameIsGoneAndTheNextIsWhole) {
  Result<GpuRenderer> gpu = GpuRenderer::create();
  ASSERT_TRUE(gpu) << gpu.error().message();
  const Scene scene = moving_scene();
  const Result<Rendered> whole = gpu->render(scene, {.subframes = 16});
  ASSERT_TRUE(whole) << whole.error().message();
  std::stop_source stop;
  std::vector<double> shares;
  RenderControl control;
  control.stop = stop.get_token();
  control.progress = [&](double share) {
    shares.push_back(share);
    if (share >= 0.25) stop.request_stop();
  };
  const Result<Rendered> stopped = gpu->render(scene, {.subframes = 16}, control);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, ErrorKind::cancelled);
  EXPECT_EQ(shares, (std::vector<double>{0.0625, 0.125, 0.1875, 0.25}));
  EXPECT_EQ(gpu->pending(), 0u);
  const Result<Rendered> again = gpu->render(scene, {.subframes = 16});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->image.rgba, whole->image.rgba);
}

TEST(GpuStop, WhatACallbackThrowsIsAnError) {
  Result<GpuRenderer> gpu = GpuRenderer::create();
  ASSERT_TRUE(gpu) << gpu.error().message();
  RenderControl control;
  control.progress = [](double) { throw 7; };
  const Result<Rendered> rendered = gpu->render(moving_scene(), {.subframes = 2}, control);
  ASSERT_FALSE(rendered);
  EXPECT_EQ(rendered.error().field, "progress");
}

}  // namespace
}  // namespace swept
