#pragma once

#include <Eigen/Core>

#include "simulate/worlds/object_model.hpp"

/// Objects that a hand can take. They stand on z = 0; loose, with a mass from their volume.
namespace extperfc::simulate {

/// Density of objects without a given mass: light wood or hollow plastic [kg/m^3].
inline constexpr double kDensity = 400;

// Labelled "cone", "cube" and "sphere", the detector's classes.
[[nodiscard]] ObjectModel cone(double diameter_m, double height_m, const Material& material);
/// A cone that lies on its side, its tip towards +x.
[[nodiscard]] ObjectModel lying_cone(double diameter_m, double height_m, const Material& material);
[[nodiscard]] ObjectModel cube(double edge_m, const Material& material);
[[nodiscard]] ObjectModel sphere(double diameter_m, const Material& material);

// Not labelled.
[[nodiscard]] ObjectModel block(const Eigen::Vector3d& size_m, const Material& material);
[[nodiscard]] ObjectModel cylinder(double diameter_m, double height_m, const Material& material);
/// A cylinder on its side along y.
[[nodiscard]] ObjectModel roll(double diameter_m, double length_m, const Material& material);
[[nodiscard]] ObjectModel bottle(double height_m, const Material& material);
[[nodiscard]] ObjectModel cup(double height_m, const Material& material);
/// Lies flat; size [x (height of the book), y (width), z (thickness)].
[[nodiscard]] ObjectModel book(const Eigen::Vector3d& size_m, const Material& cover);
/// Stands upright with its spine to +x; size [x (width), y (thickness), z (height)].
[[nodiscard]] ObjectModel standing_book(const Eigen::Vector3d& size_m, const Material& cover);
/// A can with rims.
[[nodiscard]] ObjectModel can(double diameter_m, double height_m, const Material& material);
/// Steps of plates, each smaller than the one below.
[[nodiscard]] ObjectModel step_pyramid(double edge_m, double height_m, const Material& material);

}  // namespace extperfc::simulate
