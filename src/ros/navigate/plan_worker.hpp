#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "extperfc/base/latest_slot.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/global_planner.hpp"
#include "extperfc/navigate/navigator.hpp"

#include "ros/health/stream_health.hpp"

namespace extperfc::ros_navigate {

/// By this part of a cell of the map the footprint is smaller at most when plans are made.
inline constexpr double kSmallestByCells = 0.85;

/// Makes plans in a thread, so that the control cycle never waits. The newest wish cancels the one under way.
class PlanWorker {
 public:
  /// What a plan is made with; null grid: no map.
  struct Scene {
    std::shared_ptr<const navigate::CostGrid> costs;
    std::shared_ptr<const navigate::Footprint> footprint;
    navigate::BaseKind base{navigate::BaseKind::kHolonomic};
  };
  using Look = std::function<Scene()>;
  using OnAnswer = std::function<void(navigate::PlanAnswer)>;

  PlanWorker(std::shared_ptr<navigate::GlobalPlanner> planner, Look look, OnAnswer on_answer);
  ~PlanWorker();
  PlanWorker(const PlanWorker&) = delete;
  PlanWorker& operator=(const PlanWorker&) = delete;

  void ask(navigate::PlanWish wish);
  void set_planner(std::shared_ptr<navigate::GlobalPlanner> planner);
  /// For another thread's request: waits for its turn with the planner.
  [[nodiscard]] navigate::NavResult<navigate::Path> plan_now(const navigate::PlanRequest& request);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status) { health_.report(status); }

 private:
  [[nodiscard]] navigate::PlanAnswer answer(const navigate::PlanWish& wish);
  [[nodiscard]] navigate::NavResult<navigate::Path> plan(const Scene& scene,
                                                         const navigate::PlanRequest& request);
  [[nodiscard]] navigate::NavResult<navigate::Path> plan_from_free(const Scene& scene,
                                                                   const navigate::PlanRequest& request);
  /// With footprints that are smaller by what cells may be wrong; `path`: what the footprint itself gave.
  [[nodiscard]] navigate::NavResult<navigate::Path> plan_smaller(const Scene& scene,
                                                                 const navigate::PlanRequest& request,
                                                                 navigate::NavResult<navigate::Path> path);

  const Look look_;
  const OnAnswer on_answer_;
  std::mutex planner_mutex_;  ///< held while it plans
  std::shared_ptr<navigate::GlobalPlanner> planner_;
  std::atomic<bool> cancel_{false};
  ros_health::WorkHealth health_;
  LatestSlot<navigate::PlanWish> waiting_;
  std::thread worker_;
};

}  // namespace extperfc::ros_navigate
