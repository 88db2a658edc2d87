#include "ros/navigate/plan_worker.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "extperfc/base/stopwatch.hpp"
#include "extperfc/navigate/escape_path.hpp"
#include "extperfc/navigate/yield_place.hpp"

namespace extperfc::ros_navigate {

namespace {

using navigate::Contact;
using navigate::CostGrid;
using navigate::NavCode;

constexpr navigate::Cost kAvoidedCost = 252;  // the highest that is not blocked
constexpr double kNearM = 0.3;                // the robot stands here already
constexpr double kMarginM = 0.045;            // by which the footprint is smaller to call a path blocked
// A wall covers every cell that it touches, so a door of the map is up to two cells too narrow. Where there
// is no path, the footprint is smaller by these parts of a cell; the local planner and the guard see the true
// gap.
constexpr double kSmallerByCells[] = {0.5, kSmallestByCells};

/// A copy with high costs where plans shall not go unless there is nothing else.
std::shared_ptr<const CostGrid> with_avoided(const std::shared_ptr<const CostGrid>& costs,
                                             const std::vector<navigate::AvoidedPlace>& places) {
  if (places.empty()) return costs;
  auto changed = std::make_shared<CostGrid>(*costs);
  for (const auto& place : places) {
    const auto low = changed->cell_around(place.middle_m - Eigen::Vector2d::Constant(place.radius_m));
    const auto high = changed->cell_around(place.middle_m + Eigen::Vector2d::Constant(place.radius_m));
    const auto box = navigate::CellBox{low, {high.column + 1, high.row + 1}}.clipped(changed->box());
    for (int row = box.min.row; row < box.max.row; ++row)
      for (int column = box.min.column; column < box.max.column; ++column) {
        auto& cost = changed->at({column, row});
        if (cost < kAvoidedCost &&
            (changed->middle_of({column, row}) - place.middle_m).norm() <= place.radius_m)
          cost = kAvoidedCost;
      }
  }
  return changed;
}

std::optional<Pose2> first_touch(const CostGrid& costs, const navigate::Footprint& footprint,
                                 const navigate::Path& path) {
  if (path.poses.empty()) return std::nullopt;
  const auto& here = path.poses.front();
  const auto touch = std::find_if(path.poses.begin(), path.poses.end(), [&](const Pose2& pose) {
    return std::hypot(pose.x - here.x, pose.y - here.y) > kNearM &&
           contact(costs, footprint, pose) == Contact::kObstacle;
  });
  if (touch == path.poses.end()) return std::nullopt;
  return *touch;
}

}  // namespace

PlanWorker::PlanWorker(std::shared_ptr<navigate::GlobalPlanner> planner, Look look, OnAnswer on_answer)
    : look_(std::move(look)), on_answer_(std::move(on_answer)), planner_(std::move(planner)) {
  worker_ = std::thread([this] {
    while (auto wish = waiting_.take()) on_answer_(answer(*wish));
  });
}

PlanWorker::~PlanWorker() {
  cancel_ = true;
  waiting_.close();
  if (worker_.joinable()) worker_.join();
}

void PlanWorker::ask(navigate::PlanWish wish) {
  cancel_ = true;
  (void)waiting_.put(std::move(wish));
}

void PlanWorker::set_planner(std::shared_ptr<navigate::GlobalPlanner> planner) {
  const std::lock_guard lock(planner_mutex_);
  planner_ = std::move(planner);
}

navigate::PlanAnswer PlanWorker::answer(const navigate::PlanWish& wish) {
  cancel_ = false;
  const Stopwatch watch;
  navigate::PlanAnswer made;
  made.id = wish.id;
  const auto scene = look_();
  if (!scene.costs) {
    made.path = navigate::nav_fail(NavCode::kNoMap, "no map to plan in");
    return made;
  }
  made.blocked_at = first_touch(*scene.costs, scene.footprint->padded(-kMarginM), wish.current);
  auto request = wish.request;
  request.cancel = &cancel_;
  if (wish.yield_to_m) {
    const auto place = yield_place(*scene.costs, *scene.footprint, request.start, *wish.yield_to_m);
    if (!place) {
      made.path = navigate::nav_fail(NavCode::kNoPath, "no place near where the person could pass");
      return made;
    }
    request.goal = *place;
  }
  made.path = plan({with_avoided(scene.costs, wish.avoid), scene.footprint}, request);
  if (made.path)
    health_.done(watch.milliseconds(), watch.milliseconds());
  else
    (void)health_.failed(made.path.error().message);
  return made;
}

navigate::NavResult<navigate::Path> PlanWorker::plan_now(const navigate::PlanRequest& request) {
  const auto scene = look_();
  if (!scene.costs) return navigate::nav_fail(NavCode::kNoMap, "no map to plan in");
  return plan(scene, request);
}

navigate::NavResult<navigate::Path> PlanWorker::plan(const Scene& scene,
                                                     const navigate::PlanRequest& request) {
  const std::lock_guard lock(planner_mutex_);
  try {
    auto path = plan_from_free(scene, request);
    if (path || path.error().code != NavCode::kStartBlocked) return path;
    const auto out = escape_path(*scene.costs, *scene.footprint, request.start, scene.base);
    // In a door nothing near is free of what the cells make of its jambs.
    if (!out) return plan_smaller(scene, request, std::move(path));
    auto after = request;
    after.start = out->poses.back();
    path = plan_from_free(scene, after);
    if (!path) return path;
    path->poses.insert(path->poses.begin(), out->poses.begin(), out->poses.end() - 1);
    path->cost += out->cost;
    return path;
  } catch (const std::exception& error) {
    return navigate::nav_fail(NavCode::kInvalidRequest,
                              std::string("the global planner failed: ") + error.what());
  }
}

navigate::NavResult<navigate::Path> PlanWorker::plan_from_free(const Scene& scene,
                                                               const navigate::PlanRequest& request) {
  auto path = planner_->plan(*scene.costs, *scene.footprint, request);
  if (path || path.error().code != NavCode::kNoPath) return path;
  return plan_smaller(scene, request, std::move(path));
}

navigate::NavResult<navigate::Path> PlanWorker::plan_smaller(const Scene& scene,
                                                             const navigate::PlanRequest& request,
                                                             navigate::NavResult<navigate::Path> path) {
  for (const double part : kSmallerByCells) {
    if (path) break;
    const auto smaller = scene.footprint->padded(-part * scene.costs->resolution_m);
    if (auto found = planner_->plan(*scene.costs, smaller, request)) path = std::move(found);
  }
  return path;
}

}  // namespace extperfc::ros_navigate
