#include "simulate/worlds/materials.hpp"

namespace extperfc::simulate {

namespace {

const std::map<std::string, Eigen::Vector3f>& colours() {
  static const std::map<std::string, Eigen::Vector3f> list{
      {"red", {0.80F, 0.11F, 0.10F}},        {"green", {0.13F, 0.55F, 0.20F}},
      {"blue", {0.10F, 0.27F, 0.72F}},       {"yellow", {0.95F, 0.78F, 0.10F}},
      {"orange", {0.95F, 0.45F, 0.06F}},     {"purple", {0.47F, 0.18F, 0.60F}},
      {"pink", {0.93F, 0.45F, 0.60F}},       {"cyan", {0.10F, 0.65F, 0.72F}},
      {"teal", {0.06F, 0.42F, 0.42F}},       {"lime", {0.58F, 0.80F, 0.20F}},
      {"navy", {0.10F, 0.14F, 0.34F}},       {"maroon", {0.42F, 0.08F, 0.12F}},
      {"brown", {0.42F, 0.27F, 0.15F}},      {"tan", {0.80F, 0.68F, 0.50F}},
      {"beige", {0.90F, 0.85F, 0.74F}},      {"white", {0.93F, 0.93F, 0.92F}},
      {"light_grey", {0.75F, 0.75F, 0.76F}}, {"grey", {0.50F, 0.50F, 0.51F}},
      {"dark_grey", {0.26F, 0.27F, 0.28F}},  {"black", {0.07F, 0.07F, 0.08F}},
  };
  return list;
}

}  // namespace

std::vector<std::string> texture_names() {
  std::vector<std::string> names;
  for (int i = 0; i <= static_cast<int>(Texture::kBooks); ++i)
    names.emplace_back(to_string(static_cast<Texture>(i)));
  return names;
}

std::optional<Eigen::Vector3f> colour_from_name(const std::string& name) {
  const auto found = colours().find(name);
  if (found == colours().end()) return std::nullopt;
  return found->second;
}

std::vector<std::string> colour_names() {
  std::vector<std::string> names;
  for (const auto& [name, colour] : colours()) names.push_back(name);
  return names;
}

const std::map<std::string, Material>& known_materials() {
  static const std::map<std::string, Material> list{
      {"plain", {{0.70F, 0.70F, 0.70F}, Texture::kNone, 1.0F, 0.05F}},
      {"oak", {{0.76F, 0.58F, 0.38F}, Texture::kWood, 0.6F, 0.12F}},
      {"pine", {{0.88F, 0.74F, 0.52F}, Texture::kWood, 0.6F, 0.08F}},
      {"walnut", {{0.43F, 0.28F, 0.18F}, Texture::kWood, 0.6F, 0.15F}},
      {"parquet", {{0.72F, 0.53F, 0.34F}, Texture::kWood, 1.2F, 0.10F}},
      {"tiles", {{0.80F, 0.79F, 0.76F}, Texture::kTiles, 1.2F, 0.15F}},
      {"dark_tiles", {{0.42F, 0.43F, 0.45F}, Texture::kTiles, 1.2F, 0.15F}},
      {"plaster", {{0.90F, 0.88F, 0.84F}, Texture::kPlaster, 1.5F, 0.0F}},
      {"carpet", {{0.40F, 0.44F, 0.50F}, Texture::kCarpet, 0.8F, 0.0F}},
      {"cloth", {{0.45F, 0.52F, 0.62F}, Texture::kCloth, 0.3F, 0.0F}},
      {"marble", {{0.90F, 0.89F, 0.87F}, Texture::kMarble, 1.0F, 0.3F}},
      {"checker", {{0.90F, 0.90F, 0.90F}, Texture::kChecker, 0.5F, 0.1F}},
      {"carton", {{0.72F, 0.55F, 0.36F}, Texture::kPlaster, 0.5F, 0.0F}},
      {"metal", {{0.62F, 0.64F, 0.66F}, Texture::kNone, 1.0F, 0.5F}},
      {"dark_metal", {{0.25F, 0.26F, 0.28F}, Texture::kNone, 1.0F, 0.4F}},
      {"white", {{0.92F, 0.92F, 0.91F}, Texture::kNone, 1.0F, 0.15F}},
      {"black", {{0.08F, 0.08F, 0.09F}, Texture::kNone, 1.0F, 0.2F}},
  };
  return list;
}

Material shaded(Material material, float factor) {
  material.colour = (material.colour * factor).cwiseMax(0.0F).cwiseMin(1.0F);
  return material;
}

}  // namespace extperfc::simulate
