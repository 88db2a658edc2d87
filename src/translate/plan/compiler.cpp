#include "translate/plan/compiler.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "translate/plan/message_compiler.hpp"

namespace extperfc::translate {

Result<Code> Compiler::compile(const MessageSchema& from, const MessageSchema& to,
                               const MigrationRule* rule) {
  if (auto done = MessageCompiler(*this, from, to, rule, "").compile(); !done)
    return tl::unexpected(done.error());
  if (out_.overflowed())
    return fail(ErrorCode::kUnsupported, "the definitions are too large: their fixed parts exceed 4 GiB");
  auto& code = out_.code();
  code.growth = to.min_size() > from.min_size() ? to.min_size() - from.min_size() : 0;
  return std::move(code);
}

Result<void> Compiler::spend() {
  if (budget_.fields == 0)
    return fail(ErrorCode::kUnsupported, "the definitions are too large: they embed too many fields");
  --budget_.fields;
  return {};
}

void Compiler::note(NoteKind kind, const std::string& path, std::string text) {
  if (!quiet_) notes_.push_back({kind, path, std::move(text)});
}

Result<void> Compiler::constant(const Literal& value, const Field& to, const std::string& path) {
  ByteBuffer bytes;
  if (auto done = serialize(value, to, bytes); !done)
    return tl::unexpected(Error{done.error().code, "field " + path + ": " + done.error().message});
  out_.emit(bytes.view(), path);
  return {};
}

Result<void> Compiler::embedded(const SchemaPtr& from, const SchemaPtr& to, const std::string& path) {
  if (budget_.depth == 0)
    return fail(ErrorCode::kUnsupported, "field " + path + " is embedded too deeply, or rules form a cycle");
  --budget_.depth;
  const bool same = from->type() == to->type() && from->md5() == to->md5();
  const auto* rule = same ? nullptr : rules_.find(*from, *to);
  std::vector<RuleSet::Link> links;
  if (!same && rule == nullptr) links = rules_.chain(from, to);
  auto done = links.empty() ? MessageCompiler(*this, *from, *to, rule, path + ".").compile()
                            : chain(links, from, path);
  ++budget_.depth;
  return done;
}

Result<void> Compiler::chain(const std::vector<RuleSet::Link>& links, const SchemaPtr& from,
                             const std::string& path) {
  auto stages = compile_chain(links, rules_, options_, budget_);
  if (!stages) return tl::unexpected(Error{stages.error().code, path + ": " + stages.error().message});
  Op op{OpCode::kChain};
  op.extra = static_cast<std::uint32_t>(out_.code().chains.size());
  out_.code().chains.push_back(std::move(stages->stages));
  const auto at = out_.begin(op, path);
  for (const auto& field : from->fields())
    if (auto done = FieldCompiler(*this).skip(field, path + "." + field.name); !done) return done;
  out_.end_body(at);
  note(NoteKind::kRule, path, "through " + std::to_string(links.size()) + " rules, one after the other");
  return {};
}

Result<Chain> compile_chain(const std::vector<RuleSet::Link>& links, const RuleSet& rules,
                            const PlanOptions& options, CompileBudget& budget) {
  if (budget.depth == 0) return fail(ErrorCode::kUnsupported, "rules form a cycle");
  --budget.depth;
  Chain chain;
  for (std::size_t i = 0; i < links.size(); ++i) {
    auto of_stage = options;  // stamps are shifted once, and frames get their slash once
    if (i != 0) of_stage.shift_times = false;
    if (i + 1 != links.size()) of_stage.frame_slash = PlanOptions::Slash::kKeep;
    const auto dropped = [](const Plan::Note& note) { return note.kind == Plan::Note::Kind::kDropped; };
    std::vector<Plan::Note> notes;
    auto code = Compiler(rules, of_stage, budget, notes).compile(*links[i].from, *links[i].to, links[i].rule);
    if (!code) return tl::unexpected(code.error());
    chain.stages.push_back(std::move(*code));
    if (i + 1 != links.size())
      notes.erase(std::remove_if(notes.begin(), notes.end(), std::not_fn(dropped)), notes.end());
    chain.notes.insert(chain.notes.end(), notes.begin(), notes.end());
  }
  ++budget.depth;
  return chain;
}

}  // namespace extperfc::translate
