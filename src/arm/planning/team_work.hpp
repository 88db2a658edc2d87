#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "extperfc/arm/planning_team.hpp"

#include "arm/planning/request_validator.hpp"
#include "arm/planning/rrt_connect.hpp"
#include "arm/planning/search.hpp"

namespace extperfc::arm {

/// A problem whose states are good.
struct TeamProblem {
  const CollisionChecker& checker;  ///< to clone; not used meanwhile
  const JointLimits& limits;
  const PlanningTeamParams& params;
  const Checked& request;
};

[[nodiscard]] bool is_ours(const TeamMember& member);
[[nodiscard]] PlannerParams params_of(const PlanningTeamParams& params, const TeamMember& member,
                                      std::uint64_t seed);

/// Threads that run one function each until it returns, and a caller that waits. Joined at the end, always.
class Crew {
 public:
  ~Crew();
  void add(std::function<void()> work);
  /// Waits for all, asking `interrupted` every 2 ms; once it says yes, stopped() is true. Throws what a
  /// thread threw.
  void wait(const std::function<bool()>& interrupted);
  void stop() { stopped_ = true; }
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;
  std::condition_variable ended_;
  std::size_t running_{0};      // guarded by mutex_
  std::exception_ptr failure_;  // guarded by mutex_
  std::vector<std::thread> threads_;
};

/// The first path in the order of (round, member); the argument stands at PlanningTeam.
class FirstPath {
 public:
  explicit FirstPath(const TeamProblem& problem);

  struct Winner {
    Found found;
    int member{-1};
  };
  [[nodiscard]] std::optional<Winner> run(const std::function<bool()>& interrupted);
  /// In the trees of all members.
  [[nodiscard]] int states() const;

 private:
  struct Task {
    int member;
    std::uint64_t round{0};
    bool busy{false};
    std::unique_ptr<CollisionChecker> checker;
    std::unique_ptr<Search> search;
  };

  static constexpr std::uint64_t kNever = ~std::uint64_t{0};
  [[nodiscard]] static std::uint64_t key(const Task& task) {
    return task.round * 256 + static_cast<std::uint64_t>(task.member);
  }

  void work();
  [[nodiscard]] Task* next(std::unique_lock<std::mutex>& lock);
  void ask_ompl(int member);

  const TeamProblem& problem_;
  Crew crew_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Task> tasks_;  // guarded by mutex_ but for a busy one's search
  std::atomic<std::uint64_t> best_{kNever};
  std::optional<Winner> winner_;  // guarded by mutex_
};

/// The best of many paths.
class BestPath {
 public:
  BestPath(const TeamProblem& problem, int max_attempts);

  struct Winner {
    std::vector<JointVector> waypoints;
    int goal{-1};
    int member{-1};
    double cost{0};
    int attempt{-1};
  };
  [[nodiscard]] std::optional<Winner> run(const std::function<bool()>& interrupted);
  [[nodiscard]] int attempts() const { return ended_; }
  [[nodiscard]] int found() const { return found_; }

 private:
  void work();
  [[nodiscard]] std::optional<Winner> attempt(int number);
  [[nodiscard]] bool goes_on(int number) const;
  [[nodiscard]] bool better(const Winner& winner) const;

  const TeamProblem& problem_;
  const int max_attempts_;
  const bool any_starts_over_;
  Crew crew_;
  std::atomic<int> next_{0};
  std::mutex mutex_;
  std::optional<Winner> winner_;  // guarded by mutex_, like the counts
  int ended_{0};
  int found_{0};
};

}  // namespace extperfc::arm
