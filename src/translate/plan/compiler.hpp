#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/plan.hpp"

#include "translate/plan/code_writer.hpp"

namespace extperfc::translate {

/// Bounds of a compilation: definitions come from strangers, and embedded ones multiply.
struct CompileBudget {
  std::size_t fields{60'000};  ///< looked at
  std::size_t depth{64};       ///< of embedding, chains included
};

/// Writes the code of one conversion. Used once. A MessageCompiler, with its FieldCompiler and
/// SourceCompiler, does the work for each message inside; they meet here.
class Compiler {
 public:
  using NoteKind = Plan::Note::Kind;

  Compiler(const RuleSet& rules, const PlanOptions& options, CompileBudget& budget,
           std::vector<Plan::Note>& notes)
      : rules_(rules), options_(options), budget_(budget), notes_(notes) {}

  /// The top of a message: `rule` may be null.
  [[nodiscard]] Result<Code> compile(const MessageSchema& from, const MessageSchema& to,
                                     const MigrationRule* rule);

  /// A message inside another: by its rule, by its fields' names, or through a chain of rules.
  Result<void> embedded(const SchemaPtr& from, const SchemaPtr& to, const std::string& path);
  Result<void> constant(const Literal& value, const Field& to, const std::string& path);
  [[nodiscard]] Result<void> spend();

  [[nodiscard]] CodeWriter& out() { return out_; }
  [[nodiscard]] const PlanOptions& options() const { return options_; }
  [[nodiscard]] std::vector<Plan::Note>& notes() { return notes_; }
  void note(NoteKind kind, const std::string& path, std::string text);
  [[nodiscard]] bool quiet() const { return quiet_; }
  /// No notes: the element is part of something that has one. Returns what was set before.
  bool set_quiet(bool quiet) { return std::exchange(quiet_, quiet); }

 private:
  Result<void> chain(const std::vector<RuleSet::Link>& links, const SchemaPtr& from, const std::string& path);

  const RuleSet& rules_;
  const PlanOptions& options_;
  CompileBudget& budget_;
  std::vector<Plan::Note>& notes_;
  CodeWriter out_;
  bool quiet_{false};
};

/// What a chain of rules became.
struct Chain {
  Stages stages;
  std::vector<Plan::Note> notes;  ///< of the last stage, and what the others drop
};
[[nodiscard]] Result<Chain> compile_chain(const std::vector<RuleSet::Link>& links, const RuleSet& rules,
                                          const PlanOptions& options, CompileBudget& budget);

}  // namespace extperfc::translate
