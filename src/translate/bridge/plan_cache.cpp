#include "translate/bridge/plan_cache.hpp"

#include <utility>

namespace extperfc::translate {

namespace {

std::string brief(const MessageDefinition& definition) {
  return definition.type + " (MD5 " + definition.md5 + ")";
}

std::string missing(const MessageDefinition& definition) {
  return "there is no definition of " + brief(definition) +
         ": add its package to the translator's definitions";
}

}  // namespace

std::string Conversion::describe() const {
  if (!possible) return problem;
  return raw() ? "pass" : "convert";
}

std::string PlanCache::ServiceConversion::describe() const {
  if (!request.possible) return "request: " + request.problem;
  if (!response.possible) return "response: " + response.problem;
  return request.raw() && response.raw() ? "pass" : "convert";
}

Conversion PlanCache::conversion(const MessageDefinition& from, const MessageDefinition& to,
                                 const PlanOptions& options) {
  if (!from.schema || !to.schema) {
    if (from.md5 == to.md5) return {true, nullptr, {}};
    return {false, nullptr, missing(from.schema ? to : from)};
  }
  const Key key{from.schema, to.schema, options.shift_times, options.frame_slash};
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  if (known_.size() >= kMaxPlans) known_.clear();
  auto plan = Plan::compile(from.schema, to.schema, rules_, options);
  Conversion conversion;
  conversion.possible = plan.has_value();
  if (plan)
    conversion.plan = std::move(*plan);
  else
    conversion.problem = plan.error().message;
  return known_[key] = conversion;
}

PlanCache::ServiceConversion PlanCache::conversion(const ServiceSchema& client, const ServiceSchema& server,
                                                   const PlanOptions& options) {
  const auto half = [](const SchemaPtr& schema) {
    return MessageDefinition{schema->type(), schema->md5(), schema};
  };
  return {conversion(half(client.request), half(server.request), options),
          conversion(half(server.response), half(client.response), options)};
}

MessageDefinition PlanCache::definition(const std::string& type, const std::string& md5,
                                        const std::string& text) {
  MessageDefinition definition{type, md5, definitions_.find_message(type, md5)};
  for (const auto& name : rules_.other_names(type))
    if (!definition.schema) definition.schema = definitions_.find_message(name, md5);
  if (text.empty() || type == "*") return definition;
  // The text counts: `Point p` and `Point[] p` share an MD5.
  const auto parsed = parse_full_text(type, text);
  if (!parsed || (*parsed)->md5() != md5) return definition;
  if (!definition.schema) {
    if (auto learned = definitions_.learn(type, md5, text)) definition.schema = *learned;
  } else if (!same_layout(*definition.schema, **parsed)) {
    definition.schema = *parsed;
  }
  return definition;
}

ServicePtr PlanCache::service(const std::string& type, const std::string& md5) const {
  auto found = definitions_.find_service(type, md5);
  for (const auto& name : rules_.other_names(type))
    if (!found) found = definitions_.find_service(name, md5);
  return found;
}

void PlanCache::replace_rules(RuleSet rules) {
  rules_ = std::move(rules);
  known_.clear();
}

}  // namespace extperfc::translate
