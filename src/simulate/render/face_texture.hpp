#pragma once

#include <Eigen/Core>

#include "simulate/render/head_shape.hpp"
#include "simulate/render/mip_texture.hpp"

namespace extperfc::simulate {

/// Where a direction from the middle of the head lies in the texture of that head, in repetitions. The front
/// (azimuth 0) is the middle, where the texture is finest; x grows to the person's left, y downwards.
[[nodiscard]] Eigen::Vector2f face_texture_at(float azimuth, float elevation);
/// The azimuth at a column x of the texture [rad].
[[nodiscard]] float face_texture_azimuth(float x);
/// Length of surface that the texture would cover everywhere if it were as fine as on the face [m].
inline constexpr float kFaceTextureSize_m = 0.36F;

/// Skin, eyes, brows, lips, beard, glasses and hair of a whole head. Takes about 0.15 s and 1.4 MB.
[[nodiscard]] MipTexture make_face_texture(const FaceFeatures& face);

}  // namespace extperfc::simulate
