#pragma once

#include <algorithm>
#include <cstdint>
#include <map>

#include "translate/peer/master_calls.hpp"
#include "translate/peer/master_link.hpp"

namespace extperfc::translate {

/// Something of ours that a master shall know, and how far that is.
struct Registration {
  Registered what;
  MasterLink::Done done;
  std::uint64_t epoch{0};          ///< of the master's life in which it was made; 0 is never
  std::int32_t registered_pid{0};  ///< pid of the master that it is registered at; 0: not registered
  bool busy{false};                ///< a call is under way
  bool queued{false};
  bool dropped{false};
  bool again{false};        ///< unregister before the next registration
  bool renew{false};        ///< register once more, as it stands
  SteadyTime not_before{};  ///< after a failure
};

/// What a link keeps. Questions cost O(n).
struct Registrations {
  using Id = MasterLink::RegistrationId;

  std::map<Id, Registration> entries;

  template <typename Condition>
  [[nodiscard]] bool any(const Condition& condition) const {
    return std::any_of(entries.begin(), entries.end(),
                       [&](const auto& entry) { return condition(entry.first, entry.second); });
  }
  /// The master said that it knows one of them.
  [[nodiscard]] bool any_stands(std::uint64_t epoch) const {
    return any(
        [epoch](Id, const Registration& one) { return one.epoch == epoch && !one.busy && !one.dropped; });
  }
  /// Another entry than `id` has the same registration: undoing `id` would undo that one.
  [[nodiscard]] bool keeps_too(Id id, const Registered& what) const {
    return any([&](Id other, const Registration& one) {
      return other != id && !one.dropped && one.what.same_place(what);
    });
  }
  /// A call about it is under way. Calls about one registration go one after another: none overtakes a newer
  /// one.
  [[nodiscard]] bool is_busy(const Registered& what) const {
    return any([&](Id, const Registration& one) { return one.busy && one.what.same_place(what); });
  }
};

}  // namespace extperfc::translate
