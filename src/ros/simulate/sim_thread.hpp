#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/simulator.hpp"

#include "ros/params/simulator_params.hpp"
#include "ros/simulate/pacer.hpp"
#include "ros/simulate/sim_host.hpp"

namespace extperfc::ros_simulate {

/// Steps the simulator in a separate thread, at the wanted real-time factor, and publishes its clock.
/// Published time = start_time_s + the simulator's time + what clock jumps added.
///
/// Publishes:
///   /clock                rosgraph_msgs/Clock, latched
///   sim/real_time_factor  std_msgs/Float32, once a second of real time; 0 while paused
class SimThread : public SimHost {
 public:
  SimThread(ros::NodeHandle handle, const ros_params::SimTimeParams& params,
            std::unique_ptr<simulate::Simulator> simulator);
  ~SimThread() override;
  SimThread(const SimThread&) = delete;
  SimThread& operator=(const SimThread&) = delete;

  bool post(std::function<void(simulate::Simulator&)> work) override;
  void after_step(std::function<void(const simulate::Simulator&, const ros::Time&)> publish) override;
  /// `wait` returns when what the last step caused elsewhere is done. Called after every step in lockstep and
  /// in run_steps(). Register before start().
  void when_settling(std::function<void()> wait) { settle_ = std::move(wait); }

  void start();
  /// Ends the thread after its present step; what was posted and did not run yet is dropped. Harmless twice.
  void stop();

  /// Makes steps while paused, and returns the time afterwards. Any thread but the simulation's. Errors: not
  /// paused, others are stepping, the simulation ends.
  [[nodiscard]] Result<ros::Time> run_steps(std::uint32_t count);

  // For work that runs in the simulation thread.
  void set_paused(bool paused);
  void set_real_time_factor(double factor);
  Result<void> reset(simulate::Simulator& simulator);
  /// The published time never falls below the start time.
  void jump_clock(double seconds);

  struct Status {
    bool paused{false};
    double wanted_factor{1.0};
    double measured_factor{0.0};
    double simulated_s{0.0};
    std::uint64_t steps{0};
    std::uint64_t debts_dropped{0};
  };
  [[nodiscard]] Status status() const;

 private:
  using Work = std::function<void(simulate::Simulator&)>;
  static constexpr std::size_t kLongestQueue = 1000;

  /// Steps that a caller waits for.
  struct Order {
    std::uint32_t left{0};
    std::promise<Result<ros::Time>> done;
  };

  void run();
  bool wait_for_work();
  void run_posted();
  [[nodiscard]] bool may_step();
  void step();
  void finish_order();
  void measure();
  void publish_clock();
  void publish_factor(double factor);
  void note_status();
  [[nodiscard]] double published_s() const;

  const ros_params::SimTimeParams params_;
  const std::unique_ptr<simulate::Simulator> simulator_;
  std::vector<std::function<void(const simulate::Simulator&, const ros::Time&)>> after_step_;
  std::function<void()> settle_{[] {}};
  ros::Publisher clock_publisher_;
  ros::Publisher factor_publisher_;
  const std::uint64_t steps_per_clock_;

  // Of the simulation thread alone.
  Pacer pacer_;
  FactorMeter meter_;
  bool paused_;
  double clock_offset_s_;
  double measured_factor_{0.0};
  std::uint64_t steps_{0};
  std::optional<Order> order_;

  mutable std::mutex status_mutex_;
  Status status_;

  std::mutex mutex_;  ///< guards the queue and the end; not held while work runs
  std::condition_variable wake_;
  std::deque<Work> posted_;
  bool stopping_{false};
  std::thread thread_;
};

}  // namespace extperfc::ros_simulate
