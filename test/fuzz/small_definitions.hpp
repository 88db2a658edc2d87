#pragma once

#include "extperfc/translate/definition_store.hpp"

namespace extperfc::fuzz {

/// Two sets, "old" and "new", with a few versions of a few types: p/Head, p/Chain, p/Ask (a service).
[[nodiscard]] const translate::DefinitionStore& small_definitions();
/// The MD5 of a message or service of a set.
[[nodiscard]] std::string md5_of(const std::string& set, const std::string& type);

}  // namespace extperfc::fuzz
