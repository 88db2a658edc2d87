#include "simulate/control/params_check.hpp"

#include <sstream>

namespace extperfc::simulate {
namespace {

/// Collects what is wrong.
class Checker {
 public:
  /// `value` in (low, high].
  void above(const char* name, double value, double low, double high) {
    if (!(value > low && value <= high)) complain(name, value, "(", low, high);
  }
  /// `value` in [low, high].
  void within(const char* name, double value, double low, double high) {
    if (!(value >= low && value <= high)) complain(name, value, "[", low, high);
  }
  [[nodiscard]] Result<void> finish() const {
    if (errors_.str().empty()) return {};
    return fail(ErrorCode::kInvalidArgument, errors_.str());
  }

 private:
  void complain(const char* name, double value, const char* open, double low, double high) {
    if (!errors_.str().empty()) errors_ << "\n";
    errors_ << name << " = " << value << " is out of its range " << open << low << ", " << high << "]";
  }

  std::ostringstream errors_;
};

}  // namespace

Result<void> check(const SimulatorParams& params) {
  Checker checker;
  const BaseParams& base = params.base;
  checker.above("base: max_speed_m_s", base.max_speed_m_s, 0, 1.84);
  checker.above("base: max_yaw_rate_rad_s", base.max_yaw_rate_rad_s, 0, 3.1);
  checker.above("base: max_accel_m_s2", base.max_accel_m_s2, 0, 4);
  checker.above("base: max_yaw_accel_rad_s2", base.max_yaw_accel_rad_s2, 0, 9.5);
  checker.above("base: command_timeout_s", base.command_timeout_s, 0, 5);
  checker.within("base: wheel_noise", base.wheel_noise, 0, 0.5);
  checker.within("base: wheel_slip", base.wheel_slip, 0, 0.5);
  checker.within("base: lateral_slip", base.lateral_slip, 0, 0.5);
  checker.within("base: gyro_noise_rad_s", base.gyro_noise_rad_s, 0, 1);
  checker.within("base: gyro_bias_rad_s", base.gyro_bias_rad_s, 0, 1);
  checker.within("base: accel_noise_m_s2", base.accel_noise_m_s2, 0, 10);
  checker.above("arms: max_accel_rad_s2", params.arms.max_accel_rad_s2, 0, 50);
  checker.above("arms: command_timeout_s", params.arms.command_timeout_s, 0, 1);
  return checker.finish();
}

}  // namespace extperfc::simulate
