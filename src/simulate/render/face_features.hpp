#pragma once

#include <cstdint>

#include "extperfc/simulate/world_spec.hpp"

#include "simulate/render/mip_texture.hpp"

namespace extperfc::simulate {

enum class HairStyle {
  kCropped,  ///< a few millimetres
  kShort,
  kFringe,  ///< short, over the forehead
  kCurly,
  kLong,  ///< down to the shoulders
  kBun,
  kBald,  ///< a rim around the back
};

enum class Beard { kNone, kStubble, kMoustache, kGoatee, kFull };

/// What a head looks like. Lengths in metres; heights (`_z_m`) above the line of the eyes, which is half the
/// height of the head. The defaults are an ordinary adult; face_features() draws around them.
struct FaceFeatures {
  float head_half_width_m{0.076F};
  float jaw_half_width_m{0.058F};
  float chin_z_m{-0.112F};
  float cheek_m{0.005F};  ///< height of the cheek bones above the ellipsoid
  float eye_distance_m{0.063F};
  float eye_half_width_m{0.0150F};
  float eye_half_height_m{0.0055F};
  float eye_tilt{0.05F};  ///< rise of the outer corner over its distance
  float brow_z_m{0.021F};
  float brow_half_thickness_m{0.0030F};
  float brow_arch_m{0.003F};
  float nose_half_width_m{0.017F};
  float nose_height_m{0.022F};  ///< of the tip above the face
  float nose_z_m{-0.043F};      ///< of the tip
  float mouth_z_m{-0.071F};
  float mouth_half_width_m{0.025F};
  float smile_m{0.001F};  ///< rise of the corners of the mouth
  float lip_half_height_m{0.008F};
  float hairline_z_m{0.062F};
  float hair_volume_m{0.012F};
  HairStyle hair_style{HairStyle::kShort};
  Beard beard{Beard::kNone};
  bool glasses{false};
  float age{0.3F};       ///< weight of wrinkles, [0, 1]
  float freckles{0.0F};  ///< weight of spots on nose and cheeks, [0, 1]
  Colour skin{0.86F, 0.68F, 0.56F};
  Colour hair{0.22F, 0.15F, 0.10F};
  Colour iris{0.30F, 0.20F, 0.12F};
  Colour lips{0.72F, 0.42F, 0.38F};
  Colour frame{0.10F, 0.10F, 0.11F};  ///< of the glasses
  std::uint32_t seed{0};              ///< of hair strands and spots
};

/// Draws a face. The same seed gives the same face on every run of one build.
[[nodiscard]] FaceFeatures face_features(int seed);

/// The person's `face`, or one in [0, kMaxFaceSeed] derived from the name when it is not given.
[[nodiscard]] int face_seed(const PersonSpec& person);

}  // namespace extperfc::simulate
