#include "gpu_passes/six_pass/pass_runner.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "gpu_passes/device/gl_errors.h"
#include "gpu_passes/device/program.h"
#include "gpu_passes/six_pass/gaussian_table.h"

namespace swept {
namespace {

/// Texture units by sampler; the same for all programs.
constexpr std::array<const char*, 8> samplers{"limit_open", "limit_close", "earliest",  "latest",
                                              "color_sum",  "behind_sum",  "depth_sum", "gaussian_table"};
constexpr int table_unit = 7;

int unit_of(std::string_view sampler) {
  return static_cast<int>(std::find(samplers.begin(), samplers.end(), sampler) - samplers.begin());
}

void set_blend(Blend blend) {
  if (blend == Blend::replace) {
    glDisable(GL_BLEND);
    return;
  }
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glBlendEquation(blend == Blend::minimum ? GL_MIN : blend == Blend::maximum ? GL_MAX : GL_FUNC_ADD);
}

void clear(const Pass& pass) {
  const float value = pass.clear_to, color[4] = {value, value, value, value};
  for (std::size_t i = 0; i < pass.targets.size(); ++i)
    glClearBufferfv(GL_COLOR, static_cast<GLint>(i), color);
  // Reversed depth: 0 is infinitely far.
  const float far = 0.0f;
  if (pass.depth_test) glClearBufferfv(GL_DEPTH, 0, &far);
}

}  // namespace

Result<PassRunner> PassRunner::create(std::size_t batch_kernels) {
  PassRunner runner;
  runner.batch_kernels_ = batch_kernels;
  for (int i = 0; i < program_count; ++i) {
    const ProgramSource source = program_source(static_cast<ProgramId>(i));
    Result<GlProgram> program = build_program(source.vertex, source.fragment, source.defines);
    if (!program) return program.error();
    Program& slot = runner.programs_[static_cast<std::size_t>(i)];
    slot.program = std::move(*program);
    const GLuint name = slot.program.name();
    slot.geometry = glGetUniformLocation(name, "geometry");
    slot.time = glGetUniformLocation(name, "time");
    glUseProgram(name);
    for (const char* sampler : samplers) {
      const GLint location = glGetUniformLocation(name, sampler);
      if (location >= 0) glUniform1i(location, unit_of(sampler));
    }
  }
  glUseProgram(0);
  runner.frame_block_ = GlBuffer::make();
  runner.empty_vertex_array_ = GlVertexArray::make();
  runner.table_ = make_gaussian_table();
  runner.timed_ = PassTimers::available();
  // What no pass changes.
  glDepthFunc(GL_GREATER);
  if (Status status = take_errors("setting up"); !status) return status.error();
  return runner;
}

Status PassRunner::prepare_targets(const FrameSetup& setup) {
  const bool resized = !targets_ || targets_->width() != setup.width || targets_->height() != setup.height;
  if (!resized && setup.passes.data() == passes_.data()) return Done{};
  framebuffers_.clear();
  passes_ = {};
  if (resized) {
    targets_.reset();
    Result<FrameTargets> targets = FrameTargets::create(setup.width, setup.height);
    if (!targets) return targets.error();
    targets_ = std::move(*targets);
  }
  for (const Pass& pass : setup.passes) {
    Result<GlFramebuffer> framebuffer = targets_->framebuffer(pass);
    if (!framebuffer) return framebuffer.error();
    framebuffers_.push_back(std::move(*framebuffer));
  }
  passes_ = setup.passes;
  return Done{};
}

Status PassRunner::begin_frame(const FrameSetup& setup) {
  if (Status status = prepare_targets(setup); !status) return status;
  lookup_tables_ = setup.lookup_tables;
  seconds_ = std::make_shared<std::vector<double>>(timed_ ? passes_.size() : 0, 0.0);
  most_batches_ = 0;
  glBindBuffer(GL_UNIFORM_BUFFER, frame_block_.name());
  glBufferData(GL_UNIFORM_BUFFER, sizeof(setup.block), &setup.block, GL_STREAM_DRAW);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame_block_.name());
  glActiveTexture(GL_TEXTURE0 + table_unit);
  glBindTexture(GL_TEXTURE_2D, table_.name());
  glViewport(0, 0, setup.width, setup.height);
  for (std::size_t i = 0; i < passes_.size(); ++i) {
    if (passes_[i].clears) continue;
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[i].name());
    clear(passes_[i]);
  }
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  return Done{};
}

void PassRunner::upload(std::span<const Instance> instances) {
  used_batches_ = 0;
  while (!instances.empty()) {
    if (used_batches_ == batches_.size()) {
      Batch batch{GlBuffer::make(), GlVertexArray::make(), 0};
      glBindVertexArray(batch.vertex_array.name());
      glBindBuffer(GL_ARRAY_BUFFER, batch.buffer.name());
      glBindVertexBuffer(0, batch.buffer.name(), 0, sizeof(Instance));
      glVertexBindingDivisor(0, 1);
      for (GLuint i = 0; i < instance_attributes; ++i) {
        glEnableVertexAttribArray(i);
        glVertexAttribFormat(i, 4, GL_FLOAT, GL_FALSE, i * static_cast<GLuint>(sizeof(glm::vec4)));
        glVertexAttribBinding(i, 0);
      }
      batches_.push_back(std::move(batch));
    }
    Batch& batch = batches_[used_batches_++];
    const std::span<const Instance> part = instances.first(std::min(instances.size(), batch_kernels_));
    instances = instances.subspan(part.size());
    batch.count = static_cast<GLsizei>(part.size());
    glBindBuffer(GL_ARRAY_BUFFER, batch.buffer.name());
    // New storage: what the last sub-frame still reads stays as it is.
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(part.size_bytes()), part.data(), GL_STREAM_DRAW);
  }
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  most_batches_ = std::max(most_batches_, used_batches_);
}

const PassRunner::Program& PassRunner::program_of(const Pass& pass) const {
  const ProgramId id =
      pass.program == ProgramId::blend && lookup_tables_ ? ProgramId::blend_tables : pass.program;
  return programs_[static_cast<std::size_t>(id)];
}

void PassRunner::draw(const Pass& pass) {
  if (pass.clears) clear(pass);
  if (pass.geometry == Geometry::nothing) return;
  set_blend(pass.blend);
  if (pass.depth_test)
    glEnable(GL_DEPTH_TEST);
  else
    glDisable(GL_DEPTH_TEST);
  for (const PassInput& input : pass.inputs) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit_of(input.sampler)));
    glBindTexture(GL_TEXTURE_2D, targets_->texture(input.target));
  }
  const Program& program = program_of(pass);
  glUseProgram(program.program.name());
  if (pass.geometry == Geometry::window) {
    glBindVertexArray(empty_vertex_array_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
  } else {
    glUniform1i(program.geometry, static_cast<GLint>(pass.geometry));
    if (program.time >= 0) glUniform1f(program.time, pass.geometry == Geometry::open ? -0.5f : 0.5f);
    // Corners of a box, or of an octagon.
    const GLsizei vertices = pass.geometry == Geometry::tube ? 8 : 4;
    for (std::size_t i = 0; i < used_batches_; ++i) {
      glBindVertexArray(batches_[i].vertex_array.name());
      glDrawArraysInstanced(GL_TRIANGLE_FAN, 0, vertices, batches_[i].count);
    }
  }
  for (const PassInput& input : pass.inputs) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit_of(input.sampler)));
    glBindTexture(GL_TEXTURE_2D, 0);
  }
}

void PassRunner::draw_subframe(std::span<const Instance> instances) {
  Subframe& subframe = subframes_[next_subframe_];
  next_subframe_ = (next_subframe_ + 1) % subframes_.size();
  // A device that is lost says so at the end of the frame.
  static_cast<void>(subframe.done.wait());
  subframe.timers.collect();
  subframe.timers.start(seconds_);
  upload(instances);
  for (std::size_t i = 0; i < passes_.size(); ++i) {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[i].name());
    subframe.timers.time(i, [&] { draw(passes_[i]); });
  }
  glBindVertexArray(0);
  glUseProgram(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  subframe.done = GlFence::make();
  glFlush();
}

Result<DrawnFrame> PassRunner::end_frame(PixelBuffer buffer) {
  DrawnFrame frame{Readback(*targets_, std::move(buffer)), passes_, std::exchange(seconds_, {}),
                   most_batches_};
  if (Status status = take_errors("the frame was drawn"); !status) return status.error();
  return frame;
}

Status PassRunner::wait(const DrawnFrame& frame) {
  Status status = frame.pixels.wait();
  for (Subframe& subframe : subframes_)
    if (subframe.timers.frame() == frame.seconds) subframe.timers.collect();
  return status ? take_errors("the frame was drawn") : status;
}

}  // namespace swept
