#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "translate/plan/field_compiler.hpp"

namespace extperfc::translate {

/// A message under conversion.
struct MessagePair {
  const MessageSchema& from;
  const MessageSchema& to;
  const MigrationRule* rule;
  std::string path;                    ///< with a dot at its end when not empty
  std::vector<std::uint32_t> slots{};  ///< by field of the source, when the source is scanned first
};

/// Writes the code of what rules say about a field of the target.
class SourceCompiler {
 public:
  SourceCompiler(Compiler& compiler, const MessagePair& pair) : compiler_(compiler), pair_(pair) {}

  Result<void> compile(const Source& from, const Field& to, const std::string& path);

 private:
  Result<void> from_field(const Source& from, const Field& to, const std::string& path);
  Result<void> from_list(const Source& from, const Field& to, const std::string& path);
  Result<void> from_fields(const Source& from, const Field& to, const std::string& path);
  /// Moves to the end of a path; `leaf` becomes the field there. `jumps` collects the kIndex instructions on
  /// the way.
  Result<void> navigate(const Path& path, Field& leaf, std::vector<std::size_t>& jumps);
  Result<void> enter_element(Field& leaf, std::size_t index, const std::string& path,
                             std::vector<std::size_t>& jumps);
  Result<std::uint32_t> parent_pose(const Path& path);

  Compiler& compiler_;
  const MessagePair& pair_;
  CodeWriter& out_{compiler_.out()};
  FieldCompiler fields_{compiler_};
};

/// True when a source is one whole field of the source message, so that it can be read where it stands.
[[nodiscard]] bool is_whole_field(const Source& source);
/// "from speed, times 0.01".
[[nodiscard]] std::string to_string(const Source& source);

}  // namespace extperfc::translate
