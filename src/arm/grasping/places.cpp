#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "extperfc/arm/grasp.hpp"
#include "extperfc/base/math.hpp"

#include "arm/grasping/contact.hpp"

namespace extperfc::arm {
namespace {

bool within(double value, double low, double high) {
  return value >= low && value <= high;
}

bool rigid(const Pose& pose) {
  return pose.matrix().allFinite() && pose.linear().isUnitary(1e-6);
}

Result<void> check(const ParallelHand& hand, const PlaceRequest& request, const PlaceParams& params) {
  if (auto ok = hand.validate(); !ok) return ok;
  if (!rigid(request.tip_T_object) || !rigid(request.root_T_object))
    return fail(ErrorCode::kInvalidArgument, "a pose of the object is no finite rigid transform");
  if (!within(request.opening_m, 0, hand.opening_max_m))
    return fail(ErrorCode::kInvalidArgument, "the opening after placing exceeds that of the gripper");
  if (request.support_z_m && !std::isfinite(*request.support_z_m))
    return fail(ErrorCode::kInvalidArgument, "the height of the support is not finite");
  if (!within(params.lower_m, 0, 0.5) || !within(params.retreat_m, 0, 0.5) ||
      !within(params.yaw_step_rad, 0.05, 1.6) || !within(params.support_clearance_m, 0, 0.1))
    return fail(ErrorCode::kInvalidArgument, "a parameter of placing is out of its range");
  return {};
}

PlaceCandidate rotated(const PlaceRequest& request, const PlaceParams& params, double yaw_rad) {
  PlaceCandidate place;
  place.yaw_rad = yaw_rad;
  place.root_T_object = request.root_T_object;
  place.root_T_object.linear() =
      Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * request.root_T_object.linear();
  place.root_T_tip = place.root_T_object * request.tip_T_object.inverse();
  place.root_T_above = place.root_T_tip;
  place.root_T_above.translation().z() += params.lower_m;
  place.root_T_retreat = place.root_T_tip;
  place.root_T_retreat.translation() -= params.retreat_m * place.root_T_tip.linear().col(2);
  return place;
}

}  // namespace

Result<std::vector<PlaceCandidate>> place_poses(const ParallelHand& hand, const PlaceRequest& request,
                                                const PlaceParams& params) {
  if (auto ok = check(hand, request, params); !ok) return tl::unexpected<Error>(ok.error());
  std::vector<PlaceCandidate> places{rotated(request, params, 0)};
  const int half = request.any_yaw ? static_cast<int>(std::lround(kPi / params.yaw_step_rad)) : 0;
  for (int i = 1; i <= half; ++i) {
    places.push_back(rotated(request, params, i * kPi / half));
    if (i < half) places.push_back(rotated(request, params, -i * kPi / half));
  }
  if (!request.support_z_m) return places;
  const double min_z_m = *request.support_z_m + params.support_clearance_m;
  // Turning about the vertical changes no height: either all are above the support or none is.
  if (lowest_z_m(hand, places[0].root_T_tip, request.opening_m) < min_z_m)
    return fail(ErrorCode::kFailed,
                "the gripper would collide with the support: it holds the object too low for this pose");
  return places;
}

}  // namespace extperfc::arm
