#include "simulate/render/face_features.hpp"

#include <algorithm>
#include <array>

#include "extperfc/base/rng.hpp"

namespace extperfc::simulate {

namespace {

constexpr std::array<Colour, 7> kSkins{{{0.95F, 0.79F, 0.69F},
                                        {0.90F, 0.71F, 0.58F},
                                        {0.85F, 0.65F, 0.52F},
                                        {0.76F, 0.56F, 0.42F},
                                        {0.64F, 0.45F, 0.33F},
                                        {0.51F, 0.35F, 0.26F},
                                        {0.42F, 0.29F, 0.22F}}};
constexpr std::array<Colour, 8> kHairs{{{0.10F, 0.08F, 0.07F},
                                        {0.16F, 0.11F, 0.08F},
                                        {0.27F, 0.18F, 0.11F},
                                        {0.42F, 0.28F, 0.16F},
                                        {0.76F, 0.60F, 0.36F},
                                        {0.55F, 0.24F, 0.11F},
                                        {0.56F, 0.54F, 0.52F},
                                        {0.83F, 0.81F, 0.78F}}};
constexpr std::array<Colour, 5> kIrises{{{0.22F, 0.13F, 0.08F},
                                         {0.34F, 0.22F, 0.12F},
                                         {0.33F, 0.38F, 0.20F},
                                         {0.26F, 0.42F, 0.58F},
                                         {0.40F, 0.45F, 0.48F}}};
constexpr std::array<Colour, 4> kFrames{
    {{0.08F, 0.08F, 0.09F}, {0.35F, 0.18F, 0.10F}, {0.45F, 0.45F, 0.48F}, {0.45F, 0.10F, 0.14F}}};
constexpr int kDarkSkin = 4;  // from this one on hair and eyes are dark, unless the hair is grey
constexpr int kGreyHair = 6;

constexpr std::array<HairStyle, 6> kMaleStyles{HairStyle::kCropped, HairStyle::kShort, HairStyle::kShort,
                                               HairStyle::kFringe,  HairStyle::kCurly, HairStyle::kBald};
constexpr std::array<HairStyle, 5> kFemaleStyles{HairStyle::kLong, HairStyle::kLong, HairStyle::kBun,
                                                 HairStyle::kFringe, HairStyle::kCurly};
constexpr std::array<Beard, 7> kBeards{Beard::kNone,      Beard::kNone,   Beard::kNone, Beard::kStubble,
                                       Beard::kMoustache, Beard::kGoatee, Beard::kFull};

/// Values of one face, drawn one after the other.
class Drawing {
 public:
  explicit Drawing(int seed) : rng_(0xFACEU + static_cast<std::uint64_t>(seed)) {
    face_.seed = static_cast<std::uint32_t>(seed);
  }

  FaceFeatures face() {
    const bool male = rng_.chance(0.5);
    draw_shape(male);
    draw_eyes(male);
    draw_nose_and_mouth(male);
    draw_colours(male);
    draw_hair(male);
    return face_;
  }

 private:
  float in(double low, double high) { return static_cast<float>(rng_.uniform(low, high)); }
  template <typename Values>
  auto one_of(const Values& values) {
    return values[static_cast<std::size_t>(rng_.integer(0, static_cast<int>(values.size()) - 1))];
  }

  void draw_shape(bool male) {
    face_.head_half_width_m = in(0.070, 0.080);
    face_.jaw_half_width_m = in(0.050, 0.062) + (male ? 0.003F : 0.0F);
    face_.chin_z_m = in(-0.120, -0.106);
    face_.cheek_m = in(0.001, 0.008);
  }

  void draw_eyes(bool male) {
    face_.eye_distance_m = in(0.056, 0.071);
    face_.eye_half_width_m = in(0.0130, 0.0172);
    face_.eye_half_height_m = in(0.0043, 0.0076);
    face_.eye_tilt = in(-0.08, 0.20);
    face_.brow_z_m = in(0.0155, 0.0255);
    face_.brow_half_thickness_m = male ? in(0.0024, 0.0052) : in(0.0016, 0.0032);
    face_.brow_arch_m = in(0.000, 0.006);
  }

  void draw_nose_and_mouth(bool male) {
    face_.nose_half_width_m = in(0.0130, 0.0220);
    face_.nose_height_m = in(0.017, 0.026);
    face_.nose_z_m = in(-0.047, -0.039);
    face_.mouth_z_m = face_.nose_z_m - in(0.024, 0.032);
    face_.mouth_half_width_m = in(0.0200, 0.0305);
    face_.smile_m = in(-0.0004, 0.0030);
    face_.lip_half_height_m = male ? in(0.0045, 0.0090) : in(0.0065, 0.0120);
  }

  void draw_colours(bool male) {
    const int skin = rng_.integer(0, static_cast<int>(kSkins.size()) - 1);
    const bool dark = skin >= kDarkSkin;
    const float tone = in(0.96, 1.04);
    face_.skin = scaled(kSkins[static_cast<std::size_t>(skin)], tone);
    int hair = rng_.integer(0, static_cast<int>(kHairs.size()) - 1);
    if (dark && hair < kGreyHair) hair %= 2;
    face_.hair = kHairs[static_cast<std::size_t>(hair)];
    face_.iris = kIrises[static_cast<std::size_t>(rng_.integer(0, dark ? 1 : 4))];
    const Colour red = male ? Colour{0.62F, 0.30F, 0.27F} : Colour{0.72F, 0.18F, 0.20F};
    face_.lips = mix(scaled(face_.skin, 0.85F), red, male ? in(0.3, 0.5) : in(0.4, 0.85));
    face_.frame = one_of(kFrames);
    face_.age = hair >= kGreyHair ? in(0.6, 1.0) : in(0.0, 0.6);
    face_.freckles = !dark && rng_.chance(0.3) ? in(0.4, 1.0) : 0.0F;
  }

  void draw_hair(bool male) {
    face_.hair_style = male ? one_of(kMaleStyles) : one_of(kFemaleStyles);
    face_.hairline_z_m = in(0.052, 0.072);
    face_.hair_volume_m = in(0.007, 0.014);
    if (face_.hair_style == HairStyle::kCropped) face_.hair_volume_m = 0.003F;
    if (face_.hair_style == HairStyle::kCurly) face_.hair_volume_m += 0.006F;
    face_.beard = male ? one_of(kBeards) : Beard::kNone;
    face_.glasses = rng_.chance(0.3);
  }

  Rng rng_;
  FaceFeatures face_;
};

}  // namespace

FaceFeatures face_features(int seed) {
  return Drawing(seed).face();
}

int face_seed(const PersonSpec& person) {
  if (person.face) return *person.face;
  std::uint32_t hash = 2166136261U;  // FNV-1a, 32 bits
  for (const char c : person.name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return static_cast<int>(hash % (static_cast<std::uint32_t>(kMaxFaceSeed) + 1U));
}

}  // namespace extperfc::simulate
