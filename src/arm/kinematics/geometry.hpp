#pragma once

#include <array>
#include <type_traits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "extperfc/arm/joint_vector.hpp"

/// Forward kinematics with sizes that the compiler knows for six and seven joints.
namespace extperfc::arm {

template <int N>
inline constexpr int kMaxSize = N == Eigen::Dynamic ? kMaxJoints : N;
template <int N>
using Joints = Eigen::Matrix<double, N, 1, 0, kMaxSize<N>, 1>;
template <int N>
using Columns = Eigen::Matrix<double, 6, N, 0, 6, kMaxSize<N>>;
template <int N>
using Axes = Eigen::Matrix<double, 3, N, 0, 3, kMaxSize<N>>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

inline constexpr double kRevolution = 6.283185307179586;  // [rad]

/// A fixed transform.
struct ChainLink {
  Eigen::Matrix3d rotation{Eigen::Matrix3d::Identity()};
  Eigen::Vector3d offset_m{Eigen::Vector3d::Zero()};
};

[[nodiscard]] inline ChainLink operator*(const ChainLink& a, const ChainLink& b) {
  return {a.rotation * b.rotation, a.rotation * b.offset_m + a.offset_m};
}

/// How far the links can carry a point of the tip's frame that the last joint does not move, from a point
/// that the first joint does not move. The points that joints are measured between may lie anywhere on their
/// axes; they are chosen so that the sum of the distances is smallest.
struct Reach {
  Eigen::Vector3d anchor_m{Eigen::Vector3d::Zero()};  ///< in the root link's frame
  Eigen::Vector3d wrist_m{Eigen::Vector3d::Zero()};   ///< in the tip's frame
  double length_m{0};                                 ///< largest distance of the two
};

/// A chain whose every joint rotates about, or slides along, the z axis of its own frame.
struct ChainGeometry {
  int count{0};
  std::array<ChainLink, kMaxJoints + 1>
      links;  ///< to joint i's frame from the one before it; [count]: to the tip
  std::array<bool, kMaxJoints> prismatic{};  ///< else revolute
  Reach reach;
};

/// Where the joints and the tip are, in the frame that `base` starts from.
template <int N>
struct Placement {
  Eigen::Matrix3d rotation;  ///< of the tip
  Eigen::Vector3d position;  ///< of the tip
  Axes<N> axes;              ///< unit vectors
  Axes<N> origins;           ///< [m]
};

/// `base` stands for geometry.links[0]. O(joints).
template <int N>
void place(const ChainGeometry& geometry, const ChainLink& base, const Joints<N>& q, Placement<N>& out) {
  out.axes.resize(3, q.size());
  out.origins.resize(3, q.size());
  Eigen::Matrix3d rotation = base.rotation;
  Eigen::Vector3d position = base.offset_m;
  for (int i = 0; i < q.size(); ++i) {
    if (geometry.prismatic[i]) {
      position += q[i] * rotation.col(2);
    } else {
      const double c = std::cos(q[i]);
      const double s = std::sin(q[i]);
      const Eigen::Vector3d x = rotation.col(0);
      rotation.col(0) = c * x + s * rotation.col(1);
      rotation.col(1) = c * rotation.col(1) - s * x;
    }
    out.axes.col(i) = rotation.col(2);
    out.origins.col(i) = position;
    const ChainLink& link = geometry.links[i + 1];
    position.noalias() += rotation * link.offset_m;
    const Eigen::Matrix3d rotated = rotation * link.rotation;
    rotation = rotated;
  }
  out.rotation = rotation;
  out.position = position;
}

/// Columns of the tip's linear and angular velocity.
template <int N>
void chain_jacobian(const ChainGeometry& geometry, const Placement<N>& at, Columns<N>& out) {
  out.resize(6, at.axes.cols());
  for (int i = 0; i < at.axes.cols(); ++i) {
    const Eigen::Vector3d axis = at.axes.col(i);
    if (geometry.prismatic[i]) {
      out.col(i) << axis, Eigen::Vector3d::Zero();
    } else {
      const Eigen::Vector3d arm = at.position - at.origins.col(i);
      out.col(i) << axis.cross(arm), axis;
    }
  }
}

/// Calls work(std::integral_constant<int, N>) with N = count where it is compiled for that, else
/// Eigen::Dynamic.
template <typename Work>
decltype(auto) with_size(int count, Work&& work) {
  switch (count) {
    case 6:
      return work(std::integral_constant<int, 6>{});
    case 7:
      return work(std::integral_constant<int, 7>{});
    default:
      return work(std::integral_constant<int, Eigen::Dynamic>{});
  }
}

}  // namespace extperfc::arm
