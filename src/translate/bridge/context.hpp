#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "extperfc/translate/bridge.hpp"
#include "extperfc/translate/frame.hpp"

#include "translate/bridge/plan_cache.hpp"

namespace extperfc::translate {

/// What the parts of one bridge share. Outlives them.
struct BridgeContext {
  EventLoop& loop;
  FramePool& frames;
  const BridgeParams& params;
  PlanCache& plans;
  std::array<Peer*, 2> peers{};
  std::function<void(const std::string&)> log;
  std::function<void(const std::string&)> problem;
  /// What is added to stamps that leave this side [ns]; 0 while the offset is not known or shifting is off.
  std::function<std::int64_t(Side from)> shift_ns;

  [[nodiscard]] Peer& peer(Side side) const { return *peers[static_cast<std::size_t>(side)]; }
  [[nodiscard]] const SideParams& side_params(Side side) const {
    return params.sides[static_cast<std::size_t>(side)];
  }
  /// This side's own version of a type, by its sets; null when they have none.
  [[nodiscard]] SchemaPtr native(Side side, const std::string& type) const {
    for (const auto& set : side_params(side).definitions)
      if (auto schema = plans.definitions().message_of_set(set, type)) return schema;
    return nullptr;
  }
  [[nodiscard]] ServicePtr native_service(Side side, const std::string& type) const {
    for (const auto& set : side_params(side).definitions)
      if (auto service = plans.definitions().service_of_set(set, type)) return service;
    return nullptr;
  }
};

}  // namespace extperfc::translate
