#include "extperfc/translate/bridge.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "translate/bridge/bridge_impl.hpp"

namespace extperfc::translate {

const char* to_string(Side side) {
  return side == Side::kRobot ? "robot" : "workstation";
}

namespace {

std::string unknown_set(Side side, const std::string& set, const std::string& known) {
  return std::string(to_string(side)) + " side: there is no set of definitions '" + set +
         "'; there are:" + known;
}

Result<void> check_sets(const BridgeParams& params, const DefinitionStore& definitions) {
  const auto known = definitions.sets();
  for (const auto side : {Side::kRobot, Side::kWorkstation})
    for (const auto& set : params.sides[static_cast<std::size_t>(side)].definitions)
      if (std::find(known.begin(), known.end(), set) == known.end()) {
        std::string names;
        for (const auto& name : known) names.append(" ").append(name);
        return fail(ErrorCode::kNotFound, unknown_set(side, set, names));
      }
  return {};
}

Result<void> check_numbers(const BridgeParams& params) {
  if (!(params.poll_period_s > 0.0))
    return fail(ErrorCode::kInvalidArgument, "poll_period_s must be above 0 s");
  if (!(params.service_timeout_s > 0.0))
    return fail(ErrorCode::kInvalidArgument, "service_timeout_s must be above 0 s");
  if (params.sides[0].peer.master_uri == params.sides[1].peer.master_uri)
    return fail(ErrorCode::kInvalidArgument, "both sides have the master " + params.sides[0].peer.master_uri +
                                                 ": name the robot's and the workstation's");
  return {};
}

}  // namespace

Result<std::unique_ptr<Bridge>> Bridge::make(EventLoop& loop, BridgeParams params,
                                             DefinitionStore definitions, RuleSet rules, Handlers handlers) {
  if (auto checked = check_numbers(params); !checked) return tl::unexpected(checked.error());
  if (auto checked = check_sets(params, definitions); !checked) return tl::unexpected(checked.error());
  auto selector = BridgeSelector::make(params);
  if (!selector) return tl::unexpected(selector.error());
  auto profiles = Profiles::make(params.profiles);
  if (!profiles) return tl::unexpected(profiles.error());
  auto bridge =
      std::make_unique<BridgeImpl>(loop, std::move(params), std::move(definitions), std::move(rules),
                                   std::move(handlers), std::move(*selector), std::move(*profiles));
  if (auto opened = bridge->open(); !opened) return tl::unexpected(opened.error());
  return bridge;
}

}  // namespace extperfc::translate
