#include "extperfc/arm/cartesian_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

#include "extperfc/base/stopwatch.hpp"

#include "arm/cartesian/arm_in_group.hpp"
#include "arm/cartesian/follower.hpp"
#include "arm/cartesian/tool_path.hpp"
#include "arm/collision/state_fault.hpp"
#include "arm/kinematics/check.hpp"

namespace extperfc::arm {

namespace {

using Route = std::vector<Station>;

/// The first is for every arm, the others for redundant ones. Of 600 random lines of Baxter's left arm (0.1
/// to 0.6 m, half of them with a rotation, half of them among ten obstacles) the first alone completes 240,
/// without its pull 236; 24 attempts with these complete 279.
constexpr std::array<Course, 11> kCourses{{{1.0, 0.0, 0.0},
                                           {1.0, 0.0, 0.5},
                                           {1.0, 0.0, -0.5},
                                           {1.0, 0.0, 1.0},
                                           {1.0, 0.0, -1.0},
                                           {1.0, 0.0, 2.0},
                                           {1.0, 0.0, -2.0},
                                           {0.0, 2.0, 0.0},
                                           {0.0, -2.0, 0.0},
                                           {0.0, 6.0, 0.0},
                                           {0.0, -6.0, 0.0}}};
/// How far before its end the best route is left again [m].
constexpr std::array<double, 4> kBackM{0.1, 0.3, 1.0, 0.03};
/// What counts as farther [m].
constexpr double kFartherM = 1e-4;

CartesianResult failed(CartesianEnd end, std::string message) {
  CartesianResult result;
  result.end = end;
  result.message = std::move(message);
  return result;
}

std::optional<CartesianResult> refuse_shape(const CartesianRequest& request, int joints) {
  if (request.start.size() != joints || !request.start.allFinite())
    return failed(CartesianEnd::kInvalidRequest,
                  "the start needs " + std::to_string(joints) + " finite joint values");
  if (request.poses.empty()) return failed(CartesianEnd::kInvalidRequest, "no pose was given");
  for (std::size_t i = 0; i < request.poses.size(); ++i)
    if (!is_rigid(request.poses[i]))
      return failed(CartesianEnd::kInvalidRequest,
                    "pose " + std::to_string(i) + " is no rigid transform of finite numbers");
  return std::nullopt;
}

CartesianResult failed(CartesianEnd end, const CollisionModel& model, const StateFault& fault) {
  auto result = failed(end, fault.message);
  result.contact = fault.contact;
  if (fault.joint >= 0) result.joint = model.joint_names()[static_cast<std::size_t>(fault.joint)];
  return result;
}

/// Puts a start that is barely outside onto its limits.
std::optional<CartesianResult> refuse_start(CollisionChecker& checker, double repair_rad,
                                            JointVector& start) {
  const CollisionModel& model = checker.model();
  if (const auto fault = outside_limits(model, model.limits(), start, repair_rad, "start"))
    return failed(CartesianEnd::kStartOutsideLimits, model, *fault);
  start = start.cwiseMax(model.limits().lower).cwiseMin(model.limits().upper);
  if (checker.is_free(start)) return std::nullopt;
  return failed(CartesianEnd::kStartInCollision, model, in_collision(checker, start, "start"));
}

std::string describe(const FollowStop& stop, const ArmChain& chain, double fraction) {
  std::ostringstream text;
  text.precision(3);
  text << "stopped after " << 100 * fraction << " % of the path: ";
  switch (stop.end) {
    case CartesianEnd::kLimit:
      text << chain.joint_names()[stop.joint] << " is at its limit";
      break;
    case CartesianEnd::kCollision:
      text << (stop.contact ? stop.contact->first + " would touch " + stop.contact->second : "a collision");
      break;
    case CartesianEnd::kSingularity:
      text << "the joints would have to jump";
      break;
    case CartesianEnd::kOutOfReach:
      text << "the next pose is out of reach";
      break;
    case CartesianEnd::kCancelled:
      text << "cancelled";
      break;
    default:
      text << "the time was up";
  }
  return text.str();
}

/// The longest of several routes.
class Attempts {
 public:
  Attempts(Follower& follower, const Station& start) : follower_(follower), best_{start} {}

  template <typename Interrupted>
  void run(int max_attempts, const Interrupted& interrupted) {
    stop_ = follower_.follow(kCourses[0], interrupted, best_);
    made_ = 1;
    std::size_t attempt = 1;
    while (made_ < max_attempts && worth_more()) {
      ++made_;
      Route route = cut(attempt);
      const FollowStop stop = follower_.follow(kCourses[attempt % kCourses.size()], interrupted, route);
      attempt = (attempt + 1) % (kCourses.size() * (kBackM.size() + 1));
      if (stop.end == CartesianEnd::kCancelled || stop.end == CartesianEnd::kTimeout) stop_ = stop;
      if (route.back().place < best_.back().place + kFartherM && stop.end != CartesianEnd::kComplete)
        continue;
      best_ = std::move(route);
      stop_ = stop;
      attempt = kCourses.size();
    }
  }

  [[nodiscard]] const Route& best() const { return best_; }
  [[nodiscard]] const FollowStop& stop() const { return stop_; }
  [[nodiscard]] int made() const { return made_; }

 private:
  [[nodiscard]] bool worth_more() const {
    return stop_.end == CartesianEnd::kLimit || stop_.end == CartesianEnd::kCollision ||
           stop_.end == CartesianEnd::kSingularity || stop_.end == CartesianEnd::kOutOfReach;
  }
  // First from the start, then from the best route's places.
  [[nodiscard]] Route cut(std::size_t attempt) const {
    const std::size_t round = attempt / kCourses.size();
    if (round == 0) return {best_.front()};
    const double place = best_.back().place - kBackM[round - 1];
    Route route{best_.front()};
    for (std::size_t i = 1; i < best_.size() && best_[i].place <= place; ++i) route.push_back(best_[i]);
    return route;
  }

  Follower& follower_;
  Route best_;
  FollowStop stop_;
  int made_{0};
};

}  // namespace

const char* to_string(CartesianEnd end) {
  switch (end) {
    case CartesianEnd::kComplete:
      return "complete";
    case CartesianEnd::kInvalidRequest:
      return "invalid_request";
    case CartesianEnd::kStartOutsideLimits:
      return "start_outside_limits";
    case CartesianEnd::kStartInCollision:
      return "start_in_collision";
    case CartesianEnd::kLimit:
      return "limit";
    case CartesianEnd::kCollision:
      return "collision";
    case CartesianEnd::kSingularity:
      return "singularity";
    case CartesianEnd::kOutOfReach:
      return "out_of_reach";
    case CartesianEnd::kCancelled:
      return "cancelled";
    case CartesianEnd::kTimeout:
      return "timeout";
  }
  return "unknown";
}

Result<CartesianPlanner> CartesianPlanner::make(CollisionChecker& checker, const ArmChain& chain,
                                                const CartesianParams& params) {
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
  const char* wrong = nullptr;
  if (!within(params.position_tolerance_m, 1e-6, 0.1)) wrong = "position_tolerance_m: 1e-6 to 0.1 m";
  if (!within(params.orientation_tolerance_rad, 1e-5, 0.5))
    wrong = "orientation_tolerance_rad: 1e-5 to 0.5 rad";
  if (!within(params.max_step_m, 1e-3, 0.5)) wrong = "max_step_m: 1e-3 to 0.5 m";
  if (!within(params.max_joint_step_rad, 0.01, 1.0)) wrong = "max_joint_step_rad: 0.01 to 1 rad";
  if (!within(params.max_attempts, 1, 1000)) wrong = "max_attempts: 1 to 1000";
  if (!within(params.limit_repair_rad, 0, 0.2)) wrong = "limit_repair_rad: 0 to 0.2 rad";
  if (!(params.timeout_s > 0)) wrong = "timeout_s: more than 0 s";
  if (wrong != nullptr) return fail(ErrorCode::kInvalidArgument, std::string("CartesianParams::") + wrong);
  auto arm = ArmInGroup::make(chain, checker.model().joint_names());
  if (!arm) return tl::unexpected<Error>(arm.error());
  return CartesianPlanner(checker, *std::move(arm), params);
}

CartesianPlanner::CartesianPlanner(CollisionChecker& checker, ArmInGroup arm, const CartesianParams& params)
    : checker_(&checker), arm_(std::make_unique<const ArmInGroup>(std::move(arm))), params_(params) {}
CartesianPlanner::CartesianPlanner(CartesianPlanner&&) noexcept = default;
CartesianPlanner& CartesianPlanner::operator=(CartesianPlanner&&) noexcept = default;
CartesianPlanner::~CartesianPlanner() = default;

CartesianResult CartesianPlanner::plan(const CartesianRequest& request) {
  const Stopwatch watch;
  if (auto refusal = refuse_shape(request, checker_->model().joint_count())) return *refusal;
  JointVector start = request.start;
  if (auto refusal = refuse_start(*checker_, params_.limit_repair_rad, start)) return *refusal;
  std::vector<Pose> poses{arm_->chain().forward(arm_->take(start))};
  poses.insert(poses.end(), request.poses.begin(), request.poses.end());
  const ToolPath path(poses);
  Follower follower(*checker_, *arm_, params_, path, start);
  const auto interrupted = [&] {
    if (request.cancelled && request.cancelled()) return CartesianEnd::kCancelled;
    return watch.seconds() > params_.timeout_s ? CartesianEnd::kTimeout : CartesianEnd::kComplete;
  };
  Attempts attempts(follower, {arm_->take(start), 0.0});
  attempts.run(arm_->joint_count() > 6 ? params_.max_attempts : 1, interrupted);

  CartesianResult result;
  result.end = attempts.stop().end;
  result.attempts = attempts.made();
  for (const Station& station : attempts.best()) {
    result.waypoints.push_back(arm_->put(station.joints, start));
    result.progress.push_back(path.length() > 0 ? station.place / path.length() : 1.0);
  }
  result.fraction = result.end == CartesianEnd::kComplete ? 1.0 : result.progress.back();
  if (result.end == CartesianEnd::kComplete) return result;
  result.contact = attempts.stop().contact;
  if (attempts.stop().joint >= 0) result.joint = arm_->chain().joint_names()[attempts.stop().joint];
  result.message = describe(attempts.stop(), arm_->chain(), result.fraction);
  return result;
}

}  // namespace extperfc::arm
