#include "translate/tool/comparison.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

namespace extperfc::translate {
namespace {

void add_once(std::vector<std::string>& lines, const std::string& line) {
  if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
}

/// Compiles both ways and writes the findings into a row.
class PairJudge {
 public:
  PairJudge(const RuleSet& rules, Row& row) : rules_(rules), row_(row) {}

  void both_directions(const SchemaPtr& robot_schema, const SchemaPtr& workstation_schema,
                       const std::string& part) {
    one_direction(robot_schema, workstation_schema, part + "robot to workstation", true);
    one_direction(workstation_schema, robot_schema, part + "workstation to robot", false);
  }

  [[nodiscard]] Verdict verdict() const {
    if (!row_.reasons.empty()) return Verdict::kNeedsRule;
    return converts_ ? Verdict::kConvert : Verdict::kPass;
  }

 private:
  void one_direction(const SchemaPtr& from, const SchemaPtr& to, const std::string& direction, bool forward) {
    const auto plan = Plan::compile(from, to, rules_);
    if (!plan) {
      add_once(row_.reasons, direction + ": " + plan.error().message);
      return;
    }
    converts_ = converts_ || (*plan)->kind() == Plan::Kind::kConvert;
    for (const auto& note : (*plan)->notes()) {
      if (note.kind == Plan::Note::Kind::kRule) row_.by_rule = true;
      if (note.kind == Plan::Note::Kind::kRule && forward) add_once(row_.ruled, note.path);
      if (note.kind == Plan::Note::Kind::kDefaulted && forward) add_once(row_.added, note.path);
      if (note.kind == Plan::Note::Kind::kDropped && forward) add_once(row_.dropped, note.path);
    }
  }

  const RuleSet& rules_;
  Row& row_;
  bool converts_{false};
};

Row judge(const TypeId& robot_id, const TypeId& workstation_id, const TypeDefinition& robot_definition,
          const TypeDefinition& workstation_definition, const RuleSet& rules) {
  Row row{robot_id.first,
          workstation_id.first,
          robot_id.second,
          robot_definition.md5,
          workstation_definition.md5,
          {},
          false,
          {},
          {},
          {},
          {},
          robot_definition.where,
          workstation_definition.where};
  // Equal MD5s of unknown definitions are the best that can be said: nothing else is on the wire.
  const bool same_md5 = !robot_definition.md5.empty() && robot_definition.md5 == workstation_definition.md5;
  if (!robot_definition.known() || !workstation_definition.known()) {
    row.verdict = same_md5 ? Verdict::kSame : Verdict::kUnknown;
    if (same_md5) return row;
    for (const auto& [side, definition] :
         {std::pair("robot", robot_definition), std::pair("workstation", workstation_definition)})
      if (!definition.known())
        row.reasons.push_back(std::string(side) + ": " +
                              (definition.md5.empty()
                                   ? "there is no publisher, so its MD5 is not known; give a set for "
                                     "that side (--from-set, --to-set)"
                                   : "no definition of " + definition.md5 + " is known"));
    return row;
  }
  PairJudge judge(rules, row);
  if (robot_definition.message) {
    judge.both_directions(robot_definition.message, workstation_definition.message, "");
  } else if (robot_definition.service) {
    judge.both_directions(robot_definition.service->request, workstation_definition.service->request,
                          "request, ");
    judge.both_directions(robot_definition.service->response, workstation_definition.service->response,
                          "response, ");
  } else {
    judge.both_directions(robot_definition.action->goal, workstation_definition.action->goal, "goal, ");
    judge.both_directions(robot_definition.action->result, workstation_definition.action->result, "result, ");
    judge.both_directions(robot_definition.action->feedback, workstation_definition.action->feedback,
                          "feedback, ");
  }
  row.verdict = judge.verdict();
  if (row.verdict == Verdict::kPass && same_md5) row.verdict = Verdict::kSame;
  return row;
}

void compare_definitions(const TypeId& robot_id, const TypeId& workstation_id,
                         const std::vector<TypeDefinition>& robot_definitions,
                         const std::vector<TypeDefinition>& workstation_definitions, const RuleSet& rules,
                         std::vector<Row>& rows) {
  for (const auto& robot_definition : robot_definitions)
    for (const auto& workstation_definition : workstation_definitions)
      rows.push_back(judge(robot_id, workstation_id, robot_definition, workstation_definition, rules));
}

}  // namespace

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kSame:
      return "same";
    case Verdict::kPass:
      return "pass";
    case Verdict::kConvert:
      return "convert";
    case Verdict::kNeedsRule:
      return "needs a rule";
    case Verdict::kUnknown:
      return "unknown";
  }
  return "?";
}

Comparison compare(const TypeSet& robot, const TypeSet& workstation, const RuleSet& rules) {
  Comparison comparison;
  std::set<TypeId> renamed;  // of the workstation side
  for (const auto& [id, definitions] : robot) {
    if (const auto found = workstation.find(id); found != workstation.end()) {
      compare_definitions(id, id, definitions, found->second, rules, comparison.rows);
      continue;
    }
    bool has_other_name = false;
    for (const auto& name : rules.other_names(id.first)) {
      const TypeId other{name, id.second};
      const auto found = workstation.find(other);
      if (found == workstation.end() || robot.count(other) != 0) continue;
      compare_definitions(id, other, definitions, found->second, rules, comparison.renamed);
      renamed.insert(other);
      has_other_name = true;
    }
    if (!has_other_name) ++comparison.only_robot;
  }
  for (const auto& [id, definitions] : workstation)
    if (robot.count(id) == 0 && renamed.count(id) == 0) ++comparison.only_workstation;
  return comparison;
}

}  // namespace extperfc::translate
