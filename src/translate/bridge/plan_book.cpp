#include "plan_book.hpp"

#include <utility>

namespace extperfc::translate {

namespace {

std::string brief(const Version& version) {
  return version.type + " (MD5 " + version.md5 + ")";
}

std::string missing(const Version& version) {
  return "there is no definition of " + brief(version) + ": add its package to the translator's definitions";
}

}  // namespace

std::string Carriage::describe() const {
  if (!possible) return problem;
  return raw() ? "pass" : "convert";
}

std::string PlanBook::ServiceCarriage::describe() const {
  if (!request.possible) return "request: " + request.problem;
  if (!response.possible) return "response: " + response.problem;
  return request.raw() && response.raw() ? "pass" : "convert";
}

Carriage PlanBook::carriage(const Version& from, const Version& to, const PlanOptions& options) {
  if (!from.schema || !to.schema) {
    if (from.md5 == to.md5) return {true, nullptr, {}};
    return {false, nullptr, missing(from.schema ? to : from)};
  }
  const Key key{from.schema, to.schema, options.shift_times, options.frame_slash};
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  if (known_.size() >= kMostPlans) known_.clear();
  auto plan = Plan::compile(from.schema, to.schema, rules_, options);
  Carriage carriage;
  carriage.possible = plan.has_value();
  if (plan)
    carriage.plan = std::move(*plan);
  else
    carriage.problem = plan.error().message;
  return known_[key] = carriage;
}

PlanBook::ServiceCarriage PlanBook::carriage(const ServiceSchema& client, const ServiceSchema& server,
                                             const PlanOptions& options) {
  const auto half = [](const SchemaPtr& schema) { return Version{schema->type(), schema->md5(), schema}; };
  return {carriage(half(client.request), half(server.request), options),
          carriage(half(server.response), half(client.response), options)};
}

Version PlanBook::version(const std::string& type, const std::string& md5, const std::string& definition) {
  Version version{type, md5, definitions_.find_message(type, md5)};
  for (const auto& name : rules_.other_names(type))
    if (!version.schema) version.schema = definitions_.find_message(name, md5);
  if (definition.empty() || type == "*") return version;
  // The text counts: `Point p` and `Point[] p` share an MD5.
  const auto told = parse_full_text(type, definition);
  if (!told || (*told)->md5() != md5) return version;
  if (!version.schema) {
    if (auto learned = definitions_.learn(type, md5, definition)) version.schema = *learned;
  } else if (!same_layout(*version.schema, **told)) {
    version.schema = *told;
  }
  return version;
}

ServicePtr PlanBook::service(const std::string& type, const std::string& md5) const {
  auto found = definitions_.find_service(type, md5);
  for (const auto& name : rules_.other_names(type))
    if (!found) found = definitions_.find_service(name, md5);
  return found;
}

void PlanBook::replace_rules(RuleSet rules) {
  rules_ = std::move(rules);
  known_.clear();
}

}  // namespace extperfc::translate
