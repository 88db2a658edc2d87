#include "simulate/worlds/random_look.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulate/worlds/materials.hpp"

namespace extperfc::simulate {

namespace {

template <std::size_t N>
Texture one_of(Rng& rng, const std::array<Texture, N>& textures) {
  return textures.at(static_cast<std::size_t>(rng.integer(0, static_cast<int>(N) - 1)));
}

float random_float(Rng& rng, double low, double high) {
  return static_cast<float>(rng.uniform(low, high));
}

/// Colours of wood: from pale to dark brown.
Eigen::Vector3f wood_colour(Rng& rng) {
  const double value = rng.uniform(0.3, 0.92);
  const double saturation = rng.uniform(0.3, 0.6);
  return colour_from_hsv(rng.uniform(0.055, 0.1), saturation, value);
}

}  // namespace

Eigen::Vector3f colour_from_hsv(double hue, double saturation, double value) {
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + hue * 6, 6.0);
    return static_cast<float>(value - value * saturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
  };
  return {channel(5), channel(3), channel(1)};
}

Eigen::Vector3f random_colour(Rng& rng, const ColourRange& range) {
  // One after the other: the order in which arguments are computed is the compiler's choice.
  const double hue = rng.uniform(0, 1);
  const double saturation = rng.uniform(range.saturation_low, range.saturation_high);
  const double value = rng.uniform(range.value_low, range.value_high);
  return colour_from_hsv(hue, saturation, value);
}

Material random_paint(Rng& rng) {
  Material paint;
  const double kind = rng.uniform(0, 1);
  if (kind < 0.55)
    paint.colour = random_colour(rng, {0.6, 1.0, 0.45, 0.95});
  else if (kind < 0.75)
    paint.colour = random_colour(rng, {0.1, 0.5, 0.6, 0.95});
  else if (kind < 0.85)
    paint.colour = random_colour(rng, {0, 0.06, 0.1, 0.95});
  else
    paint.colour = wood_colour(rng);
  if (kind >= 0.85) paint.texture = Texture::kWood;
  if (rng.chance(0.22))
    paint.texture = one_of<6>(rng, {Texture::kChecker, Texture::kMarble, Texture::kCloth, Texture::kPlaster,
                                    Texture::kWood, Texture::kTiles});
  paint.texture_size_m = random_float(rng, 0.03, 0.2);
  paint.gloss = rng.chance(0.5) ? random_float(rng, 0, 0.7) : 0.05F;
  return paint;
}

Material random_wall(Rng& rng) {
  Material wall;
  const bool pale = rng.chance(0.75);
  wall.colour =
      random_colour(rng, pale ? ColourRange{0, 0.12, 0.5, 0.95} : ColourRange{0.1, 0.45, 0.5, 0.95});
  wall.texture = rng.chance(0.7) ? Texture::kPlaster
                                 : one_of<5>(rng, {Texture::kNone, Texture::kCloth, Texture::kTiles,
                                                   Texture::kWood, Texture::kMarble});
  wall.texture_size_m = random_float(rng, 0.4, 2);
  return wall;
}

Material random_floor(Rng& rng) {
  Material floor;
  floor.texture = one_of<6>(rng, {Texture::kWood, Texture::kWood, Texture::kTiles, Texture::kCarpet,
                                  Texture::kMarble, Texture::kPlaster});
  floor.colour = floor.texture == Texture::kWood ? wood_colour(rng) : random_colour(rng, {0, 0.4, 0.2, 0.95});
  floor.texture_size_m = random_float(rng, 0.4, 1.8);
  floor.gloss = random_float(rng, 0, 0.25);
  return floor;
}

Material random_table_top(Rng& rng) {
  Material top;
  top.texture =
      one_of<9>(rng, {Texture::kWood, Texture::kWood, Texture::kWood, Texture::kNone, Texture::kNone,
                      Texture::kCloth, Texture::kMarble, Texture::kChecker, Texture::kPlaster});
  top.colour = top.texture == Texture::kWood ? wood_colour(rng) : random_colour(rng, {0, 0.7, 0.2, 0.95});
  top.texture_size_m = random_float(rng, 0.15, 0.9);
  top.gloss = random_float(rng, 0, 0.4);
  return top;
}

Material random_furniture(Rng& rng) {
  if (rng.chance(0.5)) return {wood_colour(rng), Texture::kWood, random_float(rng, 0.4, 0.9), 0.1F};
  return {random_colour(rng, {0, 0.6, 0.2, 0.95}), Texture::kNone, 1.0F, random_float(rng, 0, 0.3)};
}

LightSpec random_light(Rng& rng, const Eigen::Vector2d& room_min_m, const Eigen::Vector2d& room_max_m,
                       double ceiling_m) {
  LightSpec light;
  const Eigen::Vector2d size = room_max_m - room_min_m;
  light.position_m.x() = room_min_m.x() + size.x() * rng.uniform(0.1, 0.9);
  light.position_m.y() = room_min_m.y() + size.y() * rng.uniform(0.1, 0.9);
  light.position_m.z() = rng.uniform(ceiling_m * 0.72, ceiling_m - 0.05);
  const double total = std::clamp(rng.normal(1.0, 0.17), 0.6, 1.4);
  const double fraction = rng.uniform(0.3, 0.75);
  light.direct = static_cast<float>(total * fraction);
  light.ambient = static_cast<float>(total * (1 - fraction));
  light.sky = random_colour(rng, {0, 0.2, 0.6, 1});
  return light;
}

}  // namespace extperfc::simulate
