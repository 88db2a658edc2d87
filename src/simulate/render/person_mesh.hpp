#pragma once

#include <array>
#include <cstdint>

#include "extperfc/world/shape.hpp"

#include "simulate/render/mesh.hpp"

namespace extperfc::simulate {

enum class PersonPart { kSkin, kHair, kShirt, kTrousers, kShoes };
inline constexpr std::array<PersonPart, 5> kPersonParts{
    PersonPart::kSkin, PersonPart::kHair, PersonPart::kShirt, PersonPart::kTrousers, PersonPart::kShoes};
/// Index into the scene's surfaces, by PersonPart.
using PersonSurfaces = std::array<std::uint32_t, kPersonParts.size()>;

/// A walking adult of 1.77 m, about 9,000 triangles: stands on z = 0, looks along x.
[[nodiscard]] Mesh make_person(const PersonSurfaces& surfaces);

/// `clothes` colours the shirt; skin, hair and trousers vary with `number`.
[[nodiscard]] Material person_material(PersonPart part, const Eigen::Vector3f& clothes, std::uint32_t number);

}  // namespace extperfc::simulate
