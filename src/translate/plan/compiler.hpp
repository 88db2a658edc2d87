#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/plan.hpp"

#include "translate/plan/code_writer.hpp"

namespace extperfc::translate::plan {

/// Bounds of a compilation: definitions come from strangers, and embedded ones multiply.
struct Budget {
  std::size_t fields{60'000};  ///< looked at
  std::size_t depth{64};       ///< of embedding, chains included
};

/// Writes the code of one conversion. Used once.
class Compiler {
 public:
  Compiler(const RuleSet& rules, const PlanOptions& options, Budget& budget, std::vector<Plan::Note>& notes)
      : rules_(rules), options_(options), budget_(budget), notes_(notes) {}

  /// The top of a message: `rule` may be null.
  [[nodiscard]] Result<Code> compile(const MessageSchema& from, const MessageSchema& to,
                                     const MigrationRule* rule);

 private:
  using NoteKind = Plan::Note::Kind;

  /// How a value gets to its field, beyond its type.
  struct How {
    const Source* rule{nullptr};
    std::optional<std::uint32_t> parent_slot{};  ///< of the pose of relative_to
    bool past_map{false};                        ///< `map` was looked at already
  };

  /// One field of the target and where it comes from.
  struct Piece {
    const Field* target{nullptr};
    const Field* source{nullptr};  ///< null: no single field of the source
    std::size_t source_index{0};
    const Source* rule{nullptr};
    bool moved{false};  ///< it stood after a field that now follows it
  };
  /// A message under conversion.
  struct Pair {
    const MessageSchema& from;
    const MessageSchema& to;
    const MigrationRule* rule;
    std::string path;                    ///< with a dot at its end when not empty
    std::vector<std::uint32_t> slots{};  ///< by field of the source, when the source is scanned first
  };

  // Messages, compile_messages.cpp
  Result<void> embedded(const SchemaPtr& from, const SchemaPtr& to, const std::string& path);
  Result<void> message(Pair& pair);
  [[nodiscard]] std::vector<Piece> pieces(const Pair& pair) const;
  Result<void> streamed(Pair& pair, const std::vector<Piece>& all);
  Result<void> scanned(Pair& pair, const std::vector<Piece>& all);
  Result<void> piece(Pair& pair, const Piece& one);
  Result<void> paired(Pair& pair, const Piece& one);
  void drop(const Pair& pair, std::size_t first, std::size_t last);
  void note_dropped(const Pair& pair, const std::vector<Piece>& all);
  Result<void> chain(const std::vector<RuleSet::Link>& links, const SchemaPtr& from, const std::string& path);

  // Fields, compile_fields.cpp
  Result<void> field(const Field& from, const Field& to, const How& how, const std::string& path);
  Result<void> array(const Field& from, const Field& to, const How& how, const std::string& path);
  Result<void> repeat(const Field& from, const Field& to, std::uint32_t count, const How& how,
                      const std::string& path);
  Result<void> element(const Field& from, const Field& to, const How& how, const std::string& path);
  Result<void> mapped(const Field& from, const Field& to, const How& how, const std::string& path);
  /// Instructions that take `count` elements, or a whole array when there is none; false when there is no
  /// such instruction and elements go one by one.
  Result<bool> bulk(const Field& from, const Field& to, std::optional<std::uint32_t> count, const How& how,
                    const std::string& path);
  Op numbers(const Field& from, const Field& to, const How& how);
  Result<void> skip(const Field& field, const std::string& path);
  Result<void> skip_element(const Field& field, const std::string& path);

  // What rules say, compile_sources.cpp
  Result<void> source(Pair& pair, const Source& from, const Field& to, const std::string& path);
  Result<void> from_field(Pair& pair, const Source& from, const Field& to, const std::string& path);
  Result<void> from_list(Pair& pair, const Source& from, const Field& to, const std::string& path);
  Result<void> from_fields(Pair& pair, const Source& from, const Field& to, const std::string& path);
  Result<void> constant(const Literal& value, const Field& to, const std::string& path);
  /// Moves to the end of a path; `leaf` becomes the field there. `jumps` collects the kIndex instructions on
  /// the way.
  Result<void> navigate(Pair& pair, const Path& path, Field& leaf, std::vector<std::size_t>& jumps);
  Result<void> enter_element(Field& leaf, std::size_t index, const std::string& path,
                             std::vector<std::size_t>& jumps);
  Result<std::uint32_t> parent_pose(Pair& pair, const Path& path);

  [[nodiscard]] Result<void> spend();
  void note(NoteKind kind, const std::string& path, std::string text);
  [[nodiscard]] static tl::unexpected<Error> mismatch(const Field& from, const Field& to,
                                                      const std::string& path, const std::string& remedy);

  const RuleSet& rules_;
  const PlanOptions& options_;
  Budget& budget_;
  std::vector<Plan::Note>& notes_;
  CodeWriter out_;
  bool quiet_{false};  ///< no notes: the element is part of something that has one
};

/// What a chain of rules became.
struct Chain {
  Stages stages;
  std::vector<Plan::Note> notes;  ///< of the last stage, and what the others drop
};
[[nodiscard]] Result<Chain> compile_chain(const std::vector<RuleSet::Link>& links, const RuleSet& rules,
                                          const PlanOptions& options, Budget& budget);

/// A field as one element of it.
[[nodiscard]] Field element_of(const Field& field);
/// The fewest bytes of an element or of a field.
[[nodiscard]] std::size_t min_element_size(const Field& field);
[[nodiscard]] std::size_t min_size(const Field& field);
/// True when a source is one whole field of the source message, so that it can be read where it stands.
[[nodiscard]] bool is_whole_field(const Source& source);
/// "from speed, times 0.01".
[[nodiscard]] std::string to_text(const Source& source);
[[nodiscard]] std::string to_text(const Path& path);

}  // namespace extperfc::translate::plan
