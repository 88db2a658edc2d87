#include "simulate/worlds/material_reader.hpp"

#include <vector>

#include "extperfc/base/text.hpp"

#include "simulate/worlds/materials.hpp"

namespace extperfc::simulate {

namespace {

/// "#c02020".
std::optional<Eigen::Vector3f> colour_from_hex(const std::string& text) {
  if (text.size() != 7 || text[0] != '#' ||
      text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos)
    return std::nullopt;
  const unsigned long value = std::stoul(text.substr(1), nullptr, 16);
  const auto part = [value](int shift) { return static_cast<float>((value >> shift) & 255U) / 255.0F; };
  return Eigen::Vector3f(part(16), part(8), part(0));
}

void change(YamlMap& map, Material& material) {
  material.colour = read_colour(map, "colour", material.colour);
  const std::string texture = map.text("texture", to_string(material.texture));
  if (const auto known = texture_from(texture))
    material.texture = *known;
  else
    map.problem("texture", "unknown texture \"" + texture + "\"" + hint_for(texture, texture_names()) +
                               ": use one of " + joined(texture_names()));
  material.texture_size_m = static_cast<float>(
      map.number("texture_size", {0.005, 100}, static_cast<double>(material.texture_size_m)));
  material.gloss = static_cast<float>(map.number("gloss", kFraction, static_cast<double>(material.gloss)));
}

}  // namespace

Eigen::Vector3f read_colour(YamlMap& map, const std::string& key, const Eigen::Vector3f& fallback) {
  const auto found = map.node(key);
  if (!found) return fallback;
  if (found->IsSequence()) return map.vector3(key, kFraction).cast<float>();
  const std::string name = found->IsScalar() ? found->Scalar() : "";
  if (const auto colour = colour_from_name(name)) return *colour;
  if (const auto colour = colour_from_hex(name)) return *colour;
  map.problem(key, "unknown colour " + shown(*found) + hint_for(name, colour_names()) +
                       ": use [r, g, b] from 0 to 1, \"#rrggbb\" or one of " + joined(colour_names()));
  return fallback;
}

MaterialReader::MaterialReader() : materials_(known_materials()) {}

void MaterialReader::read_own(YamlMap& world) {
  YamlMap section = world.section("materials");
  for (const auto& entry : section.items()) {
    YamlMap map(entry.value, section.path(entry.key), world.problems());
    Material own = read_named(map, "like", "plain");
    change(map, own);
    map.refuse_unknown();
    materials_[entry.key] = own;
  }
}

Material MaterialReader::read_named(YamlMap& map, const std::string& key, const std::string& fallback) const {
  const std::string name = map.text(key, fallback);
  const auto found = materials_.find(name);
  if (found != materials_.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [known, material] : materials_) names.push_back(known);
  map.problem(key, "unknown material \"" + name + "\"" + hint_for(name, names) + ": use one of " +
                       joined(names) + ", or describe it under `materials`");
  return materials_.at("plain");
}

Material MaterialReader::read(YamlMap& map, const std::string& fallback) const {
  Material material = read_named(map, "material", fallback);
  change(map, material);
  return material;
}

}  // namespace extperfc::simulate
