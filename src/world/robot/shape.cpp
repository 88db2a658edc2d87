#include "extperfc/world/shape.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace extperfc {

namespace {

constexpr std::array<std::pair<Texture, const char*>, 17> kTextureNames{{{Texture::kNone, "none"},
                                                                         {Texture::kWood, "wood"},
                                                                         {Texture::kTiles, "tiles"},
                                                                         {Texture::kPlaster, "plaster"},
                                                                         {Texture::kCloth, "cloth"},
                                                                         {Texture::kCarpet, "carpet"},
                                                                         {Texture::kMarble, "marble"},
                                                                         {Texture::kChecker, "checker"},
                                                                         {Texture::kStripes, "stripes"},
                                                                         {Texture::kDots, "dots"},
                                                                         {Texture::kPrint, "print"},
                                                                         {Texture::kPoster, "poster"},
                                                                         {Texture::kBlotches, "blotches"},
                                                                         {Texture::kBall, "ball"},
                                                                         {Texture::kPips, "pips"},
                                                                         {Texture::kGradient, "gradient"},
                                                                         {Texture::kBooks, "books"}}};

}  // namespace

const char* to_string(Texture texture) {
  const auto* const found = std::find_if(kTextureNames.begin(), kTextureNames.end(),
                                         [&](const auto& entry) { return entry.first == texture; });
  return found == kTextureNames.end() ? "unknown" : found->second;
}

std::optional<Texture> texture_from(std::string_view name) {
  const auto* const found = std::find_if(kTextureNames.begin(), kTextureNames.end(),
                                         [&](const auto& entry) { return name == entry.second; });
  if (found == kTextureNames.end()) return std::nullopt;
  return found->first;
}

}  // namespace extperfc
