#include "arm/planning/team_work.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "extperfc/base/stopwatch.hpp"

#include "arm/planning/ompl_search.hpp"
#include "arm/planning/shortcuts.hpp"

namespace extperfc::arm {

namespace {

constexpr auto kAskEvery = std::chrono::milliseconds(2);
/// Of the first round; small, so that a member that has to finish its round is soon done.
constexpr int kFirstSamples = 100;
constexpr double kLastShortcuts_s = 0.005;
constexpr std::uint64_t kSeedStep = 0x9E3779B97F4A7C15;

}  // namespace

bool is_ours(const TeamMember& member) {
  const auto& others = ompl_planners();
  return std::find(others.begin(), others.end(), member.planner) == others.end();
}

PlannerParams params_of(const PlanningTeamParams& params, const TeamMember& member, std::uint64_t seed) {
  PlannerParams result = params.planner;
  result.planner = member.planner;
  result.seed = seed;
  return result;
}

Crew::~Crew() {
  stop();
  for (auto& thread : threads_)
    if (thread.joinable()) thread.join();
}

void Crew::add(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    ++running_;
  }
  threads_.emplace_back([this, work = std::move(work)] {
    std::exception_ptr failure;
    try {
      work();
    } catch (...) {
      failure = std::current_exception();
      stop();
    }
    const std::lock_guard lock(mutex_);
    if (failure && !failure_) failure_ = failure;
    --running_;
    ended_.notify_all();
  });
}

void Crew::wait(const std::function<bool()>& interrupted) {
  {
    std::unique_lock lock(mutex_);
    while (running_ > 0) {
      ended_.wait_for(lock, kAskEvery);
      lock.unlock();
      if (!stopped() && interrupted()) stop();
      lock.lock();
    }
  }
  for (auto& thread : threads_) thread.join();
  threads_.clear();
  if (failure_) std::rethrow_exception(failure_);
}

FirstPath::FirstPath(const TeamProblem& problem) : problem_(problem) {
  const auto& members = problem.params.members;
  for (std::size_t m = 0; m < members.size(); ++m) {
    if (!is_ours(members[m])) continue;
    Task task;
    task.member = static_cast<int>(m);
    task.checker = std::make_unique<CollisionChecker>(problem.checker.clone());
    task.search = std::make_unique<Search>(
        *task.checker, problem.limits, params_of(problem.params, members[m], members[m].seed), kFirstSamples);
    task.search->begin(problem.request.start, problem.request.goals);
    tasks_.push_back(std::move(task));
  }
}

std::optional<FirstPath::Winner> FirstPath::run(const std::function<bool()>& interrupted) {
  const auto& members = problem_.params.members;
  const int others = static_cast<int>(members.size() - tasks_.size());
  for (std::size_t m = 0; m < members.size(); ++m)
    if (!is_ours(members[m])) crew_.add([this, m] { ask_ompl(static_cast<int>(m)); });
  const int workers = std::min(problem_.params.threads - others, static_cast<int>(tasks_.size()));
  for (int i = 0; i < workers; ++i) crew_.add([this] { work(); });
  crew_.wait([&] {
    if (!interrupted()) return false;
    crew_.stop();
    changed_.notify_all();
    return true;
  });
  return std::move(winner_);
}

int FirstPath::states() const {
  int states = 0;
  for (const Task& task : tasks_) states += task.search->states();
  return states;
}

/// The task that comes first and may still win; waits while only others' tasks may; null when none may.
FirstPath::Task* FirstPath::next(std::unique_lock<std::mutex>& lock) {
  while (!crew_.stopped()) {
    Task* first = nullptr;
    bool any_busy = false;
    for (Task& task : tasks_) {
      if (key(task) >= best_) continue;
      any_busy = any_busy || task.busy;
      if (task.busy || task.search->exhausted()) continue;
      if (first == nullptr || key(task) < key(*first)) first = &task;
    }
    if (first != nullptr || !any_busy) return first;
    changed_.wait_for(lock, std::chrono::milliseconds(20));  // a stop of the crew is not announced
  }
  return nullptr;
}

void FirstPath::work() {
  std::unique_lock lock(mutex_);
  while (Task* task = next(lock)) {
    task->busy = true;
    const std::uint64_t own = key(*task);
    lock.unlock();
    auto found = task->search->run_round([&] { return crew_.stopped() || best_ < own; });
    lock.lock();
    task->busy = false;
    if (!found) {
      ++task->round;
    } else if (own < best_) {
      best_ = own;
      winner_ = Winner{std::move(*found), task->member};
    }
    changed_.notify_all();
  }
}

void FirstPath::ask_ompl(int member) {
  const auto& who = problem_.params.members[static_cast<std::size_t>(member)];
  CollisionChecker checker = problem_.checker.clone();
  auto found =
      ompl_search(checker, problem_.limits, params_of(problem_.params, who, who.seed), problem_.request.start,
                  problem_.request.goals, false, [this] { return crew_.stopped() || best_ != kNever; });
  const std::lock_guard lock(mutex_);
  if (!found || best_ != kNever) return;
  best_ = 0;
  winner_ = Winner{std::move(*found), member};
  changed_.notify_all();
}

BestPath::BestPath(const TeamProblem& problem, int max_attempts)
    : problem_(problem),
      max_attempts_(max_attempts),
      any_starts_over_(std::any_of(problem.params.members.begin(), problem.params.members.end(),
                                   [](const TeamMember& member) { return !improves(member.planner); })) {}

std::optional<BestPath::Winner> BestPath::run(const std::function<bool()>& interrupted) {
  for (int i = 0; i < std::min(problem_.params.threads, max_attempts_); ++i) crew_.add([this] { work(); });
  crew_.wait(interrupted);
  return std::move(winner_);
}

void BestPath::work() {
  while (!crew_.stopped()) {
    const int number = next_++;
    if (number >= max_attempts_) return;
    if (goes_on(number)) {
      if (!any_starts_over_) return;
      continue;
    }
    auto result = attempt(number);
    const std::lock_guard lock(mutex_);
    ++ended_;
    if (!result) continue;
    ++found_;
    if (!winner_ || better(*result)) winner_ = std::move(result);
  }
}

/// An attempt of a member that is still at its first one.
bool BestPath::goes_on(int number) const {
  const auto& members = problem_.params.members;
  const auto count = static_cast<int>(members.size());
  return number >= count && improves(members[static_cast<std::size_t>(number % count)].planner);
}

bool BestPath::better(const Winner& winner) const {
  if (winner.cost != winner_->cost) return winner.cost < winner_->cost;
  return winner.attempt < winner_->attempt;
}

std::optional<BestPath::Winner> BestPath::attempt(int number) {
  const auto& members = problem_.params.members;
  const int member = number % static_cast<int>(members.size());
  const auto& who = members[static_cast<std::size_t>(member)];
  const auto round = static_cast<std::uint64_t>(number / static_cast<int>(members.size()));
  const PlannerParams params = params_of(problem_.params, who, who.seed + round * kSeedStep);
  CollisionChecker checker = problem_.checker.clone();
  const auto stop = [this] { return crew_.stopped(); };
  std::optional<Found> found;
  if (is_ours(who))
    found =
        Search(checker, problem_.limits, params).run(problem_.request.start, problem_.request.goals, stop);
  else
    found = ompl_search(checker, problem_.limits, params, problem_.request.start, problem_.request.goals,
                        true, stop);
  if (!found) return std::nullopt;
  Rng rng(params.seed);
  Winner winner;
  const Stopwatch watch;  // a path that the end of the time brought is shortened too
  winner.waypoints = shorten(checker, std::move(found->waypoints), params.shortcut_rounds, rng,
                             [&] { return stop() && watch.seconds() > kLastShortcuts_s; });
  winner.goal = found->goal;
  winner.member = member;
  winner.attempt = number;
  winner.cost = problem_.params.cost ? problem_.params.cost(winner.waypoints) : path_length(winner.waypoints);
  return winner;
}

}  // namespace extperfc::arm
