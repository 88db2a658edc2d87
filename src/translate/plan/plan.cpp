#include "extperfc/translate/plan.hpp"

#include <algorithm>
#include <utility>

#include "translate/plan/compiler.hpp"
#include "translate/plan/describe.hpp"
#include "translate/plan/runner.hpp"

namespace extperfc::translate {

struct Plan::Program {
  SchemaPtr from, to;
  PlanOptions options;
  Stages stages;
  std::vector<Note> notes;
  Kind kind{Kind::kConvert};
};

namespace {

std::string name_of(const MessageSchema& schema) {
  return schema.type() + " (" + schema.md5() + ")";
}

bool is_pass(const Stages& stages) {
  const auto scans = [](const Op& op) { return only_scans(op.code); };
  const auto& code = stages.front();
  return stages.size() == 1 && !code.reinterprets && std::all_of(code.ops.begin(), code.ops.end(), scans);
}

/// Through one rule, no rule, or a chain of them.
Result<Chain> compile_stages(const SchemaPtr& from, const SchemaPtr& to, const RuleSet& rules,
                             const PlanOptions& options) {
  CompileBudget budget;
  const bool same = from->type() == to->type() && from->md5() == to->md5();
  const auto* rule = same ? nullptr : rules.find(*from, *to);
  if (!same && rule == nullptr) {
    const auto links = rules.chain(from, to);
    if (!links.empty()) return compile_chain(links, rules, options, budget);
  }
  Chain single;
  auto code = Compiler(rules, options, budget, single.notes).compile(*from, *to, rule);
  if (!code) return tl::unexpected(code.error());
  single.stages.push_back(std::move(*code));
  return single;
}

}  // namespace

Result<std::shared_ptr<const Plan>> Plan::compile(const SchemaPtr& from, const SchemaPtr& to,
                                                  const RuleSet& rules, const PlanOptions& options) {
  const auto refuse = [&](ErrorCode code, const std::string& reason) {
    return fail(code, name_of(*from) + " does not become " + name_of(*to) + ": " + reason);
  };
  for (const auto* schema : {from.get(), to.get()})
    if (schema->min_size() > options.max_message_bytes)
      return refuse(ErrorCode::kUnsupported, name_of(*schema) + " has " + std::to_string(schema->min_size()) +
                                                 " bytes at least, max_message_bytes is " +
                                                 std::to_string(options.max_message_bytes));
  auto compiled = compile_stages(from, to, rules, options);
  if (!compiled) return refuse(compiled.error().code, compiled.error().message);
  auto program = std::make_unique<Program>();
  program->from = from;
  program->to = to;
  program->options = options;
  program->stages = std::move(compiled->stages);
  program->notes = std::move(compiled->notes);
  program->kind = is_pass(program->stages) ? Kind::kPass : Kind::kConvert;
  std::stable_partition(program->notes.begin(), program->notes.end(),
                        [](const Note& note) { return note.kind != Note::Kind::kDropped; });
  return std::shared_ptr<const Plan>(new Plan(std::move(program)));
}

Plan::Plan(std::unique_ptr<const Program> program) : program_(std::move(program)) {}
Plan::~Plan() = default;

Plan::Kind Plan::kind() const {
  return program_->kind;
}
const SchemaPtr& Plan::from() const {
  return program_->from;
}
const SchemaPtr& Plan::to() const {
  return program_->to;
}
const std::vector<Plan::Note>& Plan::notes() const {
  return program_->notes;
}

Result<void> Plan::convert(ByteView message, ByteBuffer& out, std::int64_t time_shift_ns) const {
  const auto& stages = program_->stages;
  Output output(out, program_->options.max_message_bytes, message.size + stages.back().growth);
  Failure failure;
  if (!run_stages(stages, message, output, time_shift_ns, failure))
    return tl::unexpected<Error>(to_error(failure));
  output.finish();
  return {};
}

std::vector<std::string> Plan::describe() const {
  const auto& stages = program_->stages;
  if (kind() == Kind::kPass) return {"pass: forward every message as it is"};
  if (stages.size() == 1) return describe_code(stages.front());
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    lines.push_back("rule " + std::to_string(i + 1) + " of " + std::to_string(stages.size()) + ":");
    for (const auto& line : describe_code(stages[i])) lines.push_back("  " + line);
  }
  return lines;
}

const char* to_string(Plan::Kind kind) {
  return kind == Plan::Kind::kPass ? "pass" : "convert";
}

}  // namespace extperfc::translate
