#include "simulate/render/head_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/math.hpp"

#include "simulate/render/face_texture.hpp"

namespace extperfc::simulate {

namespace {

using Eigen::Vector3f;

constexpr std::uint32_t kHeadColumns = 60;  // around, closer together in front
constexpr std::uint32_t kHeadRows = 40;     // from below to the crown, closer together on the face
constexpr float kNormalStep = 0.012F;       // [rad]: details of the face are wider

Vector3f head_point(const HeadShape& head, float azimuth, float elevation) {
  return head.surface(head.skull(head_direction(azimuth, elevation)));
}

/// Of the surface itself, not of the triangles: they are coarser than a nose.
Vector3f head_normal(const HeadShape& head, float azimuth, float elevation) {
  const float e = std::clamp(elevation, -1.55F, 1.55F);  // at the poles all azimuths are one
  const Vector3f along =
      head_point(head, azimuth + kNormalStep, e) - head_point(head, azimuth - kNormalStep, e);
  const Vector3f up = head_point(head, azimuth, e + kNormalStep) - head_point(head, azimuth, e - kNormalStep);
  return along.cross(up).normalized();
}

/// Rows are closest together at kDense, between the mouth and the eyes; the first and the last are the poles.
float row_elevation(std::uint32_t row) {
  constexpr float kDense = -0.35F;    // [rad]
  constexpr float kStrength = 0.22F;  // rows there are 1 / (1 - 2 * kStrength) times as close
  const float even = (static_cast<float>(row) / kHeadRows - 0.5F) * 0.5F * kTwoPiF;
  return even - kStrength * (std::sin(2.0F * (even - kDense)) - std::sin(2.0F * kDense));
}

}  // namespace

Mesh make_head(const HeadShape& head, std::uint32_t surface) {
  Mesh mesh;
  for (std::uint32_t row = 0; row <= kHeadRows; ++row) {
    const float elevation = row_elevation(row);
    for (std::uint32_t column = 0; column <= kHeadColumns; ++column) {
      const float azimuth = face_texture_azimuth(static_cast<float>(column) / kHeadColumns);
      mesh.vertices.push_back({kPerson_P_head + head_point(head, azimuth, elevation),
                               head_normal(head, azimuth, elevation), face_texture_at(azimuth, elevation)});
    }
  }
  constexpr std::uint32_t kRow = kHeadColumns + 1;
  for (std::uint32_t row = 1; row <= kHeadRows; ++row)
    join_rows(mesh, (row - 1) * kRow, row * kRow, kRow, surface);
  mesh.drop_slivers();
  return mesh;
}

}  // namespace extperfc::simulate
