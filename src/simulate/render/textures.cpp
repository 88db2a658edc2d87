#include "simulate/render/textures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "extperfc/base/math.hpp"

#include "simulate/render/lattice_noise.hpp"

namespace extperfc::simulate {

namespace {

/// Four boards, grain along x.
Colour wood(float x, float y) {
  constexpr int kBoards = 4;
  const float across = y * kBoards;
  const int board = static_cast<int>(across);
  const float shift = cell(31, board, 0);
  const float sx = x + shift - std::floor(x + shift);
  const float bend = octaves(32, sx, y, 2, 8, 3);
  const float rings = 0.5F + 0.5F * std::sin(kTwoPiF * (9.0F * y + 2.6F * bend + 7.0F * shift));
  const float fibres = octaves(36, sx, y, 6, 128, 2);
  const Colour light{1.0F, 0.93F, 0.83F};
  const Colour dark{0.80F, 0.68F, 0.55F};
  Colour colour = mix(light, dark, 0.55F * rings * rings + 0.35F * fibres);
  const float in_board = across - static_cast<float>(board);
  const float joint = std::min(in_board, 1.0F - in_board);
  colour = scaled(colour, 0.90F + 0.10F * cell(33, board, 1));
  return scaled(colour, 0.72F + 0.28F * smooth_step(0.0F, 0.025F, joint));
}

/// Two by two tiles with joints.
Colour tiles(float x, float y) {
  const float fx = 2 * x;
  const float fy = 2 * y;
  const int ix = static_cast<int>(fx);
  const int iy = static_cast<int>(fy);
  const float dx = std::abs(fx - static_cast<float>(ix) - 0.5F);
  const float dy = std::abs(fy - static_cast<float>(iy) - 0.5F);
  const float to_joint = 0.5F - std::max(dx, dy);
  const float tone = 0.88F + 0.07F * cell(41, ix, iy);
  const float cloud = octaves(42, x, y, 6, 6, 4);
  const float speck = lattice(47, x, y, 170, 170) > 0.86F ? -0.05F : 0.0F;
  const Colour tile = scaled({1.0F, 0.985F, 0.96F}, tone + 0.09F * (cloud - 0.5F) + speck);
  const float bevel = 0.94F + 0.06F * smooth_step(0.012F, 0.03F, to_joint);
  return mix(grey(0.60F), scaled(tile, bevel), smooth_step(0.006F, 0.014F, to_joint));
}

Colour plaster(float x, float y) {
  const float broad = octaves(51, x, y, 4, 4, 4);
  const float grain = lattice(57, x, y, 128, 128) + lattice(58, x, y, 256, 256);
  return grey(0.93F + 0.06F * (broad - 0.5F) + 0.035F * (grain - 1.0F));
}

/// Plain weave of 64 x 64 threads.
Colour cloth(float x, float y) {
  constexpr int kThreads = 64;
  const float fx = x * kThreads;
  const float fy = y * kThreads;
  const int ix = static_cast<int>(fx);
  const int iy = static_cast<int>(fy);
  const bool warp = ((ix + iy) & 1) == 0;
  const float along = warp ? fy - static_cast<float>(iy) : fx - static_cast<float>(ix);
  const float across = warp ? fx - static_cast<float>(ix) : fy - static_cast<float>(iy);
  const float round = std::sqrt(std::max(0.0F, 1.0F - 3.2F * (across - 0.5F) * (across - 0.5F)));
  const float dip = std::sin(0.5F * kTwoPiF * along);
  const float thread = 0.92F + 0.08F * cell(61, warp ? ix : iy, warp ? 0 : 1);
  const float fold = octaves(62, x, y, 3, 3, 3);
  return grey(thread * (0.66F + 0.24F * round * (0.55F + 0.45F * dip) + 0.12F * fold));
}

Colour carpet(float x, float y) {
  const float tuft = 0.6F * lattice(71, x, y, 128, 128) + 0.4F * lattice(72, x, y, 256, 256);
  const float worn = octaves(73, x, y, 3, 3, 3);
  return scaled({1.0F, 0.98F, 0.97F}, 0.62F + 0.30F * tuft + 0.12F * worn);
}

Colour marble(float x, float y) {
  const float warp = octaves(81, x, y, 4, 4, 5);
  const float vein = std::abs(std::sin(0.5F * kTwoPiF * (2.0F * x + 1.0F * y + 2.4F * warp)));
  const float fine =
      std::abs(std::sin(0.5F * kTwoPiF * (1.0F * x - 3.0F * y + 3.1F * octaves(87, x, y, 5, 5, 4))));
  const float dark = 0.30F * std::pow(1.0F - vein, 6.0F) + 0.14F * std::pow(1.0F - fine, 10.0F);
  return scaled({0.98F, 0.98F, 1.0F}, 0.96F - dark + 0.05F * (warp - 0.5F));
}

Colour checker(float x, float y) {
  const int odd = (static_cast<int>(2 * x) + static_cast<int>(2 * y)) & 1;
  const float worn = 0.04F * octaves(91, x, y, 8, 8, 3);
  return grey((odd != 0 ? 0.16F : 0.96F) + (odd != 0 ? worn : -worn));
}

constexpr std::array<Colour, 10> kBindings{{{0.55F, 0.13F, 0.12F},
                                            {0.13F, 0.22F, 0.40F},
                                            {0.16F, 0.34F, 0.22F},
                                            {0.76F, 0.66F, 0.46F},
                                            {0.30F, 0.17F, 0.11F},
                                            {0.80F, 0.78F, 0.72F},
                                            {0.12F, 0.12F, 0.14F},
                                            {0.60F, 0.36F, 0.13F},
                                            {0.28F, 0.42F, 0.52F},
                                            {0.48F, 0.16F, 0.30F}}};

/// Backs of 14 books that stand side by side on a board; y is up.
Colour books(float x, float y) {
  constexpr int kBooks = 14;
  int book = 0;
  float left = 0;
  float width = 0;
  float total = 0;
  for (int i = 0; i < kBooks; ++i) total += 0.6F + 0.9F * cell(101, i, 0);
  for (float right = 0; book < kBooks; ++book, left = right) {
    width = (0.6F + 0.9F * cell(101, book, 0)) / total;
    right = left + width;
    if (x < right || book == kBooks - 1) break;
  }
  const float height = 0.74F + 0.20F * cell(102, book, 0);
  if (y > height) return scaled({0.20F, 0.16F, 0.13F}, 0.5F + 0.5F * (1.0F - y));
  const float across = std::clamp((x - left) / width, 0.0F, 1.0F);
  const float edge = std::min(across, 1.0F - across) * width;
  Colour colour = kBindings[static_cast<std::size_t>(cell(103, book, 0) * kBindings.size())];
  const float band = std::abs(y - height * (0.72F + 0.12F * cell(104, book, 0)));
  const float low_band = std::abs(y - 0.12F);
  const bool title = cell(106, book, 0) > 0.35F && std::abs(across - 0.5F) < 0.16F && y > 0.25F * height &&
                     y < 0.62F * height && lattice(107, x, y, 32, 70) > 0.35F;
  if (band < 0.014F || (cell(105, book, 0) > 0.5F && low_band < 0.01F) || title)
    colour = mix(colour, {0.90F, 0.80F, 0.55F}, 0.75F);
  const float round = 0.62F + 0.38F * std::sqrt(1.0F - 0.8F * (2 * across - 1) * (2 * across - 1));
  return scaled(colour, round * (0.92F + 0.16F * lattice(108, x, y, 200, 40)) * smooth_step(0, 0.003F, edge));
}

Colour stripes(float x, float y) {
  const float along = 4 * x + 0.04F * (lattice(201, x, y, 6, 6) - 0.5F);
  const float at = along - std::floor(along);
  const float tone = smooth_step(0.0F, 0.02F, at) - smooth_step(0.5F, 0.52F, at);
  return grey(0.22F + 0.75F * tone);
}

Colour dots(float x, float y) {
  const float fx = 4 * x;
  const float fy = 4 * y;
  const float dx = fx - std::floor(fx) - 0.5F;
  const float dy = fy - std::floor(fy) - 0.5F;
  return grey(0.2F + 0.77F * smooth_step(0.25F, 0.28F, std::hypot(dx, dy)));
}

/// A vivid or dark colour of a palette that cells choose from.
Colour print_colour(std::uint32_t layer, int i, int j) {
  const auto channel = [&](std::uint32_t c) {
    return 0.08F + 0.9F * cell(layer + c, i, j) * cell(layer + 7 + c, i, j);
  };
  return {channel(0), channel(1), channel(2)};
}

/// Two columns and three rows of labels: a ground, a bar, writing, a disc.
Colour print(float x, float y) {
  const int column = static_cast<int>(2 * x);
  const int row = static_cast<int>(3 * y);
  const float u = 2 * x - static_cast<float>(column);
  const float v = 3 * y - static_cast<float>(row);
  const bool pale = cell(211, column, row) > 0.4F;
  Colour colour = pale ? grey(0.93F) : print_colour(212, column, row);
  const float bar = 0.2F + 0.6F * cell(231, column, row);
  if (std::abs(v - bar) < 0.13F) colour = print_colour(240, column, row);
  const bool writing = u > 0.12F && u < 0.3F + 0.6F * cell(232, column, static_cast<int>(18 * v)) &&
                       static_cast<int>(18 * v) % 2 == 0 && lattice(233, x, y, 150, 54) > 0.4F;
  if (writing) colour = pale ? grey(0.12F) : grey(0.95F);
  const float disc = std::hypot(u - 0.25F - 0.5F * cell(234, column, row), (v - 0.5F) * 0.7F);
  if (disc < 0.16F && cell(235, column, row) > 0.4F) colour = print_colour(260, column, row);
  return colour;
}

Colour poster(float x, float y) {
  const auto channel = [&](std::uint32_t layer) {
    const float broad = octaves(layer, x, y, 3, 3, 5);
    return std::clamp(0.5F + 1.9F * (broad - 0.5F), 0.03F, 1.0F);
  };
  const float edge = octaves(301, x, y, 5, 5, 4) > 0.52F ? 0.6F : 1.0F;
  return scaled({channel(281), channel(287), channel(293)}, edge);
}

Colour blotches(float x, float y) {
  const float spot = smooth_step(0.48F, 0.56F, octaves(311, x, y, 5, 5, 3));
  return mix({1.0F, 0.98F, 0.94F}, {0.35F, 0.26F, 0.2F}, spot);
}

/// Dark panels scattered on light ones, and seams.
Colour ball(float x, float y) {
  const float fx = 5 * x;
  const float fy = 3 * y;
  const int row = static_cast<int>(fy);
  const float shifted = fx + (row % 2 != 0 ? 0.5F : 0.0F);
  const float dx = shifted - std::floor(shifted) - 0.5F;
  const float dy = fy - static_cast<float>(row) - 0.5F;
  const float edge = std::max(std::abs(dx) + 0.5F * std::abs(dy), std::abs(dy));
  if (edge < 0.26F) return grey(0.1F);
  return grey(std::abs(dx) > 0.475F || std::abs(dy) > 0.48F ? 0.35F : 0.97F);
}

Colour pips(float x, float y) {
  constexpr std::array<std::array<float, 2>, 5> kPlaces{
      {{0.5F, 0.5F}, {0.25F, 0.25F}, {0.75F, 0.75F}, {0.25F, 0.75F}, {0.75F, 0.25F}}};
  for (const auto& place : kPlaces)
    if (std::hypot(x - place[0], y - place[1]) < 0.09F) return grey(0.08F);
  const float edge = std::min(std::min(x, 1 - x), std::min(y, 1 - y));
  return grey(0.8F + 0.2F * smooth_step(0.0F, 0.05F, edge));
}

Colour gradient(float x, float y) {
  const float bright = 0.5F + 0.5F * std::cos(kTwoPiF * y);
  const float glint = smooth_step(0.9F, 1.0F, 0.5F + 0.5F * std::cos(kTwoPiF * (x - 0.2F)));
  return grey(std::min(1.0F, 0.45F + 0.45F * bright + 0.3F * glint));
}

Colour pattern(Texture texture, float x, float y) {
  switch (texture) {
    case Texture::kWood:
      return wood(x, y);
    case Texture::kTiles:
      return tiles(x, y);
    case Texture::kPlaster:
      return plaster(x, y);
    case Texture::kCloth:
      return cloth(x, y);
    case Texture::kCarpet:
      return carpet(x, y);
    case Texture::kMarble:
      return marble(x, y);
    case Texture::kChecker:
      return checker(x, y);
    case Texture::kStripes:
      return stripes(x, y);
    case Texture::kDots:
      return dots(x, y);
    case Texture::kPrint:
      return print(x, y);
    case Texture::kPoster:
      return poster(x, y);
    case Texture::kBlotches:
      return blotches(x, y);
    case Texture::kBall:
      return ball(x, y);
    case Texture::kPips:
      return pips(x, y);
    case Texture::kGradient:
      return gradient(x, y);
    case Texture::kBooks:
      return books(x, y);
    case Texture::kNone:
      break;
  }
  return grey(1.0F);
}

template <Texture kKind>
const MipTexture* made_once() {
  static const MipTexture texture = make_mip_texture([](float x, float y) { return pattern(kKind, x, y); });
  return &texture;
}

}  // namespace

const MipTexture* texture_of(Texture texture) {
  switch (texture) {
    case Texture::kWood:
      return made_once<Texture::kWood>();
    case Texture::kTiles:
      return made_once<Texture::kTiles>();
    case Texture::kPlaster:
      return made_once<Texture::kPlaster>();
    case Texture::kCloth:
      return made_once<Texture::kCloth>();
    case Texture::kCarpet:
      return made_once<Texture::kCarpet>();
    case Texture::kMarble:
      return made_once<Texture::kMarble>();
    case Texture::kChecker:
      return made_once<Texture::kChecker>();
    case Texture::kStripes:
      return made_once<Texture::kStripes>();
    case Texture::kDots:
      return made_once<Texture::kDots>();
    case Texture::kPrint:
      return made_once<Texture::kPrint>();
    case Texture::kPoster:
      return made_once<Texture::kPoster>();
    case Texture::kBlotches:
      return made_once<Texture::kBlotches>();
    case Texture::kBall:
      return made_once<Texture::kBall>();
    case Texture::kPips:
      return made_once<Texture::kPips>();
    case Texture::kGradient:
      return made_once<Texture::kGradient>();
    case Texture::kBooks:
      return made_once<Texture::kBooks>();
    case Texture::kNone:
      break;
  }
  return nullptr;
}

}  // namespace extperfc::simulate
