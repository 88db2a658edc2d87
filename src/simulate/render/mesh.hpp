#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "extperfc/base/error.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc::simulate {

struct Vertex {
  Eigen::Vector3f position;  ///< [m]
  Eigen::Vector3f normal;    ///< unit length, outwards
  Eigen::Vector2f texture;   ///< metres of surface until scaled; then repetitions of the texture
};

struct MeshTriangle {
  std::array<std::uint32_t, 3> corners;  ///< counter-clockwise seen from outside
  std::uint32_t surface;                 ///< index into the scene's surfaces
};

struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<MeshTriangle> triangles;

  /// Drops triangles without an area.
  void drop_slivers();

  void append(const Mesh& other, const Eigen::Isometry3f& this_T_other);
};

/// Triangles of a shape, in the shape's frame, all of one surface; texture coordinates in repetitions of the
/// material's texture. Error: a mesh file that cannot be read.
[[nodiscard]] Result<Mesh> make_mesh(const Geometry& geometry, const Material& material,
                                     std::uint32_t surface);

/// Corners of the outline of a circle: enough for a smooth edge at arm's length.
[[nodiscard]] int circle_corners(double radius_m);

/// Adds the quads between two rows of `row_length` vertices that start at `first` and at `second`.
void join_rows(Mesh& mesh, std::uint32_t first, std::uint32_t second, std::uint32_t row_length,
               std::uint32_t surface);

}  // namespace extperfc::simulate
