#include "simulate/control/fault_book.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <numeric>
#include <sstream>
#include <utility>

namespace extperfc::simulate {
namespace {

constexpr std::array<std::pair<FaultKind, const char*>, 10> kNames{
    {{FaultKind::kNone, "none"},
     {FaultKind::kCameraFreeze, "camera_freeze"},
     {FaultKind::kCameraDrop, "camera_drop"},
     {FaultKind::kCameraNan, "camera_nan"},
     {FaultKind::kLidarRings, "lidar_rings"},
     {FaultKind::kLidarDrop, "lidar_drop"},
     {FaultKind::kJointStuck, "joint_stuck"},
     {FaultKind::kWheelSlip, "wheel_slip"},
     {FaultKind::kClockJump, "clock_jump"},
     {FaultKind::kDie, "die"}}};
constexpr std::array<const char*, 4> kWheels{"fl", "fr", "rl", "rr"};

bool is_fraction(FaultKind kind) {
  return kind == FaultKind::kCameraDrop || kind == FaultKind::kCameraNan || kind == FaultKind::kLidarDrop ||
         kind == FaultKind::kWheelSlip;
}

bool is_all(const std::string& target) {
  return target.empty() || target == "all";
}

}  // namespace

const char* to_string(FaultKind kind) {
  for (const auto& [known, name] : kNames)
    if (known == kind) return name;
  return "unknown";
}

std::optional<FaultKind> fault_kind(const std::string& name) {
  for (const auto& [kind, known] : kNames)
    if (name == known) return kind;
  return std::nullopt;
}

Result<std::vector<int>> ring_numbers(const std::string& target) {
  std::vector<int> rings;
  if (is_all(target)) {
    rings.resize(16);
    std::iota(rings.begin(), rings.end(), 0);
    return rings;
  }
  std::istringstream parts(target);
  for (std::string part; std::getline(parts, part, ',');) {
    part.erase(std::remove(part.begin(), part.end(), ' '), part.end());
    int ring = -1;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), ring);
    if (error != std::errc() || end != part.data() + part.size() || ring < 0 || ring > 15)
      return fail(ErrorCode::kInvalidArgument,
                  "lidar_rings: '" + part + "' is no ring: write numbers from 0 to 15 with commas, e.g. 3,7");
    rings.push_back(ring);
  }
  return rings;
}

Result<void> FaultBook::check_target(const Fault& fault) const {
  if (fault.kind == FaultKind::kJointStuck) {
    const auto joint = robot_->joint(fault.target);
    if (!joint || robot_->joints()[*joint].type == JointType::kFixed)
      return fail(ErrorCode::kNotFound, "joint_stuck: the robot has no joint '" + fault.target +
                                            "' that moves: name one of joint_states");
  }
  if (fault.kind == FaultKind::kWheelSlip && !is_all(fault.target) &&
      std::find(kWheels.begin(), kWheels.end(), fault.target) == kWheels.end())
    return fail(ErrorCode::kNotFound,
                "wheel_slip: there is no wheel '" + fault.target + "': use fl, fr, rl, rr or all");
  if (fault.kind == FaultKind::kLidarRings)
    if (auto rings = ring_numbers(fault.target); !rings) return tl::unexpected(rings.error());
  return {};
}

Result<void> FaultBook::check(const Fault& fault) const {
  const std::string name = to_string(fault.kind);
  if (!(fault.duration_s <= 1e9))
    return fail(ErrorCode::kInvalidArgument, name + ": duration_s must be a number of seconds, 0 for ever");
  if (is_fraction(fault.kind) && !(fault.value >= 0 && fault.value <= 1))
    return fail(ErrorCode::kInvalidArgument, name + ": value is a fraction: use 0 to 1");
  if (fault.kind == FaultKind::kClockJump && !(std::abs(fault.value) <= 1e6))
    return fail(ErrorCode::kInvalidArgument, name + ": value is in seconds: use -1e6 to 1e6");
  if (fault.kind == FaultKind::kDie && !(fault.value >= 0 && fault.value <= 1e6))
    return fail(ErrorCode::kInvalidArgument, name + ": value is in seconds from now: use 0 to 1e6");
  return check_target(fault);
}

void FaultBook::erase(FaultKind kind, const std::string* target) {
  for (std::size_t i = active_.size(); i-- > 0;) {
    if (active_[i].kind != kind || (target != nullptr && active_[i].target != *target)) continue;
    active_.erase(active_.begin() + static_cast<std::ptrdiff_t>(i));
    until_s_.erase(until_s_.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

Result<void> FaultBook::set(const Fault& fault, double now_s) {
  if (fault.kind == FaultKind::kNone) {
    active_.clear();
    until_s_.clear();
    return {};
  }
  if (fault.duration_s < 0) {
    erase(fault.kind, is_all(fault.target) ? nullptr : &fault.target);
    return {};
  }
  if (auto checked = check(fault); !checked) return checked;
  erase(fault.kind, &fault.target);
  active_.push_back(fault);
  until_s_.push_back(fault.duration_s > 0 ? now_s + fault.duration_s
                                          : std::numeric_limits<double>::infinity());
  return {};
}

void FaultBook::expire(double now_s) {
  for (std::size_t i = active_.size(); i-- > 0;) {
    if (until_s_[i] > now_s) continue;
    active_.erase(active_.begin() + static_cast<std::ptrdiff_t>(i));
    until_s_.erase(until_s_.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

bool FaultBook::joint_is_stuck(const std::string& joint) const {
  return std::any_of(active_.begin(), active_.end(), [&](const Fault& fault) {
    return fault.kind == FaultKind::kJointStuck && fault.target == joint;
  });
}

double FaultBook::wheel_slip(int wheel) const {
  double slip = 0;
  for (const auto& fault : active_)
    if (fault.kind == FaultKind::kWheelSlip && (is_all(fault.target) || fault.target == kWheels[wheel]))
      slip = std::max(slip, fault.value);
  return slip;
}

}  // namespace extperfc::simulate
