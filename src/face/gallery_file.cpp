#include <sstream>
#include <utility>

#include <yaml-cpp/yaml.h>

#include "extperfc/base/atomic_file.hpp"
#include "extperfc/base/number_reader.hpp"
#include "extperfc/face/gallery.hpp"
#include "extperfc/world/yaml_map.hpp"

namespace extperfc::face {

namespace {

constexpr int kFormat = 1;

/// One text for all numbers of a feature: a list of thousands of YAML nodes would take much memory.
std::string text_of(const Feature& feature) {
  std::string text;
  for (const float value : feature) text += (text.empty() ? "" : " ") + number_text(value);
  return text;
}

/// Empty: not numbers.
std::optional<Feature> feature_of(const std::string& text) {
  Feature feature;
  TokenReader reader(text);
  for (auto token = reader.token(); !token.empty(); token = reader.token()) {
    const auto value = parse_number(token);
    if (!value) return std::nullopt;
    feature.push_back(static_cast<float>(*value));
  }
  return feature;
}

/// False, with a problem noted, when the file's features are not those of `spec`.
bool is_of_embedder(YamlMap& root, const GallerySpec& spec) {
  const int format = root.integer("format", 1, kFormat);
  const std::string embedder = root.text("embedder");
  const int size = root.integer("size", 1, 1'000'000);
  if (!root.problems().empty() || format != kFormat) return false;
  if (embedder == spec.embedder && static_cast<std::size_t>(size) == spec.size) return true;
  root.problem("embedder", "its features are of \"" + embedder + "\" with " + std::to_string(size) +
                               " numbers, but \"" + spec.embedder + "\" with " + std::to_string(spec.size) +
                               " is in use: use that embedder, or another gallery file and enroll again");
  return false;
}

void read_person(YamlMap& person, Gallery& gallery) {
  const std::string name = person.text("name");
  for (const auto& text : person.texts("features")) {
    auto feature = feature_of(text);
    if (!feature) {
      person.problem("features", "must be texts of numbers: remove this name, and enroll it again");
      continue;
    }
    if (auto added = gallery.add(name, std::move(*feature)); !added)
      person.problem("features", added.error().message + ": remove this name, and enroll it again");
  }
  person.refuse_unknown();
}

}  // namespace

Result<void> save_gallery(const Gallery& gallery, const std::filesystem::path& file) {
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "format" << YAML::Value << kFormat;
  out << YAML::Key << "embedder" << YAML::Value << YAML::DoubleQuoted << gallery.spec().embedder;
  out << YAML::Key << "size" << YAML::Value << gallery.spec().size;
  out << YAML::Key << "people" << YAML::Value << YAML::BeginSeq;
  for (const auto& [name, features] : gallery.people()) {
    out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << name;
    out << YAML::Key << "features" << YAML::Value << YAML::BeginSeq;
    for (const auto& feature : features) out << YAML::DoubleQuoted << text_of(feature);
    out << YAML::EndSeq << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  return write_text_atomically(file, std::string(out.c_str()) + "\n");
}

Result<Gallery> load_gallery(const std::filesystem::path& file, const GallerySpec& spec) {
  Problems problems(file.string());
  const auto node = load_yaml(file, problems);
  if (!node) return tl::unexpected(problems.to_error());
  YamlMap root(*node, "", problems);
  Gallery gallery(spec);
  if (!is_of_embedder(root, spec)) return tl::unexpected(problems.to_error());
  for (YamlMap& person : root.maps("people")) read_person(person, gallery);
  root.refuse_unknown();
  if (!problems.empty()) return tl::unexpected(problems.to_error());
  return gallery;
}

}  // namespace extperfc::face
