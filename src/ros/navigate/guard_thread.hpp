#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <ros/time.h>

#include "extperfc/navigate/collision_guard.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/near_memory.hpp"

namespace extperfc::ros_navigate {

/// Has the last word on the velocity, in its own thread: every command passes the collision guard, and a
/// control cycle that falls silent while it drives is answered with zero. Thread-safe.
class GuardThread {
 public:
  struct Command {
    Twist2 wanted;
    Twist2 measured;
    std::shared_ptr<const navigate::Footprint> footprint;
    double now_s{0};
    bool last{false};  ///< the goal ended: send this, and no more
  };
  using Send = std::function<void(const Twist2&)>;

  /// memory_m: see NearMemory.
  GuardThread(const navigate::GuardParams& params, double memory_m, Send send);
  /// Sends zero if it was sending.
  ~GuardThread();
  GuardThread(const GuardThread&) = delete;
  GuardThread& operator=(const GuardThread&) = delete;

  /// End points of a scan in the base's frame, and the base's pose then.
  void set_points(std::vector<Eigen::Vector2d> points_m, double stamp_s, const navigate::Footprint& footprint,
                  const Pose2& odom_T_base);
  void command(Command command);
  /// Whether the latest command was stopped though it was to move.
  [[nodiscard]] bool stopped() const;
  [[nodiscard]] std::string reason() const;

 private:
  void run();

  const Send send_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::condition_variable ready_;
  navigate::CollisionGuard guard_;
  navigate::NearMemory memory_;
  Command command_;
  bool fresh_{false};
  bool sending_{false};
  bool closed_{false};
  navigate::GuardedCommand admitted_;
  std::thread thread_;
};

}  // namespace extperfc::ros_navigate
