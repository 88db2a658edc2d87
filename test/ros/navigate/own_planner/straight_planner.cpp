#include <pluginlib/class_list_macros.hpp>

#include "extperfc/navigate/global_planner.hpp"

namespace own_planner {

namespace nav = extperfc::navigate;

class StraightPlanner : public nav::GlobalPlanner {
 public:
  nav::NavResult<nav::Path> plan(const nav::CostGrid& /*costs*/, const nav::Footprint& /*footprint*/,
                                 const nav::PlanRequest& request) override {
    constexpr int kPoses = 100;
    nav::Path path;
    for (int i = 0; i <= kPoses; ++i) {
      const double part = static_cast<double>(i) / kPoses;
      path.poses.push_back({request.start.x + part * (request.goal.x - request.start.x),
                            request.start.y + part * (request.goal.y - request.start.y),
                            i < kPoses ? request.start.yaw : request.goal.yaw});
    }
    return path;
  }
};

}  // namespace own_planner

PLUGINLIB_EXPORT_CLASS(own_planner::StraightPlanner, extperfc::navigate::GlobalPlanner)
