// Splats in glTF. Source: KHR_gaussian_splatting, Khronos Group, ratified 2026; drafts of 2025 had logarithms
// for scales.
#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/SVD>

#include "splat/io/gltf_file.h"
#include "splat/io/guarded.h"
#include "splat/io/read_splats.h"
#include "splat/io/rotate_harmonics.h"
#include "splat/io/splat_builder.h"

namespace swept::io {
namespace {

const std::string extension = "KHR_gaussian_splatting";

/// Accessors of a primitive.
struct Splats {
  std::string pointer;  ///< to its attributes
  GltfAccessor position, scale, rotation, opacity;
  std::vector<GltfAccessor> harmonics;
  SplatColors colors = SplatColors::srgb;
  std::size_t mesh = 0;
};

std::string harmonic_name(std::size_t coefficient) {
  const auto degree = static_cast<std::size_t>(std::sqrt(static_cast<double>(coefficient)));
  return extension + ":SH_DEGREE_" + std::to_string(degree) + "_COEF_" +
         std::to_string(coefficient - degree * degree);
}

int degree_of(std::size_t coefficients) {
  int degree = 0;
  while (static_cast<std::size_t>(SplatCloud::coefficients(degree)) < coefficients) ++degree;
  return degree;
}

/// What may not be ignored though nobody asks for it.
void refuse_unknown(const GltfFile& file) {
  const std::optional<JsonNode> required = file.root().find("extensionsRequired");
  if (!required) return;
  for (const JsonNode& name : required->elements())
    if (name.string() != extension && name.string() != "KHR_mesh_quantization")
      name.fail("the file requires " + name.string() + ", which is not known");
}

void expect_word(const JsonNode& splatting, const char* key, const char* word) {
  const std::optional<JsonNode> found = splatting.find(key);
  if (found && found->string() != word)
    found->fail('"' + found->string() + "\" is not known; \"" + word + "\" is");
}

/// Puts splats into the scene.
class Placement {
 public:
  Placement(const Eigen::Matrix3d& linear, const Eigen::Vector3d& offset)
      : linear_(linear),
        offset_(offset),
        svd_(linear, Eigen::ComputeFullU | Eigen::ComputeFullV),
        turn_(svd_.matrixU() * svd_.matrixV().transpose()),
        harmonics_(turn_) {
    // Minus a turn is one too, for ellipsoids.
    proper_turn_ = Eigen::Quaterniond(turn_.determinant() < 0.0 ? Eigen::Matrix3d(-turn_) : turn_);
  }

  [[nodiscard]] bool is_uneven() const {
    return svd_.singularValues()[2] < (1.0 - 1e-6) * svd_.singularValues()[0];
  }

  /// Numbers that are not finite stay so, for the builder to find.
  void apply(SplatRow& row, int degree) const {
    row.position = linear_ * row.position + offset_;
    harmonics_.apply(row.harmonics, degree);
    if (!row.rotation.allFinite() || !row.scale.allFinite() || !(row.rotation.stableNorm() > 0.0)) return;
    const Eigen::Vector4d q = row.rotation.stableNormalized();
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    if (is_uneven()) return stretch(rotation, row);
    row.scale *= svd_.singularValues().mean();
    set_rotation(proper_turn_ * rotation, row);
  }

 private:
  static void set_rotation(const Eigen::Quaterniond& q, SplatRow& row) {
    row.rotation << q.w(), q.x(), q.y(), q.z();
  }

  /// An ellipsoid stays one, with other axes.
  void stretch(const Eigen::Quaterniond& rotation, SplatRow& row) const {
    const Eigen::Matrix3d axes = linear_ * rotation.toRotationMatrix() * row.scale.asDiagonal();
    if (!axes.allFinite()) {
      row.scale.setConstant(INFINITY);
      return;
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(axes, Eigen::ComputeFullU);
    Eigen::Matrix3d directions = svd.matrixU();
    if (directions.determinant() < 0.0) directions.col(2) *= -1.0;  // an axis has no sign
    row.scale = svd.singularValues();
    set_rotation(Eigen::Quaterniond(directions), row);
  }

  Eigen::Matrix3d linear_;
  Eigen::Vector3d offset_;
  Eigen::JacobiSVD<Eigen::Matrix3d> svd_;
  Eigen::Matrix3d turn_;  ///< the orthogonal matrix that is nearest
  Eigen::Quaterniond proper_turn_;
  HarmonicRotation harmonics_;
};

class Reader {
 public:
  Reader(const std::string& path, std::string_view bytes, const SplatReadOptions& options)
      : path_(path), file_(path, bytes), options_(options) {}

  Result<LoadedSplats> read() {
    refuse_unknown(file_);
    find_splats();
    if (splats_.empty())
      return Error{path_, "",
                   "has no splats of " + std::string(extension) +
                       ", and its meshes are not read; Blender saves them as .ply or .obj"};
    const std::vector<Eigen::Matrix4d> transforms = scene_from_nodes(file_.nodes());
    std::vector<std::pair<const Splats*, const Eigen::Matrix4d*>> shown;
    std::size_t count = 0, coefficients = 1;
    for (const std::size_t node : file_.nodes_in_scene()) {
      const std::optional<JsonNode> mesh = file_.root().require("nodes").at(node).find("mesh");
      if (!mesh) continue;
      const std::size_t index = file_.index_in("meshes", *mesh);
      for (const Splats& splats : splats_) {
        if (splats.mesh != index) continue;
        shown.emplace_back(&splats, &transforms[node]);
        count += splats.position.count();
        coefficients = std::max(coefficients, splats.harmonics.size());
        // Small files may show theirs as often as they like.
        if (count > (std::size_t{1} << 16) && count > file_.buffer_bytes())
          return Error{path_, "/nodes", "show more splats than the buffers have bytes"};
      }
    }
    if (shown.empty()) return Error{path_, "/nodes", "none of the scene shows the splats"};
    const int degree = degree_of(coefficients);
    SplatBuilder builder(path_, count, degree, false, options_,
                         [this](SplatPart part, std::size_t k) { return name_of(part, k); });
    for (const auto& [splats, transform] : shown)
      if (Status s = add(*splats, *transform, degree, builder); !s) return s.error();
    report(builder.loaded, degree);
    return builder.finish();
  }

 private:
  void find_splats() {
    const std::optional<JsonNode> meshes = file_.root().find("meshes");
    if (!meshes) return;
    std::size_t index = 0;
    for (const JsonNode& mesh : meshes->elements()) {
      for (const JsonNode& primitive : mesh.require("primitives").elements()) {
        const std::optional<JsonNode> extensions = primitive.find("extensions");
        const std::optional<JsonNode> splatting = extensions ? extensions->find(extension) : std::nullopt;
        if (extensions)
          for (const std::string& name : extensions->keys())
            if (name != extension && name.find("gaussian_splat") != std::string::npos)
              extensions->require(name).fail(name + " is not known");
        if (splatting) splats_.push_back(splats_of(primitive, *splatting));
        if (splatting) splats_.back().mesh = index;
        if (!splatting) unread_.push_back("a mesh without splats");
      }
      ++index;
    }
    for (const Splats& splats : splats_)
      if (splats.colors != splats_.front().colors)
        throw Error{path_, splats.pointer, "blends in another colour space than other splats of the file"};
  }

  Splats splats_of(const JsonNode& primitive, const JsonNode& splatting) {
    if (const auto extended = splatting.find("extensions"))
      for (const std::string& name : extended->keys()) extended->require(name).fail(name + " is not known");
    expect_word(splatting, "kernel", "ellipse");
    expect_word(splatting, "projection", "perspective");
    expect_word(splatting, "sortingMethod", "cameraDistance");
    const std::optional<JsonNode> mode = primitive.find("mode");
    if (!mode || mode->integer(0, 6) != 0) primitive.fail("must be of points, mode 0, to hold splats");

    Splats splats;
    if (const auto space = splatting.find("colorSpace"))
      splats.colors = space->one_of({"srgb_rec709_display", "lin_rec709_display"}) == 0 ? SplatColors::srgb
                                                                                        : SplatColors::linear;
    else
      assumed_.push_back("colours are sRGB, which the file does not say");
    const JsonNode attributes = primitive.require("attributes");
    splats.pointer = attributes.pointer();
    splats.position = file_.accessor(attributes.require("POSITION"), "VEC3");
    const auto get = [&](const std::string& name, std::string_view type) {
      const JsonNode index = attributes.require(name);
      GltfAccessor found = file_.accessor(index, type);
      if (found.count() != splats.position.count())
        index.fail("has " + std::to_string(found.count()) + " elements for " +
                   std::to_string(splats.position.count()) + " splats");
      return found;
    };
    splats.scale = get(extension + ":SCALE", "VEC3");
    splats.rotation = get(extension + ":ROTATION", "VEC4");
    splats.opacity = get(extension + ":OPACITY", "SCALAR");
    // Degrees are whole: what begins one has to be followed by the rest of it.
    for (std::size_t k = 0, end = 1; k < end && k < most_harmonics; ++k) {
      splats.harmonics.push_back(get(harmonic_name(k), "VEC3"));
      if (k + 1 < end || k + 1 == most_harmonics) continue;
      const int next = degree_of(end) + 1;
      const std::string prefix = extension + ":SH_DEGREE_" + std::to_string(next) + "_";
      const std::vector<std::string> names = attributes.keys();
      if (std::any_of(names.begin(), names.end(),
                      [&](const std::string& n) { return n.starts_with(prefix); }))
        end = static_cast<std::size_t>(SplatCloud::coefficients(next));
    }
    for (const std::string& name : attributes.keys())
      if (name.starts_with(extension + ":SH_DEGREE_") && !is_read(name, splats.harmonics.size()))
        attributes.require(name).fail("is no spherical harmonic of degrees 0 to 3, or skips a degree");
    for (std::size_t i = 0; i < splats.scale.count() && !log_scales_; ++i)
      for (std::size_t k = 0; k < 3; ++k) log_scales_ |= splats.scale.number(i, k) < 0.0;
    return splats;
  }

  static bool is_read(const std::string& name, std::size_t coefficients) {
    for (std::size_t k = 0; k < coefficients; ++k)
      if (name == harmonic_name(k)) return true;
    return false;
  }

  Status add(const Splats& splats, const Eigen::Matrix4d& scene_from_node, int degree,
             SplatBuilder& builder) {
    now_ = &splats;
    const Eigen::Matrix4d transform = training_from_gltf() * scene_from_node;
    const Placement placement(transform.topLeftCorner<3, 3>(), transform.topRightCorner<3, 1>());
    uneven_ |= placement.is_uneven();
    for (std::size_t i = 0; i < splats.position.count(); ++i) {
      SplatRow row = row_at(splats, i);
      placement.apply(row, degree);
      if (Status s = builder.add(row); !s) return s;
    }
    return Done{};
  }

  SplatRow row_at(const Splats& splats, std::size_t i) const {
    const auto vector = [i](const GltfAccessor& from) {
      return Eigen::Vector3d(from.number(i, 0), from.number(i, 1), from.number(i, 2));
    };
    SplatRow row;
    row.position = vector(splats.position);
    row.scale = vector(splats.scale);
    if (log_scales_) row.scale = row.scale.array().exp();
    row.rotation << splats.rotation.number(i, 3), splats.rotation.number(i, 0), splats.rotation.number(i, 1),
        splats.rotation.number(i, 2);
    row.opacity = splats.opacity.number(i, 0);
    for (std::size_t k = 0; k < splats.harmonics.size(); ++k) row.harmonics[k] = vector(splats.harmonics[k]);
    return row;
  }

  [[nodiscard]] std::string name_of(SplatPart part, std::size_t component) const {
    const std::string name = part == SplatPart::position   ? "POSITION"
                             : part == SplatPart::scale    ? extension + ":SCALE"
                             : part == SplatPart::rotation ? extension + ":ROTATION"
                             : part == SplatPart::opacity  ? extension + ":OPACITY"
                                                           : harmonic_name(component / 3);
    return now_->pointer + '/' + name;
  }

  void report(LoadedSplats& loaded, int degree) {
    loaded.splats.colors = splats_.front().colors;
    ReadReport& report = loaded.report;
    report.used = {{"position", {"POSITION"}},
                   {"scale", {"SCALE"}},
                   {"rotation", {"ROTATION"}},
                   {"opacity", {"OPACITY"}},
                   {"color", {"SH_DEGREE_0_COEF_0"}}};
    for (int l = 1; l <= degree; ++l)
      report.used.push_back(
          {"harmonics", {"SH_DEGREE_" + std::to_string(l) + "_COEF_0 to " + std::to_string(2 * l)}});
    std::sort(unread_.begin(), unread_.end());
    unread_.erase(std::unique(unread_.begin(), unread_.end()), unread_.end());
    report.unread = unread_;
    report.assumed = assumed_;
    if (log_scales_)
      report.assumed.push_back("scales are logarithms, as in drafts of the extension: some are negative");
    if (uneven_ && degree > 0)
      loaded.notes.push_back("nodes stretch splats: their harmonics are turned, but not stretched");
  }

  const std::string& path_;
  GltfFile file_;
  const SplatReadOptions& options_;
  std::vector<Splats> splats_;
  const Splats* now_ = nullptr;  ///< whose numbers are being added
  bool log_scales_ = false, uneven_ = false;
  std::vector<std::string> unread_, assumed_;
};

}  // namespace

Result<LoadedSplats> read_splat_gltf(const std::string& path, std::string_view bytes,
                                     const SplatReadOptions& options) {
  return guarded(path, [&] { return Reader(path, bytes, options).read(); });
}

}  // namespace swept::io
