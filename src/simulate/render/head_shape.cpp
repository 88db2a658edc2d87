#include "simulate/render/head_shape.hpp"

#include <algorithm>
#include <cmath>

#include "simulate/render/lattice_noise.hpp"

namespace extperfc::simulate {

namespace {

using Eigen::Vector3f;

/// exp(-(a^2 + b^2) / 2) for offsets in standard deviations.
float bump(float a, float b) {
  const float square = a * a + b * b;
  return square > 18.0F ? 0.0F : std::exp(-0.5F * square);
}

/// Distance from the origin, which lies inside, to an ellipsoid.
float ellipsoid_radius(const Vector3f& direction, const Vector3f& centre, const Vector3f& half) {
  const Vector3f d = direction.cwiseQuotient(half);
  const Vector3f c = centre.cwiseQuotient(half);
  const float a = d.squaredNorm();
  const float b = d.dot(c);
  return (b + std::sqrt(std::max(0.0F, b * b + a * (1.0F - c.squaredNorm())))) / a;
}

/// The greater of two lengths, rounded where they are about the same.
float smooth_max(float a, float b, float rounding) {
  const float d = a - b;
  return 0.5F * (a + b + std::sqrt(d * d + rounding * rounding));
}

float skull_radius(const FaceFeatures& face, const Vector3f& direction) {
  const float cranium =
      ellipsoid_radius(direction, {-0.014F, 0, 0.022F}, {0.096F, face.head_half_width_m, 0.094F});
  const float jaw_half = -face.chin_z_m - 0.046F;
  const float jaw =
      ellipsoid_radius(direction, {0.024F, 0, -0.046F}, {0.066F, face.jaw_half_width_m, jaw_half});
  return smooth_max(cranium, jaw, 0.010F);
}

/// Sockets, eyeballs, brows and cheek bones; y is that of the left half.
float eye_relief(const FaceFeatures& face, float y, float z) {
  const float out = y - 0.5F * face.eye_distance_m;
  return -0.0085F * bump((out + 0.002F) / 0.015F, (z - 0.002F) / 0.010F) +
         0.0045F * bump(out / 0.010F, z / 0.0065F) +
         0.0045F * bump(out / 0.018F, (z - face.brow_z_m) / 0.0065F) +
         face.cheek_m * bump((y - 0.043F) / 0.014F, (z + 0.030F) / 0.014F);
}

/// A ridge that rises from between the eyes to the tip and ends below it, and two wings.
float nose_relief(const FaceFeatures& face, float y, float z) {
  const float along = std::clamp((0.010F - z) / (0.010F - face.nose_z_m), 0.0F, 1.0F);
  const float below = smooth_step(face.nose_z_m - 0.013F, face.nose_z_m - 0.001F, z);
  const float height = (0.15F + 0.85F * std::pow(along, 1.3F)) * face.nose_height_m;
  const float width = 0.0060F + 0.30F * (face.nose_half_width_m - 0.008F) * along;
  const float start = 1.0F - smooth_step(0.006F, 0.026F, z);
  const float wing = bump((y - 0.62F * face.nose_half_width_m) / (0.36F * face.nose_half_width_m),
                          (z - face.nose_z_m + 0.003F) / 0.0060F);
  return height * below * start * bump(y / width, 0) + 0.0085F * wing;
}

float mouth_relief(const FaceFeatures& face, float y, float z) {
  const float across = y / (0.62F * face.mouth_half_width_m);
  const float from_line = z - mouth_line_z(face, y);
  const float lip = 0.55F * face.lip_half_height_m;
  return 0.0045F * bump(across, (from_line - lip) / lip) + 0.0055F * bump(across, (from_line + lip) / lip) -
         0.0030F * bump(1.1F * across, from_line / 0.0018F) -
         0.0035F * bump(across, (from_line + 0.018F) / 0.006F) +
         0.0100F * bump(y / 0.018F, (z - face.chin_z_m - 0.017F) / 0.013F);
}

/// What the face adds to the skull at a point of it.
float face_relief(const FaceFeatures& face, const Vector3f& skull_point) {
  const float front = smooth_step(0.010F, 0.045F, skull_point.x());
  if (front <= 0.0F) return 0.0F;
  const float y = std::abs(skull_point.y());
  const float z = skull_point.z();
  return front * (eye_relief(face, y, z) + nose_relief(face, y, z) + mouth_relief(face, y, z));
}

/// Height of the lower edge of the hair at the sides and at the back.
float side_edge_z(HairStyle style) {
  switch (style) {
    case HairStyle::kLong:
      return -0.200F;
    case HairStyle::kCropped:
    case HairStyle::kBald:
      return -0.030F;
    default:
      return -0.055F;
  }
}

}  // namespace

float mouth_line_z(const FaceFeatures& face, float y) {
  const float across = std::min(1.2F, std::abs(y) / face.mouth_half_width_m);
  return face.mouth_z_m + face.smile_m * across * across;
}

Vector3f head_direction(float azimuth, float elevation) {
  const float flat = std::cos(elevation);
  return {flat * std::cos(azimuth), flat * std::sin(azimuth), std::sin(elevation)};
}

/// From the forehead over the temples and the ears to the nape.
float HeadShape::hairline_z(const Vector3f& skull_point) const {
  const float x = skull_point.x();
  const float y = std::abs(skull_point.y());
  float front = face_.hairline_z_m + 0.006F * smooth_step(0.015F, 0.035F, y);
  if (face_.hair_style == HairStyle::kFringe) front = 0.034F + 0.25F * skull_point.y();
  if (face_.hair_style == HairStyle::kBald) front = 0.200F;
  const float temple = face_.hair_style == HairStyle::kLong ? -0.200F : -0.008F;
  const float back = std::max(0.0F, -0.020F - skull_point.z());  // long hair leaves jaw and chin free
  const float edge_x = face_.hair_style == HairStyle::kBald ? 0.0F : 0.030F - 0.7F * back;
  const float beside = 1.0F - smooth_step(edge_x, edge_x + 0.018F, x);
  const float behind = 1.0F - smooth_step(-0.035F, -0.010F, x);
  const float z = front + beside * (temple - front);
  return z + behind * (side_edge_z(face_.hair_style) - z);
}

float HeadShape::hair_at(const Vector3f& skull_point) const {
  return cover_of_hair(skull_point, 0.004F);
}

float HeadShape::cover_of_hair(const Vector3f& skull_point, float soft_m) const {
  const float wave = 0.004F * std::sin(310.0F * skull_point.y() + static_cast<float>(face_.seed % 7U));
  const float edge = hairline_z(skull_point) + wave;
  float cover = smooth_step(edge - 0.003F, edge + soft_m, skull_point.z());
  if (face_.hair_style == HairStyle::kBald) cover *= 1.0F - smooth_step(0.050F, 0.062F, skull_point.z());
  return cover;
}

float HeadShape::hair_thickness(const Vector3f& skull_point) const {
  const float high = smooth_step(-0.02F, 0.09F, skull_point.z());
  float thick = face_.hair_volume_m * (0.65F + 0.35F * high);
  if (face_.hair_style == HairStyle::kBald) thick = 0.003F;
  if (face_.hair_style == HairStyle::kCurly)
    thick += 0.0035F * std::sin(240.0F * skull_point.y()) *
             std::sin(230.0F * skull_point.z() + 200.0F * skull_point.x());
  return thick * cover_of_hair(skull_point, 0.014F);
}

Vector3f HeadShape::skull(const Vector3f& direction) const {
  return skull_radius(face_, direction) * direction;
}

Vector3f HeadShape::surface(const Vector3f& skull_point) const {
  const float length = skull_point.norm();
  return skull_point * (1.0F + hair_thickness(skull_point) / length) +
         Vector3f(face_relief(face_, skull_point), 0, 0);
}

Vector3f HeadShape::front_at(float y, float z) const {
  Vector3f at(0.085F, y, z);
  for (int i = 0; i < 12; ++i) at.x() *= skull(at.normalized()).norm() / at.norm();
  return surface(at);
}

std::array<Vector3f, 5> face_landmarks(const FaceFeatures& face) {
  const HeadShape head(face);
  const float eye = 0.5F * face.eye_distance_m;
  const float mouth = face.mouth_half_width_m;
  return {kPerson_P_head + head.front_at(-eye, 0), kPerson_P_head + head.front_at(eye, 0),
          kPerson_P_head + head.front_at(0, face.nose_z_m),
          kPerson_P_head + head.front_at(-mouth, mouth_line_z(face, mouth)),
          kPerson_P_head + head.front_at(mouth, mouth_line_z(face, mouth))};
}

}  // namespace extperfc::simulate
