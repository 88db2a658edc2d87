#include <algorithm>
#include <iostream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/base/arguments.hpp"
#include "extperfc/base/text.hpp"
#include "extperfc/translate/plan.hpp"
#include "extperfc/translate/rules.hpp"

#include "translate/tool/command.hpp"
#include "translate/tool/report.hpp"
#include "translate/tool/sources.hpp"
#include "translate/tool/type_definitions.hpp"

namespace extperfc::translate {
namespace {

constexpr const char* kShowHelp = R"(Shows how a message, service or action is converted.

  extperfc-translate show TYPE --from SET|MD5 --to SET|MD5

Prints both definitions side by side, the conversion of each field, and the steps of the plan. For a service the client is on
the --from side and the server on the --to side: requests go there, responses come back; so do goals, and results and
feedback, of an action. MD5s may be cut to six digits.

Options:
  --kind msg|srv|action   if the name stands for several kinds
  --to-type TYPE          if the type has another name on that side
  --rules FILE            these rules instead of those in the configuration; may be given several times
  --config DIR            the folder with definitions/ and the rules *.yaml

Exit status: 0 there is a plan, 1 a rule is needed, 2 an error occurred.
)";

constexpr std::size_t kHalf = 47;

std::vector<std::string> lines_of(const MessageSchema& schema) {
  std::vector<std::string> lines;
  for (const auto& constant : schema.constants())
    lines.push_back(constant.written_type + " " + constant.name + "=" + constant.value);
  for (const auto& field : schema.fields()) lines.push_back(to_string(field));
  return lines;
}

/// Differences of an embedded type are shown after its name.
std::string with_md5(const MessageSchema& schema, const MessageSchema& other, const std::string& line) {
  for (const auto& field : schema.fields()) {
    if (!field.message || to_string(field) != line) continue;
    const auto* twin = other.find(field.name);
    if (twin != nullptr && twin->message && twin->message->md5() != field.message->md5())
      return line + " (" + field.message->md5().substr(0, 8) + ")";
  }
  return line;
}

std::string cut(const std::string& text, std::size_t width) {
  return text.size() <= width ? text + std::string(width - text.size(), ' ')
                              : text.substr(0, width - 3) + "...";
}

enum class Mark : char { kSame = ' ', kLeft = '-', kRight = '+' };

/// Which lines only one side has, by the longest common subsequence.
std::vector<Mark> compare_lines(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  std::vector<std::vector<std::size_t>> common(a.size() + 1, std::vector<std::size_t>(b.size() + 1, 0));
  for (std::size_t i = a.size(); i-- > 0;)
    for (std::size_t j = b.size(); j-- > 0;)
      common[i][j] = a[i] == b[j] ? common[i + 1][j + 1] + 1 : std::max(common[i + 1][j], common[i][j + 1]);
  std::vector<Mark> marks;
  for (std::size_t i = 0, j = 0; i < a.size() || j < b.size();) {
    const bool same = i < a.size() && j < b.size() && a[i] == b[j];
    const bool left = !same && i < a.size() && (j == b.size() || common[i + 1][j] >= common[i][j + 1]);
    marks.push_back(same ? Mark::kSame : left ? Mark::kLeft : Mark::kRight);
    if (same || left) ++i;
    if (same || !left) ++j;
  }
  return marks;
}

void print_line(Mark mark, const std::string& left, const std::string& right) {
  const auto line =
      std::string("  ") + static_cast<char>(mark) + " " + cut(left, kHalf) + " " + cut(right, kHalf);
  std::cout << line.substr(0, line.find_last_not_of(' ') + 1) << "\n";
}

/// Two columns; `-` marks lines that only the left has, `+` those of the right. Of more than three equal
/// lines in a row the first and the last are shown.
void print_side_by_side(const MessageSchema& left, const MessageSchema& right) {
  const auto a = lines_of(left);
  const auto b = lines_of(right);
  const auto marks = compare_lines(a, b);
  for (std::size_t at = 0, i = 0, j = 0; at < marks.size(); ++at) {
    std::size_t run = 0;
    while (at + run < marks.size() && marks[at + run] == Mark::kSame && a[i + run] == b[j + run]) ++run;
    const bool first_of_run = run > 3 && (at == 0 || marks[at - 1] != Mark::kSame);
    print_line(marks[at], marks[at] == Mark::kRight ? "" : with_md5(left, right, a[i]),
               marks[at] == Mark::kLeft ? "" : with_md5(right, left, b[j]));
    if (first_of_run) {
      std::cout << "      (" << run - 2 << " lines that are the same)\n";
      at += run - 2;
      i += run - 2;
      j += run - 2;
    }
    if (marks[at] != Mark::kRight) ++i;
    if (marks[at] != Mark::kLeft) ++j;
  }
}

const char* to_text(Plan::Note::Kind kind) {
  switch (kind) {
    case Plan::Note::Kind::kKept:
      return "kept";
    case Plan::Note::Kind::kMoved:
      return "moved";
    case Plan::Note::Kind::kConverted:
      return "converted";
    case Plan::Note::Kind::kDefaulted:
      return "default";
    case Plan::Note::Kind::kDropped:
      return "left out";
    case Plan::Note::Kind::kRule:
      return "rule";
  }
  return "?";
}

/// One message one way: false when there is no plan.
bool print_plan(const std::string& title, const SchemaPtr& from, const SchemaPtr& to, const RuleSet& rules) {
  std::cout << title << ": " << from->type() << " " << from->md5().substr(0, 8) << " -> " << to->type() << " "
            << to->md5().substr(0, 8) << "\n";
  print_side_by_side(*from, *to);
  const auto plan = Plan::compile(from, to, rules);
  if (!plan) {
    std::cout << "\n" << wrapped("needs a rule: " + plan.error().message, "  ") << "\n";
    return false;
  }
  std::cout << "\n  plan: " << to_string((*plan)->kind()) << "\n";
  std::size_t kept = 0;
  for (const auto& note : (*plan)->notes()) {
    if (note.kind == Plan::Note::Kind::kKept) {
      ++kept;
      continue;
    }
    std::cout << wrapped(
        std::string(to_text(note.kind)) + " " + note.path + (note.text.empty() ? "" : ": ") + note.text,
        "    ");
  }
  if (kept != 0) std::cout << "    kept: " << kept << (kept == 1 ? " field\n" : " fields\n");
  std::cout << "  steps:\n";
  for (const auto& line : (*plan)->describe()) std::cout << "    " << line << "\n";
  std::cout << "\n";
  return true;
}

bool print_definition(const std::string& kind, const TypeDefinition& from, const TypeDefinition& to,
                      const RuleSet& rules) {
  if (kind == "msg") return print_plan("message", from.message, to.message, rules);
  if (kind == "srv") {
    const bool there = print_plan("request", from.service->request, to.service->request, rules);
    return print_plan("response, back", to.service->response, from.service->response, rules) && there;
  }
  const bool there = print_plan("goal", from.action->goal, to.action->goal, rules);
  const bool result = print_plan("result, back", to.action->result, from.action->result, rules);
  return print_plan("feedback, back", to.action->feedback, from.action->feedback, rules) && there && result;
}

Result<int> show(const DefinitionStore& store, const RuleSet& rules, const Arguments& arguments) {
  const auto& type = arguments.operands()[0];
  const auto from = find_definitions(store, type, *arguments.last("--from"));
  if (!from) return tl::unexpected(from.error());
  const auto to_type = arguments.last("--to-type").value_or(type);
  const auto to = find_definitions(store, to_type, *arguments.last("--to"));
  if (!to) return tl::unexpected(to.error());
  const auto wanted = arguments.last("--kind");
  std::size_t shown = 0;
  bool fine = true;
  for (const auto& [kind, definition] : *from) {
    const auto other = to->find(kind);
    if (other == to->end() || (wanted && *wanted != kind)) continue;
    std::cout << type << " (" << kind << ")\n  from " << definition.md5 << "  "
              << joined(store.sets_with(type, definition.md5)) << "\n  to   " << other->second.md5 << "  "
              << joined(store.sets_with(to_type, other->second.md5)) << "\n\n";
    fine = print_definition(kind, definition, other->second, rules) && fine;
    ++shown;
  }
  if (shown == 0) return fail(ErrorCode::kNotFound, type + " is not of the same kind on both sides");
  return fine ? kFine : kDiffers;
}

}  // namespace

Result<int> run_show(const Tokens& tokens) {
  const auto arguments = Arguments::read(
      tokens, {0, 1, {"--from", "--to", "--to-type", "--kind", "--rules", "--config"}, {"--help"}});
  if (!arguments) return tl::unexpected(arguments.error());
  if (arguments->has("--help")) {
    std::cout << kShowHelp;
    return kFine;
  }
  if (arguments->operands().empty() || !arguments->has("--from") || !arguments->has("--to"))
    return fail(ErrorCode::kInvalidArgument,
                "give a type and both sides: show TYPE --from SET|MD5 --to SET|MD5");
  const auto store = open_store(*arguments);
  if (!store) return tl::unexpected(store.error());
  const auto files = rule_files(*arguments);
  if (!files) return tl::unexpected(files.error());
  const auto rules = load_rules(*files, *store);
  if (!rules) return tl::unexpected(rules.error());
  return show(*store, *rules, *arguments);
}

}  // namespace extperfc::translate
