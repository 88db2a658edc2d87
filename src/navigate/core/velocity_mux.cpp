#include "extperfc/navigate/velocity_mux.hpp"

#include <set>
#include <utility>

namespace extperfc::navigate {

namespace {

constexpr std::size_t kMaxSources = 100;
constexpr double kMaxTimeoutS = 60;

Result<void> validate(const std::vector<VelocitySource>& sources) {
  if (sources.empty() || sources.size() > kMaxSources)
    return fail(ErrorCode::kInvalidArgument, "there must be 1 to 100 sources of velocity commands");
  std::set<std::string> names;
  std::set<int> priorities;
  for (const auto& source : sources) {
    if (!names.insert(source.name).second)
      return fail(ErrorCode::kInvalidArgument, "two sources have the name '" + source.name + "'");
    if (!priorities.insert(source.priority).second)
      return fail(ErrorCode::kInvalidArgument, "source '" + source.name + "' has the priority " +
                                                   std::to_string(source.priority) +
                                                   " of another one; give each its own");
    if (!(source.timeout_s > 0 && source.timeout_s <= kMaxTimeoutS))
      return fail(ErrorCode::kInvalidArgument,
                  "source '" + source.name + "': timeout must be above 0 and at most 60 s");
  }
  return {};
}

}  // namespace

Result<VelocityMux> VelocityMux::make(std::vector<VelocitySource> sources, const VelocityLimits& limits) {
  if (auto valid = validate(sources); !valid) return tl::unexpected(valid.error());
  if (auto valid = navigate::validate(limits); !valid) return tl::unexpected(valid.error());
  return VelocityMux(std::move(sources), limits);
}

VelocityMux::VelocityMux(std::vector<VelocitySource> sources, const VelocityLimits& limits)
    : sources_(std::move(sources)), limits_(limits), commands_(sources_.size()) {}

bool VelocityMux::command(std::size_t source, const Twist2& velocity, double now_s) {
  if (!is_finite(velocity)) return false;
  commands_[source] = {limited(velocity, limits_), now_s};
  return true;
}

bool VelocityMux::speaks(std::size_t source, double now_s) const {
  const double age_s = now_s - commands_[source].stamp_s;
  return age_s >= 0 && age_s <= sources_[source].timeout_s;
}

std::optional<std::size_t> VelocityMux::active(double now_s) const {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    if (!speaks(i, now_s) || (lock_ && sources_[i].priority < *lock_)) continue;
    if (!best || sources_[i].priority > sources_[*best].priority) best = i;
  }
  return best;
}

std::optional<MuxedVelocity> VelocityMux::output(double now_s) {
  const auto source = stop_ ? std::nullopt : active(now_s);
  const bool was_sending = std::exchange(sending_, stop_ || source);
  if (stop_) return MuxedVelocity{};
  if (source) return MuxedVelocity{commands_[*source].velocity, source};
  if (was_sending) return MuxedVelocity{};
  return std::nullopt;
}

}  // namespace extperfc::navigate
