#pragma once

#include <array>
#include <cstdint>

#include "extperfc/world/shape.hpp"

#include "simulate/render/face_features.hpp"
#include "simulate/render/mesh.hpp"

namespace extperfc::simulate {

enum class PersonPart { kSkin, kHair, kHead, kShirt, kTrousers, kShoes };
inline constexpr std::array<PersonPart, 6> kPersonParts{PersonPart::kSkin,     PersonPart::kHair,
                                                        PersonPart::kHead,     PersonPart::kShirt,
                                                        PersonPart::kTrousers, PersonPart::kShoes};
/// Index into the scene's surfaces, by PersonPart.
using PersonSurfaces = std::array<std::uint32_t, kPersonParts.size()>;

/// A walking adult of 1.77 m, about 11,000 triangles: stands on z = 0, looks along x. The surface of kHead
/// has the texture of the face.
[[nodiscard]] Mesh make_person(const PersonSurfaces& surfaces, const FaceFeatures& face);

/// `clothes` colours the shirt; trousers vary with `number`. kHead is white: its texture has all colours.
[[nodiscard]] Material person_material(PersonPart part, const Eigen::Vector3f& clothes, std::uint32_t number,
                                       const FaceFeatures& face);

}  // namespace extperfc::simulate
