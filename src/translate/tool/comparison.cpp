#include "comparison.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

namespace extperfc::translate::tool {
namespace {

void add_once(std::vector<std::string>& lines, const std::string& line) {
  if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
}

/// Compiles both ways and writes the findings into a row.
class PairJudge {
 public:
  PairJudge(const RuleSet& rules, Row& row) : rules_(rules), row_(row) {}

  void both_ways(const SchemaPtr& old_schema, const SchemaPtr& new_schema, const std::string& part) {
    one_way(old_schema, new_schema, part + "old to new", true);
    one_way(new_schema, old_schema, part + "new to old", false);
  }

  [[nodiscard]] Verdict verdict() const {
    if (!row_.reasons.empty()) return Verdict::kNeedsRule;
    return converts_ ? Verdict::kConvert : Verdict::kPass;
  }

 private:
  void one_way(const SchemaPtr& from, const SchemaPtr& to, const std::string& direction, bool forward) {
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

Row judge(const TypeId& old_id, const TypeId& new_id, const Version& old_version, const Version& new_version,
          const RuleSet& rules) {
  Row row{old_id.first, new_id.first, old_id.second,     old_version.md5,  new_version.md5, {}, false, {}, {},
          {},           {},           old_version.where, new_version.where};
  // Equal MD5s of unknown definitions are the best that can be said: nothing else is on the wire.
  const bool same_md5 = !old_version.md5.empty() && old_version.md5 == new_version.md5;
  if (!old_version.known() || !new_version.known()) {
    row.verdict = same_md5 ? Verdict::kSame : Verdict::kUnknown;
    if (same_md5) return row;
    for (const auto& [side, version] : {std::pair("old", old_version), std::pair("new", new_version)})
      if (!version.known())
        row.reasons.push_back(std::string(side) + ": " +
                              (version.md5.empty()
                                   ? "nobody publishes it there, so nobody tells its MD5; a set given for "
                                     "that side (--from-set, --to-set) stands in"
                                   : "no definition of " + version.md5 + " is known"));
    return row;
  }
  PairJudge judge(rules, row);
  if (old_version.message) {
    judge.both_ways(old_version.message, new_version.message, "");
  } else if (old_version.service) {
    judge.both_ways(old_version.service->request, new_version.service->request, "request, ");
    judge.both_ways(old_version.service->response, new_version.service->response, "response, ");
  } else {
    judge.both_ways(old_version.action->goal, new_version.action->goal, "goal, ");
    judge.both_ways(old_version.action->result, new_version.action->result, "result, ");
    judge.both_ways(old_version.action->feedback, new_version.action->feedback, "feedback, ");
  }
  row.verdict = judge.verdict();
  if (row.verdict == Verdict::kPass && same_md5) row.verdict = Verdict::kSame;
  return row;
}

void compare_versions(const TypeId& old_id, const TypeId& new_id, const std::vector<Version>& old_versions,
                      const std::vector<Version>& new_versions, const RuleSet& rules,
                      std::vector<Row>& rows) {
  for (const auto& old_version : old_versions)
    for (const auto& new_version : new_versions)
      rows.push_back(judge(old_id, new_id, old_version, new_version, rules));
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

Comparison compare(const Side& old_side, const Side& new_side, const RuleSet& rules) {
  Comparison comparison;
  std::set<TypeId> renamed;  // of the new side
  for (const auto& [id, versions] : old_side) {
    if (const auto found = new_side.find(id); found != new_side.end()) {
      compare_versions(id, id, versions, found->second, rules, comparison.rows);
      continue;
    }
    bool has_other_name = false;
    for (const auto& name : rules.other_names(id.first)) {
      const TypeId other{name, id.second};
      const auto found = new_side.find(other);
      if (found == new_side.end() || old_side.count(other) != 0) continue;
      compare_versions(id, other, versions, found->second, rules, comparison.renamed);
      renamed.insert(other);
      has_other_name = true;
    }
    if (!has_other_name) ++comparison.only_old;
  }
  for (const auto& [id, versions] : new_side)
    if (old_side.count(id) == 0 && renamed.count(id) == 0) ++comparison.only_new;
  return comparison;
}

}  // namespace extperfc::translate::tool
