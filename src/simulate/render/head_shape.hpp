#pragma once

#include <array>

#include <Eigen/Core>

#include "simulate/render/face_features.hpp"

namespace extperfc::simulate {

/// Middle of the head between the eyes' height, in the person's frame (x forward, y left, z up, on the
/// floor).
inline const Eigen::Vector3f kPerson_P_head{0.004F, 0.0F, 1.655F};

/// Surface of a head with its hair. A skull, which every ray from its middle meets once, is displaced:
/// forwards by the face, outwards by the hair. So features of the face keep their y and z. Positions are in
/// the head's frame, whose origin is kPerson_P_head and whose axes are the person's [m].
class HeadShape {
 public:
  explicit HeadShape(const FaceFeatures& face) : face_(face) {}

  /// The skull in a direction of unit length.
  [[nodiscard]] Eigen::Vector3f skull(const Eigen::Vector3f& direction) const;
  /// The surface above that point of the skull.
  [[nodiscard]] Eigen::Vector3f surface(const Eigen::Vector3f& skull_point) const;
  /// The surface of the face at y and z, |y| <= 0.05, -0.1 <= z <= 0.08.
  [[nodiscard]] Eigen::Vector3f front_at(float y, float z) const;
  /// How much hair covers the head above a point of the skull: 0 none, 1 all.
  [[nodiscard]] float hair_at(const Eigen::Vector3f& skull_point) const;
  [[nodiscard]] const FaceFeatures& face() const { return face_; }

 private:
  [[nodiscard]] float cover_of_hair(const Eigen::Vector3f& skull_point, float soft_m) const;
  [[nodiscard]] float hairline_z(const Eigen::Vector3f& skull_point) const;
  [[nodiscard]] float hair_thickness(const Eigen::Vector3f& skull_point) const;

  FaceFeatures face_;
};

/// Height of the line between the lips, which rises to its ends with a smile [m].
[[nodiscard]] float mouth_line_z(const FaceFeatures& face, float y);

/// Direction of unit length: azimuth from x to y, elevation above the x-y plane [rad].
[[nodiscard]] Eigen::Vector3f head_direction(float azimuth, float elevation);

/// Right eye, left eye, tip of the nose, right and left corner of the mouth (right: the person's), in the
/// person's frame [m].
[[nodiscard]] std::array<Eigen::Vector3f, 5> face_landmarks(const FaceFeatures& face);

}  // namespace extperfc::simulate
