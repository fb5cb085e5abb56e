// Points that come and go in a sequence of files with ids.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <unordered_map>

#include "splat/io/cloud_keys.h"
#include "splat/io/sequence_looks.h"

namespace swept::io {
namespace {

constexpr double forever = std::numeric_limits<double>::infinity();

/// What one file has.
struct File {
  double frame = 0.0;
  PointSet set;
  EstimatedSurfels discs;
  std::vector<char> unoriented;
  std::unordered_map<std::int64_t, std::size_t> index_of;
};

/// A point in files [first, last], all of which have it.
struct Run {
  std::size_t first, last;
  std::vector<std::size_t> index;  ///< in each of them

  [[nodiscard]] std::size_t nearest_to(std::size_t file) const { return std::clamp(file, first, last); }
  [[nodiscard]] std::size_t index_in(std::size_t file) const { return index[file - first]; }
};

Lifetime life_of(const Run& run, const std::vector<File>& files) {
  const auto between = [&](std::size_t k) { return 0.5 * files[k].frame + 0.5 * files[k + 1].frame; };
  return {run.first > 0 ? between(run.first - 1) : -forever,
          run.last + 1 < files.size() ? between(run.last) : forever};
}

Result<std::vector<File>> read_files(const CloudSource& source, const KeySpan& span) {
  std::vector<File> files;
  for (std::size_t k = span.begin; k < span.end; ++k) {
    Result<PointSet> set = read_with_rates(source, source.files[k]);
    if (!set) return set.error();
    File& file = files.emplace_back();
    file.frame = source.files[k].frame;
    file.set = *std::move(set);
    PointSet discs_set = file.set;
    Result<EstimatedSurfels> discs = discs_of(discs_set, source);
    if (!discs) return Error{source.files[k].path, discs.error().field, discs.error().reason};
    file.discs = *std::move(discs);
    file.unoriented.assign(file.set.size(), 0);
    for (const std::size_t i : file.discs.unoriented) file.unoriented[i] = 1;
    for (std::size_t i = 0; i < file.set.id.size(); ++i) file.index_of.emplace(file.set.id[i], i);
  }
  return files;
}

/// All points, those of the nearest file first and in its order.
std::vector<Run> runs_of(const std::vector<File>& files, std::size_t nearest) {
  std::vector<Run> runs, others;
  std::unordered_map<std::int64_t, Run> open;
  const auto close = [&](std::size_t at, Run run) {
    if (run.first <= nearest && nearest <= run.last)
      runs[run.index_in(nearest)] = std::move(run);
    else
      others.push_back(std::move(run));
    (void)at;
  };
  runs.resize(files[nearest].set.size());
  for (std::size_t k = 0; k < files.size(); ++k) {
    std::unordered_map<std::int64_t, Run> next;
    // In the order of the file, so that the result does not hang on a table's.
    for (std::size_t i = 0; i < files[k].set.size(); ++i) {
      const auto before = open.find(files[k].set.id[i]);
      Run run = before == open.end() ? Run{k, k, {}} : std::move(before->second);
      if (before != open.end()) open.erase(before);
      run.last = k;
      run.index.push_back(i);
      next.emplace(files[k].set.id[i], std::move(run));
    }
    if (k > 0)
      for (const std::int64_t id : files[k - 1].set.id)
        if (const auto ended = open.find(id); ended != open.end()) close(k, std::move(ended->second));
    open = std::move(next);
  }
  for (const std::int64_t id : files.back().set.id) close(files.size(), std::move(open.at(id)));
  runs.insert(runs.end(), std::make_move_iterator(others.begin()), std::make_move_iterator(others.end()));
  return runs;
}

/// The discs of all runs at file `k`.
EstimatedSurfels key_of(const std::vector<Run>& runs, const std::vector<File>& files, std::size_t k,
                        double scale) {
  EstimatedSurfels key;
  for (const Run& run : runs) {
    const std::size_t at = run.nearest_to(k), i = run.index_in(at);
    const File& file = files[at];
    if (file.unoriented[i]) key.unoriented.push_back(key.pose.position.size());
    Eigen::Vector3d position = file.discs.pose.position[i];
    if (at != k && !file.set.velocity.empty())
      position += (files[k].frame - file.frame) * scale * file.set.velocity[i].cast<double>();
    key.pose.position.push_back(position);
    key.pose.axis_u.push_back(file.discs.pose.axis_u[i]);
    key.pose.axis_v.push_back(file.discs.pose.axis_v[i]);
  }
  return key;
}

/// Colours and opacities of the runs beyond those that `cloud` has.
void add_looks(const std::vector<Run>& runs, const std::vector<File>& files, std::size_t nearest,
               const CloudSource& source, SurfelCloud& cloud) {
  const std::size_t had = files[nearest].set.size();
  for (std::size_t r = had; r < runs.size(); ++r) {
    const std::size_t at = runs[r].nearest_to(nearest), i = runs[r].index_in(at);
    const File& file = files[at];
    if (cloud.color.empty() && !file.set.color.empty()) cloud.color.assign(r, Eigen::Vector3f::Ones());
    if (cloud.opacity.empty() && !file.set.opacity.empty()) cloud.opacity.assign(r, 1.0f);
    if (!cloud.color.empty()) {
      Eigen::Vector3f color = Eigen::Vector3f::Ones();
      if (source.color) {
        color = *source.color;
      } else if (source.color_by_normals) {
        const Eigen::Vector3f normal =
            file.discs.pose.axis_u[i].cross(file.discs.pose.axis_v[i]).stableNormalized();
        const bool away =
            file.unoriented[i] && normal.dot(source.normals_toward.stableNormalized().cast<float>()) < 0.0f;
        color = 0.5f * ((away ? -normal : normal) + Eigen::Vector3f::Ones());
      } else if (!file.set.color.empty()) {
        color = file.set.color[i];
      }
      cloud.color.push_back(color);
    }
    const bool known = file.discs.oriented && !file.unoriented[i];
    if (cloud.oriented.empty() && known) cloud.oriented.assign(r, 0);
    if (!cloud.oriented.empty()) cloud.oriented.push_back(known ? 1 : 0);
    if (!cloud.opacity.empty())
      cloud.opacity.push_back(file.set.opacity.empty() ? 1.0f : file.set.opacity[i]);
  }
}

/// What all runs look like at file `k`; a run that is not there, as in the nearest file that has it.
LookKey look_at(const std::vector<Run>& runs, const std::vector<File>& files, std::size_t k,
                const CloudSource& source, const SurfelCloud& cloud) {
  std::vector<Eigen::Vector3f> color(cloud.color.begin(), cloud.color.end());
  std::vector<float> opacity(cloud.opacity.begin(), cloud.opacity.end());
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const std::size_t at = runs[r].nearest_to(k), i = runs[r].index_in(at);
    const PointSet& set = files[at].set;
    if (!color.empty() && !set.color.empty()) color[r] = set.color[i];
    if (!opacity.empty() && !set.opacity.empty()) opacity[r] = set.opacity[i];
  }
  return look_of(source, cloud, files[k].frame, std::move(color), std::move(opacity));
}

}  // namespace

Status take_lives(const CloudSource& source, const KeySpan& span, double first, double last,
                  LoadedCloud& loaded) {
  Result<std::vector<File>> read = read_files(source, span);
  if (!read) return read.error();
  const std::vector<File>& files = *read;
  const std::size_t nearest = span.nearest - span.begin, had = files[nearest].set.size();
  std::vector<Run> runs = runs_of(files, nearest);
  const auto is_seen = [&](const Lifetime& life) {
    return life.born <= first ? first < life.gone : life.born < last;
  };
  // Those of the nearest file stay whatever happens: colours go by them.
  const auto unseen = std::remove_if(runs.begin() + static_cast<std::ptrdiff_t>(had), runs.end(),
                                     [&](const Run& run) { return !is_seen(life_of(run, files)); });
  const auto unseen_count = static_cast<std::size_t>(runs.end() - unseen);
  runs.erase(unseen, runs.end());
  std::vector<Lifetime> lives;
  std::size_t changing = 0;
  for (const Run& run : runs) {
    lives.push_back(life_of(run, files));
    if (lives.back().born > first || lives.back().gone <= last) ++changing;
  }
  if (changing == 0) return Done{};

  SurfelCloud& cloud = loaded.cloud;
  add_looks(runs, files, nearest, source, cloud);
  cloud.keys.clear();
  for (std::size_t k = 0; k < files.size(); ++k)
    push_key(key_of(runs, files, k, velocity_scale(source)), files[k].frame, cloud);
  std::vector<LookKey> looks;
  for (std::size_t k = 0; k < files.size(); ++k) looks.push_back(look_at(runs, files, k, source, cloud));
  take_looks(std::move(looks), cloud);
  cloud.lifetime = std::move(lives);
  std::vector<std::string>& assumed = loaded.report.assumed;
  std::erase_if(assumed, [](const std::string& line) { return line.ends_with(", and are left out"); });
  assumed.push_back(std::to_string(changing) +
                    " points come or go while the shutter is open: they exist until, and from, halfway "
                    "between a file that has them and one that lacks them");
  if (unseen_count > 0)
    assumed.push_back(std::to_string(unseen_count) + " points are there before or after it alone");
  return Done{};
}

}  // namespace swept::io
