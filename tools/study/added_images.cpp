#include "tools/study/added_images.h"

#include <cstddef>

#include <fmt/core.h>

#include "splat/io/image_file.h"
#include "tools/study/cell.h"
#include "tools/study/difference_map.h"

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

/// The cell of an image, and its previews.
Result<Json> cell_of(const AddedImage& added, const std::string& id, const std::string& scene,
                     const Image& reference, const std::string& folder) {
  Cell cell;
  cell.setting = {id, 0};
  const Result<Image> image = read_exr(added.path);
  if (!image) {
    cell.error = image.error().message();
  } else if (const Result<Accuracy> accuracy = accuracy_of(*image, reference); !accuracy) {
    cell.error = accuracy.error().message();
  } else {
    cell.accuracy = *accuracy;
  }
  Json json = to_json(cell);
  json["id"] = id;
  json["setting"] = json["label"] = "";
  json["pareto"] = false;
  if (!cell.error.empty()) return json;
  const std::string picture = fmt::format("images/{}/{}.png", scene, id),
                    difference = fmt::format("images/{}/{}.difference.png", scene, id);
  if (const Status written = write_png(folder + '/' + picture, *image); !written) return written.error();
  if (const Status written = write_png(folder + '/' + difference, difference_map(*image, reference));
      !written)
    return written.error();
  json["image"] = picture;
  json["difference"] = difference;
  return json;
}

}  // namespace

Status add_images(const std::vector<AddedImage>& images, const std::string& folder, Json& document) {
  if (images.empty()) return Done{};
  Json* scene = document["scenes"].empty() ? nullptr : &document["scenes"].front();
  // Beside its preview.
  std::string path;
  if (scene != nullptr && (*scene)["reference"].contains("image"))
    path = (*scene)["reference"]["image"].get<std::string>();
  if (path.ends_with(".png")) path = folder + '/' + path.substr(0, path.size() - 4) + ".exr";
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::string id = fmt::format("added-{}", i + 1);
    document["methods"].push_back({{"id", id},
                                   {"name", images[i].name},
                                   {"description", "Added: " + images[i].path + "."},
                                   {"unit", ""}});
    if (path.empty()) continue;
    const Result<Image> reference = read_exr(path);
    if (!reference) return reference.error();
    Result<Json> cell = cell_of(images[i], id, (*scene)["id"].get<std::string>(), *reference, folder);
    if (!cell) return cell.error();
    (*scene)["cells"].push_back(*std::move(cell));
  }
  return Done{};
}

}  // namespace swept
