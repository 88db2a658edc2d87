#include "simulate/render/face_texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "extperfc/base/math.hpp"

#include "simulate/render/lattice_noise.hpp"

namespace extperfc::simulate {

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kFrontDensity =
    0.5F;  // the front has 1.5 times the mean density of columns, the back half of it
constexpr float kSoft_m = 0.0007F;  // width of drawn edges: a pixel of the texture

/// 1 inside an edge, 0 outside; `inside_m` is the distance from the edge, positive inside.
float painted(float inside_m) {
  return smooth_step(-kSoft_m, kSoft_m, inside_m);
}

float soft_blob(float a, float b) {
  const float square = a * a + b * b;
  return square > 18.0F ? 0.0F : std::exp(-0.5F * square);
}

/// A pixel of the texture.
struct Texel {
  float u, v;  ///< in the texture, [0, 1]
  Vector3f skull;
  float y;  ///< distance from the middle plane [m]
  float z;
  bool front;
};

/// Position relative to the middle of an eye: `out` to the temple, `up` across the tilted line of the eye.
struct EyePlace {
  float out, up;
};

class FacePainter {
 public:
  explicit FacePainter(const FaceFeatures& face) : face_(face), head_(face) {
    for (int i = 0; i < MipTexture::kSize; ++i)
      azimuths_[static_cast<std::size_t>(i)] =
          face_texture_azimuth((static_cast<float>(i) + 0.5F) / MipTexture::kSize);
  }

  [[nodiscard]] Colour at(float u, float v) const {
    const Texel texel = texel_at(u, v);
    const float hair = head_.hair_at(texel.skull);
    Colour colour = hair < 1.0F ? face_at(texel) : face_.hair;
    if (hair > 0.0F) colour = mix(colour, scaled(face_.hair, strands(texel)), hair);
    if (face_.glasses) paint_glasses(texel, colour);
    return colour;
  }

 private:
  [[nodiscard]] Texel texel_at(float u, float v) const {
    const auto column = static_cast<std::size_t>(u * MipTexture::kSize);
    const Vector3f skull = head_.skull(head_direction(azimuths_[column], (0.5F - v) * 0.5F * kTwoPiF));
    return {u, v, skull, std::abs(skull.y()), skull.z(), skull.x() > 0.02F};
  }
  [[nodiscard]] EyePlace eye_place(const Texel& texel) const {
    const float out = texel.y - 0.5F * face_.eye_distance_m;
    return {out, texel.z - face_.eye_tilt * out};
  }
  [[nodiscard]] float strands(const Texel& texel) const {
    const float noise = octaves(400U + face_.seed % 64U, texel.u, texel.v, 96, 12, 3);
    return 0.70F + 0.60F * noise;
  }

  [[nodiscard]] Colour face_at(const Texel& texel) const {
    Colour colour = scaled(skin(texel), 1.0F - shade(texel));
    if (!texel.front) return colour;
    paint_nose(texel, colour);
    paint_lips(texel, colour);
    paint_beard(texel, colour);
    paint_eye(texel, colour);
    paint_brow(texel, colour);
    return colour;
  }
  [[nodiscard]] Colour skin(const Texel& texel) const;
  [[nodiscard]] float shade(const Texel& texel) const;
  void paint_nose(const Texel& texel, Colour& colour) const;
  void paint_lips(const Texel& texel, Colour& colour) const;
  void paint_beard(const Texel& texel, Colour& colour) const;
  void paint_eye(const Texel& texel, Colour& colour) const;
  void paint_eyeball(const Texel& texel, const EyePlace& eye, float inside, Colour& colour) const;
  void paint_brow(const Texel& texel, Colour& colour) const;
  void paint_glasses(const Texel& texel, Colour& colour) const;
  [[nodiscard]] float beard_cover(const Texel& texel) const;

  FaceFeatures face_;
  HeadShape head_;
  std::array<float, MipTexture::kSize> azimuths_{};
};

/// Uneven tone, redder cheeks, freckles.
Colour FacePainter::skin(const Texel& texel) const {
  const float cloud = octaves(420U + face_.seed % 64U, texel.u, texel.v, 20, 20, 4) - 0.5F;
  Colour colour = scaled(face_.skin, 1.0F + 0.16F * cloud);
  if (!texel.front) return colour;
  const float blush = 0.22F * soft_blob((texel.y - 0.040F) / 0.014F, (texel.z + 0.038F) / 0.014F);
  colour = mix(colour, {1.05F * colour.r, 0.78F * colour.g, 0.76F * colour.b}, blush);
  const float dots = smooth_step(0.62F, 0.72F, lattice(430U + face_.seed % 64U, texel.u, texel.v, 150, 150));
  const float where = soft_blob(texel.y / 0.040F, (texel.z + 0.028F) / 0.016F);
  return mix(colour, {0.62F * colour.r, 0.48F * colour.g, 0.42F * colour.b},
             0.8F * face_.freckles * dots * where);
}

/// How much less light comes from sockets, wrinkles and below the chin.
float FacePainter::shade(const Texel& texel) const {
  float shade = 0.25F * (1.0F - smooth_step(face_.chin_z_m - 0.004F, face_.chin_z_m + 0.014F, texel.z));
  if (!texel.front) return shade;
  const EyePlace eye = eye_place(texel);
  shade += 0.24F * soft_blob((eye.out + 0.004F) / 0.016F, (eye.up - 0.004F) / 0.009F);
  shade += (0.05F + 0.20F * face_.age) * soft_blob(eye.out / 0.012F, (eye.up + 0.013F) / 0.0025F);
  const float fold_y =
      face_.nose_half_width_m + 0.004F + 0.35F * (face_.nose_z_m - texel.z);  // nose to mouth
  shade += (0.03F + 0.24F * face_.age) *
           soft_blob((texel.y - fold_y) / 0.0020F, (texel.z - face_.mouth_z_m - 0.010F) / 0.012F);
  const float wave = 0.0012F * std::sin(110.0F * texel.y + static_cast<float>(face_.seed % 5U));
  for (const float z : {0.038F, 0.046F, 0.054F})
    shade += 0.20F * face_.age * soft_blob(texel.y / 0.022F, (texel.z - z - wave) / 0.0012F);
  return shade;
}

/// Sides of the ridge, wings, nostrils and the shadow of the tip.
void FacePainter::paint_nose(const Texel& texel, Colour& colour) const {
  const float tip = face_.nose_z_m;
  const float half = face_.nose_half_width_m;
  const float along =
      (1.0F - smooth_step(tip, 0.004F, texel.z)) * smooth_step(tip - 0.010F, tip - 0.002F, texel.z);
  const float side = 0.16F * along * soft_blob((texel.y - 0.010F - 0.2F * half * along) / 0.0035F, 0);
  const float crease = 0.28F * soft_blob((texel.y - half) / 0.0022F, (texel.z - tip + 0.003F) / 0.006F);
  const float under = 0.12F * soft_blob(texel.y / (0.8F * half), (texel.z - tip + 0.0115F) / 0.0030F);
  colour = scaled(colour, 1.0F - side - crease - under);
  const float light = 0.10F * soft_blob(texel.y / 0.0035F, (texel.z - tip - 0.004F) / 0.012F);
  colour = scaled(colour, 1.0F + light);
  const float nostril = soft_blob((texel.y - 0.46F * half) / 0.0032F, (texel.z - tip + 0.0085F) / 0.0019F);
  colour = mix(colour, {0.16F, 0.08F, 0.07F}, std::min(0.85F, 1.1F * nostril));
}

/// Upper lip with its bow, lower lip, the line between them and the shadow below.
void FacePainter::paint_lips(const Texel& texel, Colour& colour) const {
  const float half = face_.mouth_half_width_m;
  const float across = texel.y / half;
  const float from_line = texel.z - mouth_line_z(face_, texel.y);
  const float below =
      soft_blob(across / 0.55F, (from_line + 1.15F * face_.lip_half_height_m + 0.0045F) / 0.0032F);
  colour = scaled(colour, 1.0F - 0.20F * below);
  if (across > 1.05F) return;
  const float full = std::max(0.0F, 1.0F - across * across);
  const float bow = 1.0F - 0.22F * soft_blob(across / 0.13F, 0);
  const float top = 0.85F * face_.lip_half_height_m * bow * std::pow(full, 0.75F);
  const float bottom = 1.05F * face_.lip_half_height_m * std::sqrt(full);
  const bool upper = from_line > 0;
  const float inside = upper ? top - from_line : bottom + from_line;
  const float light = upper ? 0.86F : 1.0F + 0.16F * soft_blob(across / 0.4F, (from_line + 0.005F) / 0.002F);
  colour = mix(colour, scaled(face_.lips, light), 0.9F * painted(inside));
  const float line = painted(0.0009F - std::abs(from_line)) * (1.0F - smooth_step(0.95F, 1.05F, across));
  colour = mix(colour, scaled(face_.lips, 0.30F), 0.85F * line);
}

/// Fraction of the skin that the beard covers.
float FacePainter::beard_cover(const Texel& texel) const {
  const float upper = 0.5F * (face_.nose_z_m - 0.012F + face_.mouth_z_m + 0.7F * face_.lip_half_height_m);
  const float wide = texel.y / face_.mouth_half_width_m;
  const float moustache = (1.0F - smooth_step(0.80F, 1.10F, wide)) *
                          (1.0F - smooth_step(0.0035F, 0.0062F, std::abs(texel.z - upper + 0.12F * texel.y)));
  const float mouth =
      smooth_step(0.9F, 1.15F,
                  std::hypot(texel.y / (face_.mouth_half_width_m + 0.001F),
                             (texel.z - face_.mouth_z_m) / (face_.lip_half_height_m + 0.002F)));
  const float chin =
      mouth *
      (1.0F -
       smooth_step(0.80F, 1.10F, std::hypot(texel.y / 0.025F, (texel.z - face_.chin_z_m - 0.012F) / 0.030F)));
  const float cheek_edge = face_.mouth_z_m + 0.004F + 9.0F * std::pow(std::max(0.0F, texel.y - 0.018F), 1.5F);
  const float soft = face_.beard == Beard::kStubble ? 0.014F : 0.006F;
  const float cheeks = mouth * (1.0F - smooth_step(cheek_edge - soft, cheek_edge + soft, texel.z)) *
                       (1.0F - smooth_step(-0.012F, 0.008F, texel.z));
  switch (face_.beard) {
    case Beard::kMoustache:
      return std::min(1.0F, 1.4F * moustache);
    case Beard::kGoatee:
      return std::max(std::min(1.0F, 1.3F * moustache), chin);
    case Beard::kFull:
      return std::max(std::min(1.0F, 1.4F * moustache), cheeks);
    case Beard::kStubble:
      return 0.38F * std::max(moustache, cheeks);
    case Beard::kNone:
      break;
  }
  return 0.0F;
}

void FacePainter::paint_beard(const Texel& texel, Colour& colour) const {
  const float cover = beard_cover(texel);
  if (cover <= 0.0F) return;
  const float hairs = lattice(440U, texel.u, texel.v, 256, 128);
  colour = mix(colour, scaled(face_.hair, 0.75F + 0.45F * hairs), cover * (0.80F + 0.20F * hairs));
}

/// White, iris, pupil and a reflected light, all below the shadow of the upper lid.
void FacePainter::paint_eyeball(const Texel& texel, const EyePlace& eye, float inside, Colour& colour) const {
  Colour ball = mix({0.90F, 0.88F, 0.86F}, {0.80F, 0.62F, 0.58F},
                    smooth_step(0.6F, 1.0F, std::abs(eye.out) / face_.eye_half_width_m));
  const float from_middle = std::hypot(eye.out, eye.up - 0.0006F);
  const float ring = smooth_step(0.0035F, 0.0060F, from_middle);
  ball = mix(ball, mix(face_.iris, scaled(face_.iris, 0.40F), ring), painted(0.0060F - from_middle));
  ball = mix(ball, {0.03F, 0.02F, 0.02F}, painted(0.0024F - from_middle));
  const float glint =
      std::hypot(texel.skull.y() - std::copysign(0.5F * face_.eye_distance_m, texel.skull.y()) - 0.0018F,
                 eye.up - 0.0026F);
  ball = mix(ball, grey(0.96F), 0.9F * painted(0.0011F - glint));
  const float lid_shadow = 0.35F * smooth_step(0.5F, 1.0F, eye.up / face_.eye_half_height_m);
  colour = mix(colour, scaled(ball, 1.0F - lid_shadow), painted(inside));
}

/// The opening between the lids, lashes, and the crease of the upper lid.
void FacePainter::paint_eye(const Texel& texel, Colour& colour) const {
  const EyePlace eye = eye_place(texel);
  const float across = eye.out / face_.eye_half_width_m;
  if (std::abs(across) > 1.4F || std::abs(eye.up) > 0.02F) return;
  const float full = 1.0F - across * across;
  const float top = face_.eye_half_height_m * std::copysign(std::pow(std::abs(full), 0.8F), full);
  const float bottom = -0.80F * top;
  paint_eyeball(texel, eye, std::min(top - eye.up, eye.up - bottom), colour);
  const float ends = 1.0F - smooth_step(0.95F, 1.15F, std::abs(across));
  const float lashes = painted(0.0011F - std::abs(eye.up - top - 0.0004F)) * ends;
  colour = mix(colour, {0.08F, 0.05F, 0.05F}, 0.9F * lashes);
  const float lower = painted(0.0006F - std::abs(eye.up - bottom)) * ends;
  colour = mix(colour, scaled(face_.skin, 0.50F), 0.6F * lower);
  const float crease = soft_blob((eye.up - top - 0.0042F) / 0.0009F, 0) * ends;
  colour = scaled(colour, 1.0F - 0.30F * crease);
}

void FacePainter::paint_brow(const Texel& texel, Colour& colour) const {
  const float out = (texel.y - 0.5F * face_.eye_distance_m) / 0.021F;  // -1 at the nose, 1 at the temple
  if (std::abs(out) > 1.15F) return;
  const float arch = face_.brow_arch_m * (1.0F - (out - 0.35F) * (out - 0.35F));
  const float middle = face_.brow_z_m + arch + 0.3F * face_.eye_tilt * 0.021F * out;
  const float half = face_.brow_half_thickness_m * (1.0F - 0.45F * smooth_step(-0.2F, 1.0F, out));
  const float inside = half - std::abs(texel.z - middle);
  const float cover =
      smooth_step(-0.0012F, 0.0012F, inside) * (1.0F - smooth_step(0.92F, 1.12F, std::abs(out)));
  const float hairs = lattice(441U, texel.u, texel.v, 256, 64);
  colour = mix(colour, scaled(face_.hair, 0.55F + 0.30F * hairs), cover * (0.75F + 0.25F * hairs));
}

/// Two rounded rims, the bridge, and the bars to the ears.
void FacePainter::paint_glasses(const Texel& texel, Colour& colour) const {
  if (texel.skull.x() < -0.01F) return;
  const float out = (texel.y - 0.5F * face_.eye_distance_m - 0.001F) / 0.0235F;
  const float up = (texel.z + 0.002F) / 0.0185F;
  const float edge = std::pow(std::pow(std::abs(out), 3.0F) + std::pow(std::abs(up), 3.0F), 1.0F / 3.0F);
  float cover = painted(0.0014F - std::abs(edge - 1.0F) * 0.020F);
  const bool between = texel.y < 0.5F * face_.eye_distance_m - 0.0215F;
  if (between) cover = std::max(cover, painted(0.0013F - std::abs(texel.z - 0.0045F)));
  const bool beside = texel.y > 0.5F * face_.eye_distance_m + 0.0235F;
  if (beside) cover = std::max(cover, painted(0.0016F - std::abs(texel.z - 0.005F)));
  colour = mix(colour, face_.frame, 0.95F * cover);
}

}  // namespace

Vector2f face_texture_at(float azimuth, float elevation) {
  return {0.5F + (azimuth + kFrontDensity * std::sin(azimuth)) / kTwoPiF, 0.5F - 2.0F * elevation / kTwoPiF};
}

float face_texture_azimuth(float x) {
  const float wanted = kTwoPiF * (x - 0.5F);
  float azimuth = wanted / (1.0F + kFrontDensity);
  for (int i = 0; i < 24; ++i)  // Newton's method
    azimuth +=
        (wanted - azimuth - kFrontDensity * std::sin(azimuth)) / (1.0F + kFrontDensity * std::cos(azimuth));
  return azimuth;
}

MipTexture make_face_texture(const FaceFeatures& face) {
  const FacePainter painter(face);
  return make_mip_texture([&](float x, float y) { return painter.at(x, y); });
}

}  // namespace extperfc::simulate
