#pragma once

#include <string>
#include <vector>

#include "translate/plan/field_compiler.hpp"
#include "translate/plan/source_compiler.hpp"

namespace extperfc::translate {

/// Writes the code of one message under conversion: pairs the fields, orders and drops them.
class MessageCompiler {
 public:
  /// `rule` may be null; `path` has a dot at its end when not empty.
  MessageCompiler(Compiler& compiler, const MessageSchema& from, const MessageSchema& to,
                  const MigrationRule* rule, std::string path)
      : compiler_(compiler), pair_{from, to, rule, std::move(path)} {}

  Result<void> compile();

 private:
  using NoteKind = Plan::Note::Kind;

  /// One field of the target and where it comes from.
  struct Piece {
    const Field* target{nullptr};
    const Field* source{nullptr};  ///< null: no single field of the source
    std::size_t source_index{0};
    const Source* rule{nullptr};
    bool moved{false};  ///< it stood after a field that now follows it
  };

  [[nodiscard]] std::vector<Piece> pieces() const;
  Result<void> streamed(const std::vector<Piece>& all);
  Result<void> scanned(const std::vector<Piece>& all);
  Result<void> piece(const Piece& one);
  Result<void> paired(const Piece& one);
  void drop(std::size_t first, std::size_t last);
  void note_dropped(const std::vector<Piece>& all);

  Compiler& compiler_;
  MessagePair pair_;
  CodeWriter& out_{compiler_.out()};
  FieldCompiler fields_{compiler_};
  SourceCompiler sources_{compiler_, pair_};
};

}  // namespace extperfc::translate
