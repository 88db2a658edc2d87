#include "ros/navigate/guard_thread.hpp"

#include <chrono>
#include <utility>

namespace extperfc::ros_navigate {

namespace {

constexpr auto kSilence = std::chrono::milliseconds(300);  // of the control cycle, of wall time

}  // namespace

GuardThread::GuardThread(const navigate::GuardParams& params, double memory_m, Send send)
    : send_(std::move(send)), guard_(params), memory_(memory_m), thread_([this] { run(); }) {}

GuardThread::~GuardThread() {
  bool sending = false;
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    sending = sending_;
  }
  ready_.notify_all();
  thread_.join();
  if (sending) send_({});
}

void GuardThread::set_points(std::vector<Eigen::Vector2d> points_m, double stamp_s,
                             const navigate::Footprint& footprint, const Pose2& odom_T_base) {
  const std::lock_guard lock(mutex_);
  memory_.complete(points_m, footprint, odom_T_base);
  guard_.set_points(std::move(points_m), stamp_s);
}

void GuardThread::command(Command command) {
  {
    const std::lock_guard lock(mutex_);
    command_ = std::move(command);
    fresh_ = true;
  }
  ready_.notify_all();
}

void GuardThread::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    ready_.wait_for(lock, kSilence, [this] { return fresh_ || closed_; });
    if (closed_) return;
    const bool silent = !std::exchange(fresh_, false);
    if (silent && !sending_) continue;
    const bool drives = !silent && !is_zero(command_.wanted);
    admitted_ = drives ? guard_.admit(*command_.footprint, command_.measured, command_.wanted, command_.now_s)
                       : navigate::GuardedCommand{};
    sending_ = !silent && !command_.last;
    const Twist2 velocity = admitted_.velocity;
    lock.unlock();
    send_(velocity);
    lock.lock();
  }
}

bool GuardThread::stopped() const {
  const std::lock_guard lock(mutex_);
  return admitted_.action == navigate::GuardAction::kStopped ||
         admitted_.action == navigate::GuardAction::kNoScan;
}

std::string GuardThread::reason() const {
  const std::lock_guard lock(mutex_);
  return admitted_.reason;
}

}  // namespace extperfc::ros_navigate
