// An animation of a simulation's own particles, drawn into a viewer's own frame: nothing is copied on the way
// in, and the picture lands where it is shown. A picture that takes too long is given up.
#include <cmath>
#include <cstdio>
#include <vector>

#include <swept/abuffer/sampled.h>
#include <swept/splat/arrays.h>
#include <swept/splat/pixel_target.h>

namespace {

struct Particle {  // as the simulation has it
  Eigen::Vector3d position;
  Eigen::Vector3f velocity;  // per frame
  Eigen::Vector3f color, axis_u, axis_v;
  float age = 0.0f;
};

void step(std::vector<Particle>& particles) {
  for (Particle& particle : particles) {
    particle.position += particle.velocity.cast<double>();
    particle.velocity.y() -= 0.01f;
    particle.age += 1.0f;
  }
}

/// A member of every particle, where it lies.
template <class Member>
swept::Strided<Member> view(const std::vector<Particle>& particles, const Member Particle::*member) {
  return {&(particles.front().*member), particles.size(), sizeof(Particle)};
}

}  // namespace

int main() {
  std::vector<Particle> particles;
  for (int i = 0; i < 500; ++i) {
    const float angle = 0.61803f * 6.2832f * static_cast<float>(i),
                speed = 0.02f + 0.0002f * static_cast<float>(i);
    Particle particle;
    particle.position = {0.0, -0.8, 0.0};
    particle.velocity = {speed * std::cos(angle), 0.12f, speed * std::sin(angle)};
    particle.color = {0.9f, 0.3f + 0.001f * static_cast<float>(i), 0.1f};
    particle.axis_u = {0.03f, 0, 0};
    particle.axis_v = {0, 0.03f, 0};
    particles.push_back(particle);
  }

  swept::Scene scene;
  scene.film = {320, 180, 0, 0, 0, 0};
  scene.camera.look_ats.emplace_back();
  scene.objects.emplace_back();
  std::vector<float> screen(320 * 180 * 3);  // bottom row first, as OpenGL has it
  const swept::PixelTarget frame{&screen[320 * 179 * 3], 320, 180, 3, 0, -320 * 3 * 4};

  for (int number = 0; number < 8; ++number, step(particles)) {
    swept::SurfelArrays arrays;
    arrays.position = view(particles, &Particle::position);
    arrays.velocity_per_frame = view(particles, &Particle::velocity);
    arrays.color = view(particles, &Particle::color);
    arrays.axis_u = view(particles, &Particle::axis_u);
    arrays.axis_v = view(particles, &Particle::axis_v);
    arrays.frame = scene.frame = number;
    swept::Result<swept::SurfelCloud> cloud = swept::cloud_from_arrays(arrays);
    if (!cloud) return std::fprintf(stderr, "%s\n", cloud.error().message().c_str()), 1;
    scene.objects[0].cloud = *std::move(cloud);

    std::stop_source stop;
    swept::RenderControl control;
    control.stop = stop.get_token();
    control.progress = [&](double) { /* a viewer whose camera moved would call stop.request_stop() */ };
    const swept::Result<swept::Rendered> rendered = swept::render_sampled(scene, {}, control);
    if (!rendered && rendered.error().kind == swept::ErrorKind::cancelled) continue;
    if (!rendered) return std::fprintf(stderr, "%s\n", rendered.error().message().c_str()), 1;
    if (const swept::Status copied = swept::copy_pixels(rendered->image, frame); !copied) return 1;
    float brightest = 0.0f;
    for (const float value : screen) brightest = std::fmax(brightest, value);
    std::printf("frame %d: %.1f instants a pixel, brightest %.3f\n", number,
                rendered->statistics.counter("instants_per_pixel").value_or(0.0),
                static_cast<double>(brightest));
    if (!(brightest > 0.0f)) return 1;
  }
}
