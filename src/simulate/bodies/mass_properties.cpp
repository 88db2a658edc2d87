#include "simulate/bodies/mass_properties.hpp"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace extperfc::simulate {
namespace {

/// Inertia that a point mass at `arm` adds about the origin (Steiner's theorem).
Eigen::Matrix3d steiner(double mass, const Eigen::Vector3d& arm) {
  return mass * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
}

}  // namespace

MassProperties transformed(const Pose& target_T_source, const MassProperties& source) {
  const Eigen::Matrix3d rotation = target_T_source.linear();
  return {source.mass_kg, target_T_source * source.com,
          rotation * source.inertia_kg_m2 * rotation.transpose()};
}

MassProperties combined(const MassProperties& a, const MassProperties& b) {
  const double mass = a.mass_kg + b.mass_kg;
  if (mass <= 0) return a;
  MassProperties sum;
  sum.mass_kg = mass;
  sum.com = (a.mass_kg * a.com + b.mass_kg * b.com) / mass;
  sum.inertia_kg_m2 = a.inertia_kg_m2 + steiner(a.mass_kg, a.com - sum.com) + b.inertia_kg_m2 +
                      steiner(b.mass_kg, b.com - sum.com);
  return sum;
}

MassProperties mass_properties(const Inertial& inertial) {
  return transformed(inertial.link_T_com,
                     {inertial.mass_kg, Eigen::Vector3d::Zero(), inertial.inertia_kg_m2});
}

PrincipalFrame principal_frame(const MassProperties& properties) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(properties.inertia_kg_m2);
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  PrincipalFrame frame;
  frame.frame_T_principal.linear() = axes;
  frame.frame_T_principal.translation() = properties.com;
  constexpr double kSmallestRadius = 0.002;  // [m]
  const double smallest = 0.4 * std::max(properties.mass_kg, 1e-3) * kSmallestRadius * kSmallestRadius;
  frame.moments_kg_m2 = solver.eigenvalues().cwiseMax(smallest);
  return frame;
}

}  // namespace extperfc::simulate
