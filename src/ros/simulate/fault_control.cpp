#include "ros/simulate/fault_control.hpp"

#include <sstream>

#include <ros/console.h>
#include <unistd.h>

namespace extperfc::ros_simulate {

using simulate::FaultKind;

Result<void> FaultControl::set(simulate::Simulator& simulator, const simulate::Fault& fault) {
  if (auto done = simulator.set_fault(fault); !done) return done;
  const bool begins = fault.duration_s >= 0;
  if (fault.kind == FaultKind::kClockJump && begins) thread_.jump_clock(fault.value);
  if (fault.kind == FaultKind::kNone || (fault.kind == FaultKind::kDie && !begins)) dies_at_s_.reset();
  if (fault.kind == FaultKind::kDie && begins) dies_at_s_ = simulator.time_s() + fault.value;
  return {};
}

Result<void> FaultControl::begin(simulate::Simulator& simulator) {
  dies_at_s_.reset();
  std::string problems;
  for (const auto& fault : at_start_)
    if (auto done = set(simulator, fault); !done)
      problems += (problems.empty() ? "" : "\n  ") + done.error().message;
  if (problems.empty()) return {};
  return fail(ErrorCode::kInvalidArgument, problems);
}

void FaultControl::die_when_due(const simulate::Simulator& simulator) const {
  if (!dies_at_s_ || simulator.time_s() < *dies_at_s_) return;
  ROS_FATAL("the fault 'die' ends this process now");
  _exit(1);  // at once, as a crash would: no destructor, no unregistering
}

std::string describe(const simulate::Fault& fault) {
  std::ostringstream text;
  text << simulate::to_string(fault.kind);
  if (!fault.target.empty()) text << ' ' << fault.target;
  if (fault.kind != FaultKind::kJointStuck && fault.kind != FaultKind::kLidarRings &&
      fault.kind != FaultKind::kCameraFreeze)
    text << ' ' << fault.value;
  if (fault.duration_s > 0) text << " for " << fault.duration_s << " s";
  return text.str();
}

}  // namespace extperfc::ros_simulate
