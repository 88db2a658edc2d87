#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>

#include "translate/bridge/context.hpp"

namespace extperfc::translate {

/// Parameters below one prefix, in one direction. Masters up to Indigo also notify the node that made a
/// change, so a value that equals the last one written is an echo.
class ParamRoute {
 public:
  /// What was written last on each side; shared by the routes, so that both directions know each other's
  /// writes.
  using Written = std::array<std::map<std::string, XmlValue>, 2>;

  ParamRoute(BridgeContext& context, Written& written, std::string prefix, Side from);

  /// The other side's master has lost its parameters: writes all of them again.
  void write_again();

  [[nodiscard]] std::size_t count() const { return names_.size(); }

 private:
  void on_change(const std::string& name, const XmlValue& value);

  BridgeContext& context_;
  Written& written_;
  std::string prefix_;
  Side from_;
  std::set<std::string> names_;
  std::shared_ptr<bool> alive_{std::make_shared<bool>(true)};
};

}  // namespace extperfc::translate
