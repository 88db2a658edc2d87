#pragma once

#include <string>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/peer.hpp"
#include "extperfc/translate/rpc.hpp"

namespace extperfc::translate {

/// The value of a master's answer [code, status, value]: code 1 only. Code -1 (the caller's fault: not set,
/// unknown) is kNotFound, 0 (the master's) is kFailed, both with the status text.
[[nodiscard]] Result<XmlValue> unpack_reply(const std::string& method, XmlValue reply);

/// Both are values of successful answers; kCorrupt when they do not look like those.
[[nodiscard]] Result<GraphState> read_graph(const XmlValue& system_state, const XmlValue& topic_types);

/// What a node can have at a master, and the calls that make and undo it.
struct Registered {
  enum class Kind { kPublisher, kSubscriber, kService, kParam };
  Kind kind{Kind::kPublisher};
  std::string name;    ///< topic, service or parameter
  std::string detail;  ///< a topic's type, a service's URI

  [[nodiscard]] bool same_place(const Registered& other) const {
    return kind == other.kind && name == other.name;
  }
  [[nodiscard]] const char* method() const;
  [[nodiscard]] const char* undo_method() const;
  /// After the caller id.
  [[nodiscard]] XmlArray arguments(const std::string& caller_api) const;
  [[nodiscard]] XmlArray undo_arguments(const std::string& caller_api) const;
};

}  // namespace extperfc::translate
