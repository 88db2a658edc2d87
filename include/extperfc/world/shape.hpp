#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"

namespace extperfc {

/// Shapes are centred on their origin; cylinder and cone stand along z (a cone's tip at +height/2), as in
/// URDF.
struct Box {
  Eigen::Vector3d size_m{Eigen::Vector3d::Ones()};  ///< full lengths of the edges
};
struct Cylinder {
  double radius_m{0};
  double length_m{0};
};
struct Sphere {
  double radius_m{0};
};
struct Cone {
  double radius_m{0};
  double height_m{0};
};
/// Corners, counter-clockwise seen from outside.
using Triangle = std::array<Eigen::Vector3f, 3>;
/// Triangles of a binary STL file, or in memory; see triangles_of().
struct TriangleMesh {
  std::filesystem::path path;  ///< of the file; in memory a name for messages
  Eigen::Vector3d scale{Eigen::Vector3d::Ones()};
  std::shared_ptr<const std::vector<Triangle>> triangles{nullptr};  ///< instead of the file
};
using Geometry = std::variant<Box, Cylinder, Sphere, Cone, TriangleMesh>;

/// Pattern that is multiplied with the colour; made by the program itself, from a seed.
enum class Texture {
  kNone,
  kWood,
  kTiles,
  kPlaster,
  kCloth,
  kCarpet,
  kMarble,
  kChecker,
  kStripes,   ///< two tones, along the texture's x
  kDots,      ///< dark discs on a light ground
  kPrint,     ///< a label: blocks, lines that look like writing, a disc
  kPoster,    ///< patches of many colours, like a photograph from afar
  kBlotches,  ///< soft spots
  kBall,      ///< panels and seams of a ball
  kPips,      ///< rounded square with the pips of a die
  kGradient,  ///< light to dark and back: looks translucent
  kBooks
};

/// Name of a texture as worlds write it: "none", "wood", "tiles", "plaster", "cloth", "carpet", "marble",
/// "checker", "stripes", "dots", "print", "poster", "blotches", "ball", "pips", "gradient",
/// "books".
[[nodiscard]] const char* to_string(Texture texture);
/// The texture of that name, empty when there is none.
[[nodiscard]] std::optional<Texture> texture_from(std::string_view name);

/// What a surface looks like.
struct Material {
  Eigen::Vector3f colour{0.7F, 0.7F, 0.7F};  ///< sRGB, each in [0, 1]
  Texture texture{Texture::kNone};
  float texture_size_m{1.0F};  ///< length of surface that one repetition of the texture covers
  float gloss{0.0F};           ///< weight of the highlight, [0, 1]
};

/// One convex or triangulated part of a body.
struct Shape {
  Geometry geometry;
  Pose body_T_shape{Pose::Identity()};
  Material material;
};

}  // namespace extperfc
