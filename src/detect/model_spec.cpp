#include "extperfc/detect/model_spec.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "extperfc/base/sha256.hpp"
#include "extperfc/world/yaml_map.hpp"

#include "detect/model_yaml.hpp"

namespace extperfc::detect {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::pair<OutputLayout, const char*>, 8> kLayouts{{
    {OutputLayout::kSsd, "ssd"},
    {OutputLayout::kSsdPriors, "ssd_priors"},
    {OutputLayout::kYoloV7, "yolo_v7"},
    {OutputLayout::kYoloV8, "yolo_v8"},
    {OutputLayout::kYoloAnchors, "yolo_anchors"},
    {OutputLayout::kYoloGrid, "yolo_grid"},
    {OutputLayout::kYunet, "yunet"},
    {OutputLayout::kVector, "vector"},
}};

constexpr const char* kRemedy = "write a model.yaml for it (models/README.md has the format)";

/// Regular files of a folder with this extension, sorted; none when the folder does not exist.
std::vector<fs::path> files_with_extension(const fs::path& folder, const std::string& extension) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file(error) && entry.path().extension() == extension) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::string names_of(const std::vector<fs::path>& files) {
  std::string text;
  for (const auto& file : files) text += (text.empty() ? "" : ", ") + file.filename().string();
  return text;
}

/// Checks the ONNX file against the stated SHA-256, or fills in the sum when none is stated.
void check_file(ModelSpec& spec, Problems& problems) {
  if (!fs::is_regular_file(spec.file)) {
    problems.add(0, "file", "there is no " + spec.file.string() + ": correct the name", ErrorCode::kNotFound);
    return;
  }
  const auto actual = sha256_of_file(spec.file);
  if (!actual)
    problems.add(0, "file", actual.error().message, actual.error().code);
  else if (!spec.sha256.empty() && spec.sha256 != *actual)
    problems.add(0, "sha256",
                 spec.file.filename().string() + " has " + *actual + " instead of " + spec.sha256 +
                     ": fetch the file again, or state the new sum if you changed it",
                 ErrorCode::kCorrupt);
  else
    spec.sha256 = *actual;
}

struct KnownModel {
  fs::path description;
  fs::path network;  ///< empty: wherever the description says
};

Result<ModelSpec> read_description(const KnownModel& model, const fs::path& folder) {
  Problems problems(model.description.string());
  const auto root = load_yaml(model.description, problems);
  if (!root) return tl::unexpected(problems.to_error());
  ModelSpec spec = parse_model_yaml(*root, folder, problems);
  if (!model.network.empty()) spec.file = model.network;
  if (spec.file != folder / "") check_file(spec, problems);
  if (!problems.empty()) return tl::unexpected(problems.to_error());
  spec.file = fs::absolute(spec.file);
  return spec;
}

/// Every pair of a description and an ONNX file that has the SHA-256 it states.
Result<std::vector<KnownModel>> match_known(const std::vector<fs::path>& networks, const fs::path& known) {
  std::vector<KnownModel> matches;
  for (const auto& description : files_with_extension(known, ".yaml")) {
    Problems problems(
        description.string());  // of the content: reported by read_description() if this is the one
    const auto root = load_yaml(description, problems);
    if (!root) return tl::unexpected(problems.to_error());
    const std::string wanted = YamlMap(*root, "", problems).text("sha256", "");
    for (const auto& network : networks)
      if (sha256_of_file(network).value_or("") == wanted) matches.push_back({description, network});
  }
  return matches;
}

/// The one known network among the ONNX files of a folder that has no model.yaml.
Result<KnownModel> recognise(const fs::path& folder, const fs::path& known_models) {
  const auto networks = files_with_extension(folder, ".onnx");
  if (networks.empty())
    return fail(ErrorCode::kNotFound, folder.string() + " has neither model.yaml nor an ONNX file");
  const auto matches = match_known(networks, known_models);
  if (!matches) return tl::unexpected(matches.error());
  if (matches->empty())
    return fail(ErrorCode::kNotFound, folder.string() + " has no model.yaml, and " + names_of(networks) +
                                          " is no known public network: " + kRemedy);
  if (matches->size() == 1) return matches->front();
  std::string list;
  for (const auto& [description, network] : *matches)
    list +=
        (list.empty() ? "" : ", ") + network.filename().string() + " (" + description.stem().string() + ")";
  return fail(ErrorCode::kInvalidArgument, folder.string() +
                                               " has no model.yaml and several known networks, " + list +
                                               ": keep one, or " + kRemedy);
}

}  // namespace

Result<OutputLayout> layout_from_name(const std::string& name) {
  std::string all;
  for (const auto& [layout, known_name] : kLayouts) {
    if (name == known_name) return layout;
    all += (all.empty() ? "" : ", ") + std::string(known_name);
  }
  return fail(ErrorCode::kUnsupported, "unknown layout \"" + name + "\": use one of " + all);
}

const char* to_string(OutputLayout layout) {
  for (const auto& [candidate, known_name] : kLayouts)
    if (candidate == layout) return known_name;
  return "unknown";
}

Result<ModelSpec> load_model_spec(const fs::path& folder, const fs::path& known_models) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    return fail(ErrorCode::kNotFound,
                "there is no model folder " + folder.string() +
                    (fs::exists(folder, ignored) ? " (it is a file: name its folder)" : ""));
  const fs::path description = folder / "model.yaml";
  if (fs::exists(description, ignored)) return read_description({description, {}}, folder);
  const auto known = recognise(folder, known_models);
  if (!known) return tl::unexpected(known.error());
  return read_description(*known, folder);
}

}  // namespace extperfc::detect
