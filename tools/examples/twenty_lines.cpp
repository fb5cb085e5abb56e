// Twenty lines from nothing to a picture: a disc that crosses the film while the shutter is open.
#include <cstdio>

#include <swept/abuffer/sampled.h>
#include <swept/splat/io/image_file.h>

int main(int argc, char** argv) {
  swept::Scene scene;                    // 1024 × 576 px, the shutter half a frame open
  scene.camera.look_ats.emplace_back();  // from (0, 0, 5) to the origin
  swept::Object& object = scene.objects.emplace_back();
  object.cloud.keys.push_back({0.0, {{{0, 0, 0}}, {{0.5f, 0, 0}}, {{0, 0.5f, 0}}}});  // centre, two axes
  object.cloud.velocity = {{1, 0, 0}};                                                // per frame
  const swept::Result<swept::Rendered> rendered = swept::render_sampled(scene);       // to 60 dB
  if (!rendered) return std::fprintf(stderr, "%s\n", rendered.error().message().c_str()), 1;
  const swept::Status written = swept::write_exr(argc > 1 ? argv[1] : "disc.exr", rendered->image);
  if (!written) return std::fprintf(stderr, "%s\n", written.error().message().c_str()), 1;
}
