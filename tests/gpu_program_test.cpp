// Shader text: includes, errors with file and line, and the formulas against double precision.
#include "gpu_passes/device/program.h"

#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "gpu_passes/device/context.h"
#include "gpu_passes/six_pass/gaussian_table.h"
#include "gpu_passes/six_pass/passes.h"
#include "gpu_passes/six_pass/shaders.h"
#include "splat/kernel/kernel_integral.h"

namespace swept {
namespace {

class GpuProgram : public testing::Test {
 protected:
  void SetUp() override {
    Result<GlContext> context = GlContext::create("");
    if (!context) GTEST_SKIP() << context.error().message();
    context_.emplace(std::move(*context));
    current_.emplace(*context_);
    ASSERT_TRUE(current_->status());
  }

 private:
  std::optional<GlContext> context_;
  std::optional<CurrentContext> current_;
};

TEST(ShaderText, TakesEachIncludeOnceAndCountsLinesByFile) {
  const Result<ShaderText> text =
      expand_includes("a.frag", "first\n#include \"frame.glsl\"\nthird\n#include \"frame.glsl\"\nfifth\n");
  ASSERT_TRUE(text) << text.error().message();
  EXPECT_EQ(text->files, (std::vector<std::string>{"a.frag", "frame.glsl"}));
  EXPECT_EQ(text->text, "#line 1 0\nfirst\n#line 1 1\n" + std::string(shader_source("frame.glsl")) +
                            "#line 3 0\nthird\n#line 5 0\nfifth\n");
}

TEST(ShaderText, NamesTheFileThatIncludesWhatIsNotThere) {
  const Result<ShaderText> text = expand_includes("a.frag", "one\n#include \"nowhere.glsl\"\n");
  ASSERT_FALSE(text.ok());
  EXPECT_EQ(text.error().message(), "a.frag: 2: includes nowhere.glsl, which there is not");
}

TEST(ShaderText, ReadsTheLogsOfThreeKindsOfDriver) {
  const std::vector<std::string> files{"a.frag", "b.glsl"};
  EXPECT_EQ(name_files("1:12(5): error: x\n0:3(1): error: y\n", files),
            "b.glsl:12: error: x\na.frag:3: error: y\n");
  EXPECT_EQ(name_files("1(12) : error C1503: x", files), "b.glsl:12: error C1503: x");
  EXPECT_EQ(name_files("ERROR: 0:7: 'x' : undeclared", files), "ERROR: a.frag:7: 'x' : undeclared");
  EXPECT_EQ(name_files("9:12(5): error: x\nno place", files), "9:12(5): error: x\nno place");
}

TEST_F(GpuProgram, AllOfThePassesBuild) {
  for (int i = 0; i < program_count; ++i) {
    const ProgramSource source = program_source(static_cast<ProgramId>(i));
    const Result<GlProgram> program = build_program(source.vertex, source.fragment, source.defines);
    EXPECT_TRUE(program) << program.error().message();
  }
}

TEST_F(GpuProgram, ACompileErrorNamesFileAndLine) {
  const Result<GlShader> shader = compile_shader(
      GL_FRAGMENT_SHADER, "broken.frag", "#include \"frame.glsl\"\nvoid main() {\n  nonsense();\n}\n", {});
  ASSERT_FALSE(shader.ok());
  EXPECT_EQ(shader.error().file, "broken.frag");
  EXPECT_NE(shader.error().reason.find("broken.frag:3:"), std::string::npos) << shader.error().reason;
}

/// mean_gaussian() of gaussian.glsl for each pair, computed by the GPU.
std::vector<float> means_on_gpu(const std::vector<float>& pairs, const std::vector<std::string>& defines) {
  const Result<GlShader> vertex =
      compile_shader(GL_VERTEX_SHADER, "fullscreen.vert", shader_source("fullscreen.vert"), {});
  const Result<GlShader> fragment =
      compile_shader(GL_FRAGMENT_SHADER, "table.frag",
                     "#include \"gaussian.glsl\"\n"
                     "uniform sampler2D pairs;\n"
                     "out float mean;\n"
                     "void main() {\n"
                     "  vec2 y = texelFetch(pairs, ivec2(gl_FragCoord.xy), 0).rg;\n"
                     "  mean = mean_gaussian(y.x, y.y);\n"
                     "}\n",
                     defines);
  if (!vertex || !fragment) return {};
  const GlProgram program = GlProgram::make();
  glAttachShader(program.name(), vertex->name());
  glAttachShader(program.name(), fragment->name());
  glLinkProgram(program.name());
  const GLsizei count = static_cast<GLsizei>(pairs.size() / 2);
  const GlTexture in = GlTexture::make(), out = GlTexture::make();
  glBindTexture(GL_TEXTURE_2D, out.name());
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_R32F, count, 1);
  glBindTexture(GL_TEXTURE_2D, in.name());
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RG32F, count, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, count, 1, GL_RG, GL_FLOAT, pairs.data());
  const GlFramebuffer framebuffer = GlFramebuffer::make();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, out.name(), 0);
  const GlTexture table = make_gaussian_table();
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, table.name());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, in.name());
  const GlVertexArray vertices = GlVertexArray::make();
  glBindVertexArray(vertices.name());
  glViewport(0, 0, count, 1);
  glUseProgram(program.name());
  glUniform1i(glGetUniformLocation(program.name(), "gaussian_table"), 1);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::vector<float> means(static_cast<std::size_t>(count));
  glReadPixels(0, 0, count, 1, GL_RED, GL_FLOAT, means.data());
  return glGetError() == GL_NO_ERROR ? means : std::vector<float>{};
}

TEST_F(GpuProgram, TheGaussianMeanHoldsItsAccuracyInAllOfItsBranches) {
  // Spans from nothing to all of the kernel, at places from the middle to √50 + 0.7, the last that ImageModel
  // allows.
  std::vector<float> pairs;
  for (double span = 1e-7; span < 14.0; span *= 1.35)
    for (double begin = -7.7; begin < 7.7; begin += 0.31)
      if (begin + span < 7.7)
        pairs.insert(pairs.end(), {static_cast<float>(begin), static_cast<float>(begin + span)});
  const std::vector<float> means = means_on_gpu(pairs, {});
  ASSERT_EQ(2 * means.size(), pairs.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double a = static_cast<double>(pairs[2 * i]), b = static_cast<double>(pairs[2 * i + 1]);
    const double exact = mean_gaussian<double>(a, b);
    // Below the smallest normal float there is nothing to be relative to.
    if (exact < 1.2e-38) continue;
    const double relative = std::abs(static_cast<double>(means[i]) / exact - 1.0);
    // Rounding y² moves exp(−y²) by y² ulps of its argument, twice; two values of erfc of relative error 1e-6
    // are subtracted, and where series() takes over from that, a span of 0.8/(1 + 0.8 y) leaves
    // 1 − exp(−2y·span) of them, a third at least.
    const double y = std::max(std::abs(a), std::abs(b));
    const double allowed = 2.0 * (y * y + 4.0) * 0x1p-23 + 3.0 * 2e-6;
    EXPECT_LE(relative, allowed) << "[" << a << ", " << b << "]";
    worst = std::max(worst, relative);
  }
  RecordProperty("worst_relative", std::to_string(worst));
}

TEST_F(GpuProgram, TheTablesHoldTheirAccuracy) {
  std::vector<float> pairs;
  for (double span = 0.01; span < 15.0; span *= 1.35)
    for (double begin = -7.7; begin < 7.7; begin += 0.093)
      if (begin + span < 7.7)
        pairs.insert(pairs.end(), {static_cast<float>(begin), static_cast<float>(begin + span)});
  const std::vector<float> means = means_on_gpu(pairs, program_source(ProgramId::blend_tables).defines);
  ASSERT_EQ(2 * means.size(), pairs.size());
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double a = static_cast<double>(pairs[2 * i]), b = static_cast<double>(pairs[2 * i + 1]);
    // Linear between texels h apart, the two functions err by a second derivative of 2 and of 0.97 times
    // h²/8, and by a slope of 0.86 and of 1.13 times h/512 where a device filters with 8 bits. The middle
    // stands for a short span, which errs by span²/24 of the second derivative.
    const double h = static_cast<double>(table_range) / (table_texels - 1), span = b - a;
    const double of_exp = 2.0 * h * h / 8.0 + 0.86 * h / 512.0 + 2.0 * span * span / 24.0;
    const double of_erf = std::sqrt(M_PI) / 2.0 * 2.0 * (0.97 * h * h / 8.0 + 1.13 * h / 512.0) / span;
    EXPECT_NEAR(static_cast<double>(means[i]), mean_gaussian<double>(a, b), span < 0.0625 ? of_exp : of_erf)
        << "[" << a << ", " << b << "]";
  }
}

}  // namespace
}  // namespace swept
