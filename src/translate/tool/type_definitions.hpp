#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/definition_store.hpp"
#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {

/// One definition of a type: one of the three schemas, or none when only its MD5 is known.
struct TypeDefinition {
  std::string md5;  ///< empty when even that is not known
  SchemaPtr message;
  ServicePtr service;
  ActionPtr action;
  std::string where;  ///< e.g. the topics that carry it; why nothing is known

  [[nodiscard]] bool known() const { return message || service || action; }
};

using TypeId = std::pair<std::string, std::string>;  ///< type, "msg" | "srv" | "action"
/// What one side has, often one version of each type.
using TypeSet = std::map<TypeId, std::vector<TypeDefinition>>;

[[nodiscard]] TypeDefinition definition_of(SchemaPtr schema);
[[nodiscard]] TypeDefinition definition_of(ServicePtr schema);
[[nodiscard]] TypeDefinition definition_of(ActionPtr schema);

/// Everything in a set, with the messages of actions.
[[nodiscard]] TypeSet types_of_set(const DefinitionStore& store, const std::string& set);
/// The version of a set of each kind, or of all sets when `which` is an MD5 or its first digits (six or
/// more). Errors list the known definitions.
[[nodiscard]] Result<std::map<std::string, TypeDefinition>> find_definitions(const DefinitionStore& store,
                                                                             const std::string& type,
                                                                             const std::string& which);

}  // namespace extperfc::translate
