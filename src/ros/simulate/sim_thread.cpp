#include "ros/simulate/sim_thread.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <ros/console.h>
#include <rosgraph_msgs/Clock.h>
#include <std_msgs/Float32.h>

namespace extperfc::ros_simulate {

SimThread::SimThread(ros::NodeHandle handle, const ros_params::SimTimeParams& params,
                     std::unique_ptr<simulate::Simulator> simulator)
    : params_(params),
      simulator_(std::move(simulator)),
      steps_per_clock_(static_cast<std::uint64_t>(
          std::max(1L, std::lround(1.0 / (params.clock_hz * simulator_->params().bodies.step_s))))),
      pacer_(params.real_time_factor),
      paused_(params.paused),
      clock_offset_s_(params.start_time_s) {
  constexpr bool kLatched = true;  // a node that starts while time stands still must know the time too
  if (params_.publish_clock)
    clock_publisher_ = handle.advertise<rosgraph_msgs::Clock>("/clock", 10, kLatched);
  factor_publisher_ = handle.advertise<std_msgs::Float32>("sim/real_time_factor", 2, kLatched);
  note_status();
}

SimThread::~SimThread() {
  stop();
}

bool SimThread::post(Work work) {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_ || posted_.size() >= kLongestQueue) return false;
    posted_.push_back(std::move(work));
  }
  wake_.notify_one();
  return true;
}

void SimThread::after_step(std::function<void(const simulate::Simulator&, const ros::Time&)> publish) {
  after_step_.push_back(std::move(publish));
}

void SimThread::start() {
  thread_ = std::thread([this] { run(); });
}

void SimThread::stop() {
  std::deque<Work> dropped;  // destroyed without the lock: waiting callers wake up
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    dropped.swap(posted_);
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
  order_.reset();
}

void SimThread::run() {
  const auto now = Pacer::Clock::now();
  pacer_.restart(now);
  meter_.restart(now);
  publish_clock();
  publish_factor(0.0);
  while (wait_for_work()) {
    run_posted();
    if (may_step()) step();
  }
}

/// Until a step is due or something was posted. False at the end.
bool SimThread::wait_for_work() {
  std::unique_lock lock(mutex_);
  const auto woken = [this] { return stopping_ || !posted_.empty(); };
  if (order_) return !stopping_;
  if (paused_) {
    wake_.wait(lock, woken);
  } else {
    wake_.wait_until(lock, pacer_.due(Pacer::Clock::now()), woken);
  }
  return !stopping_;
}

void SimThread::run_posted() {
  std::deque<Work> work;
  {
    const std::lock_guard lock(mutex_);
    work.swap(posted_);
  }
  for (const auto& one : work) {
    try {
      one(*simulator_);
    } catch (const std::exception& error) {
      ROS_ERROR("a command to the simulation failed: %s", error.what());
    }
  }
}

bool SimThread::may_step() {
  if (order_) return true;
  if (paused_) return false;
  const auto now = Pacer::Clock::now();
  return pacer_.due(now) <= now;
}

void SimThread::step() {
  simulator_->step();
  ++steps_;
  const ros::Time stamp(published_s());
  if (steps_ % steps_per_clock_ == 0) publish_clock();
  for (const auto& publish : after_step_) publish(*simulator_, stamp);
  if (params_.lockstep || order_) settle_();
  pacer_.advance(simulator_->params().bodies.step_s);
  measure();
  if (order_ && --order_->left == 0) finish_order();
}

void SimThread::finish_order() {
  publish_clock();
  note_status();
  order_->done.set_value(ros::Time(published_s()));
  order_.reset();
}

void SimThread::measure() {
  if (paused_) return;
  if (const auto factor = meter_.stepped(simulator_->params().bodies.step_s, Pacer::Clock::now()))
    publish_factor(*factor);
}

Result<ros::Time> SimThread::run_steps(std::uint32_t count) {
  if (count == 0) return fail(ErrorCode::kInvalidArgument, "steps must be at least 1");
  try {
    auto done = ask([this, count](simulate::Simulator&) -> Result<std::shared_future<Result<ros::Time>>> {
      if (!paused_) return fail(ErrorCode::kFailed, "the simulation runs: pause it first (sim/pause)");
      if (order_) return fail(ErrorCode::kFailed, "another call is stepping: wait until it is done");
      order_ = Order{count, {}};
      return order_->done.get_future().share();
    });
    if (!done) return tl::unexpected(done.error());
    return done->get();
  } catch (const std::exception&) {  // a promise that breaks at the end is std::future_error
    return fail(ErrorCode::kFailed, "the simulation ends");
  }
}

void SimThread::set_paused(bool paused) {
  if (paused == paused_) return;
  paused_ = paused;
  const auto now = Pacer::Clock::now();
  pacer_.restart(now);
  meter_.restart(now);
  publish_clock();
  publish_factor(0.0);
}

void SimThread::set_real_time_factor(double factor) {
  const auto now = Pacer::Clock::now();
  pacer_.set_factor(factor, now);
  meter_.restart(now);
  note_status();
}

Result<void> SimThread::reset(simulate::Simulator& simulator) {
  if (auto done = simulator.reset(); !done) return done;
  clock_offset_s_ = params_.start_time_s;
  publish_clock();
  note_status();
  return {};
}

void SimThread::jump_clock(double seconds) {
  clock_offset_s_ = std::max(clock_offset_s_ + seconds, params_.start_time_s - simulator_->time_s());
  publish_clock();
}

double SimThread::published_s() const {
  return clock_offset_s_ + simulator_->time_s();
}

void SimThread::publish_clock() {
  if (!clock_publisher_) return;
  const auto message = boost::make_shared<rosgraph_msgs::Clock>();
  message->clock = ros::Time(published_s());
  clock_publisher_.publish(message);
}

void SimThread::publish_factor(double factor) {
  measured_factor_ = factor;
  const auto message = boost::make_shared<std_msgs::Float32>();
  message->data = static_cast<float>(factor);
  factor_publisher_.publish(message);
  note_status();
}

void SimThread::note_status() {
  const std::lock_guard lock(status_mutex_);
  status_ = {paused_, pacer_.factor(),       measured_factor_, simulator_->time_s(),
             steps_,  pacer_.debts_dropped()};
}

SimThread::Status SimThread::status() const {
  const std::lock_guard lock(status_mutex_);
  return status_;
}

}  // namespace extperfc::ros_simulate
