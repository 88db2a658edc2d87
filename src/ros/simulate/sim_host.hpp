#pragma once

#include <functional>
#include <future>
#include <memory>
#include <stdexcept>
#include <utility>

#include <ros/time.h>

#include "extperfc/simulate/simulator.hpp"

namespace extperfc::ros_simulate {

/// Owner of the simulation thread, the only thread that touches the Simulator. Interfaces to ROS hand their
/// commands over and publish from after_step().
class SimHost {
 public:
  virtual ~SimHost() = default;

  /// Runs `work` in the simulation thread before the next step, also while paused. False (and nothing runs)
  /// when 1000 wait already or the simulation ends. Any thread; never blocks.
  virtual bool post(std::function<void(simulate::Simulator&)> work) = 0;

  /// As post(), and waits for what `work` returns; never from the simulation thread itself. Throws
  /// std::runtime_error when the simulation ends meanwhile.
  template <typename Work>
  auto ask(Work work) -> decltype(work(std::declval<simulate::Simulator&>())) {
    using Answer = decltype(work(std::declval<simulate::Simulator&>()));
    auto task = std::make_shared<std::packaged_task<Answer(simulate::Simulator&)>>(std::move(work));
    auto answer = task->get_future();
    if (!post([task](simulate::Simulator& simulator) { (*task)(simulator); }))
      throw std::runtime_error("the simulation does not take commands");
    try {
      return answer.get();
    } catch (const std::future_error&) {  // the work was dropped
      throw std::runtime_error("the simulation ends");
    }
  }

  /// `publish` is called in the simulation thread after every step with the step's stamp; keep it short.
  /// Register before the simulation starts.
  virtual void after_step(std::function<void(const simulate::Simulator&, const ros::Time&)> publish) = 0;
};

}  // namespace extperfc::ros_simulate
