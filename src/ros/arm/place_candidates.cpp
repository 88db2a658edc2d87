#include "ros/arm/place_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

namespace extperfc::arm_node {

namespace {

/// The request; for a ball, which may rest in any orientation, also requests with approaches from vertical to
/// nearly horizontal.
std::vector<arm::PlaceRequest> rotated_requests(const CollisionObject& item, arm::PlaceRequest request) {
  const bool ball = item.shapes.size() == 1 && std::holds_alternative<Sphere>(item.shapes.front().geometry) &&
                    item.shapes.front().body_T_shape.translation().norm() < 1e-6;
  if (!ball) return {request};
  request.any_yaw = true;
  std::vector<arm::PlaceRequest> all{request};
  const Eigen::Matrix3d tip = request.root_T_object.linear() * request.tip_T_object.linear().transpose();
  const Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  const double tilt = std::acos(std::clamp(tip.col(2).dot(down), -1.0, 1.0));
  const Eigen::Vector3d across = tip.col(2).cross(down);
  const Eigen::Vector3d axis = across.norm() > 1e-3 ? across.normalized() : tip.col(0);
  for (const double wanted : {0.0, 0.4, 0.8, 1.2}) {
    all.push_back(request);
    all.back().root_T_object.linear() =
        Eigen::AngleAxisd(tilt - wanted, axis).toRotationMatrix() * request.root_T_object.linear();
  }
  return all;
}

}  // namespace

Result<std::vector<arm::PlaceCandidate>> place_candidates(const arm::ParallelHand& hand,
                                                          const CollisionObject& item,
                                                          const arm::PlaceRequest& request,
                                                          const arm::PlaceParams& params) {
  std::vector<arm::PlaceCandidate> all;
  std::optional<Error> first;
  for (const auto& rotated : rotated_requests(item, request)) {
    auto some = arm::place_poses(hand, rotated, params);
    if (some)
      all.insert(all.end(), some->begin(), some->end());
    else if (!first)
      first = some.error();
  }
  if (all.empty()) return tl::unexpected(*first);
  return all;
}

}  // namespace extperfc::arm_node
