#pragma once

#include <map>
#include <string>
#include <tuple>

#include "extperfc/translate/definition_store.hpp"
#include "extperfc/translate/plan.hpp"

namespace extperfc::translate {

/// A definition as a connection header names it. The schema is null while it is unknown.
struct MessageDefinition {
  std::string type, md5;
  SchemaPtr schema;
};

/// How messages of one definition are converted to another.
struct Conversion {
  bool possible{false};
  PlanPtr plan;         ///< null: the bytes are forwarded unchanged
  std::string problem;  ///< when it is not possible

  [[nodiscard]] bool raw() const { return !plan || plan->kind() == Plan::Kind::kPass; }
  [[nodiscard]] std::string describe() const;  ///< "pass", "convert", or the problem
};

/// Caches plans, each compiled once, and refusals.
class PlanCache {
 public:
  PlanCache(DefinitionStore& definitions, RuleSet rules)
      : definitions_(definitions), rules_(std::move(rules)) {}

  /// Definitions with equal MD5s and no schema pass unchanged: there is no further information.
  [[nodiscard]] Conversion conversion(const MessageDefinition& from, const MessageDefinition& to,
                                      const PlanOptions& options);
  /// Both halves; a service's versions differ in their own MD5s.
  struct ServiceConversion {
    Conversion request, response;  ///< client to server, server to client
    [[nodiscard]] bool possible() const { return request.possible && response.possible; }
    [[nodiscard]] std::string describe() const;
  };
  [[nodiscard]] ServiceConversion conversion(const ServiceSchema& client, const ServiceSchema& server,
                                             const PlanOptions& options);

  /// The definition of a version: from its own text when the header had one, else from the store, under each
  /// name that the type has had.
  [[nodiscard]] MessageDefinition definition(const std::string& type, const std::string& md5,
                                             const std::string& text);
  [[nodiscard]] ServicePtr service(const std::string& type, const std::string& md5) const;

  [[nodiscard]] const RuleSet& rules() const { return rules_; }
  [[nodiscard]] DefinitionStore& definitions() { return definitions_; }
  void replace_rules(RuleSet rules);

 private:
  using Key = std::tuple<SchemaPtr, SchemaPtr, bool, PlanOptions::Slash>;
  static constexpr std::size_t kMaxPlans = 4096;  // definitions come from strangers

  DefinitionStore& definitions_;
  RuleSet rules_;
  std::map<Key, Conversion> known_;
};

}  // namespace extperfc::translate
