#include "arm/collision/bodies.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace extperfc::arm {

std::optional<int> Bodies::link(const std::string& name) const {
  const auto found = std::find(links.begin(), links.end(), name);
  if (found == links.end()) return std::nullopt;
  return static_cast<int>(found - links.begin());
}

double Bodies::world_padding_m(const std::string& link) const {
  const auto own = params.link_padding_m.find(link);
  return params.world_padding_m + (own == params.link_padding_m.end() ? 0 : own->second);
}

void body_poses(const Bodies& bodies, const double* positions, std::vector<Pose>& poses) {
  poses.resize(bodies.bodies.size(), Pose::Identity());
  for (std::size_t i = 1; i < bodies.bodies.size(); ++i) {
    const Body& body = bodies.bodies[i];
    const double value = body.multiplier * positions[body.joint] + body.offset;
    const Pose& parent = poses[body.parent];
    Eigen::Matrix3d rotated = parent.linear() * body.parent_T_joint.linear();
    Eigen::Vector3d origin = parent.translation() + parent.linear() * body.parent_T_joint.translation();
    if (body.prismatic) {
      origin += value * rotated.col(2);
    } else {
      const double c = std::cos(value), s = std::sin(value);
      const Eigen::Vector3d x = rotated.col(0), y = rotated.col(1);
      rotated.col(0) = c * x + s * y;
      rotated.col(1) = c * y - s * x;
    }
    poses[i].linear() = rotated;
    poses[i].translation() = origin;
  }
}

AxisReach reach_of(const Bodies& bodies, int body, const Ball& in_body) {
  AxisReach reach{std::vector<double>(bodies.bodies.size(), 0.0), in_body};
  Ball& ball = reach.in_root;
  for (int i = body; i > 0; i = bodies.bodies[i].parent) {
    const Body& own = bodies.bodies[i];
    if (own.prismatic) {
      reach.from_axis[i] = 1;
      ball.centre.z() += (own.lower + own.upper) / 2;
      ball.radius += (own.upper - own.lower) / 2;
    } else {
      ball.radius += ball.centre.head<2>().norm();
      reach.from_axis[i] = ball.radius;
      ball.centre.head<2>().setZero();
    }
    ball.centre = own.parent_T_joint * ball.centre;
  }
  return reach;
}

int common_ancestor(const Bodies& bodies, int a, int b) {
  while (a != b) (a > b ? a : b) = bodies.bodies[std::max(a, b)].parent;
  return a;
}

// With joints 1..n from the ancestor down and S_k = |q'_1| + ... + |q'_k| of the revolute ones, the second
// derivative of a point is the sum over j, k of q'_j q'_k d2x/dq_j dq_k, whose norm is at most the point's
// distance from the later joint's axis (1 if that one is prismatic, 0 if the earlier one is).
MotionBound motion_bound(const Bodies& bodies, int ancestor, int body, const std::vector<double>& from_axis,
                         const std::vector<double>& rates) {
  std::array<int, kMaxJoints * 2> chain{};
  int length = 0;
  for (int i = body; i != ancestor; i = bodies.bodies[i].parent) chain.at(length++) = i;
  MotionBound bound;
  double rotation_rate = 0;
  while (length-- > 0) {
    const int i = chain[length];
    const double rate = std::abs(rates[i]);
    bound.speed += rate * from_axis[i];
    if (bodies.bodies[i].prismatic) {
      bound.acceleration += 2 * rotation_rate * rate;
    } else {
      bound.acceleration += rate * from_axis[i] * (2 * rotation_rate + rate);
      rotation_rate += rate;
    }
  }
  return bound;
}

// A point moves at sum |q'_i| d_i at most, d_i its distance from axis i: |q'| times the root of the sum of
// the squared d_i at most. Joints that follow one position (mimic) add up before they are squared.
double displacement_per_rad(const Bodies& bodies, int ancestor, int body,
                            const std::vector<double>& from_axis) {
  std::array<double, kMaxJoints> of_joint{};
  for (int i = body; i != ancestor; i = bodies.bodies[i].parent)
    of_joint.at(bodies.bodies[i].joint) += std::abs(bodies.bodies[i].multiplier) * from_axis[i];
  double square = 0;
  for (const double distance : of_joint) square += distance * distance;
  return std::sqrt(square);
}

}  // namespace extperfc::arm
