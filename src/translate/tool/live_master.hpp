#pragma once

#include <chrono>
#include <string>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/definition_store.hpp"

#include "translate/tool/type_definitions.hpp"

namespace extperfc::translate {

/// What the nodes at a running master publish and serve: every publisher is subscribed to until it reports
/// its MD5 and definition, every service is probed. Definitions join `store`. Topics that are only subscribed
/// to, and services that do not answer, are without MD5, unless the set `hint` (may be empty) knows their
/// type. Ends after `patience` at the latest, with what is known then.
[[nodiscard]] Result<TypeSet> read_master(DefinitionStore& store, const std::string& uri,
                                          const std::string& hint, std::chrono::milliseconds patience);

}  // namespace extperfc::translate
