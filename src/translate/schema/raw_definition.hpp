#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {

/// A field as it is written, before what it embeds is known.
struct RawField {
  Field field;           ///< everything but Field::message
  std::string embedded;  ///< "package/Name" of kMessage, else empty
  std::size_t line{0};   ///< counted from 1
};

/// The lines of one definition.
struct RawDefinition {
  std::vector<RawField> fields;
  std::vector<Constant> constants;
};

/// A text between two divisions, and the number of its first line.
struct TextPart {
  std::string_view text;
  std::size_t first_line{1};
};

/// "package/Name": letters, digits and underscores, each begins with a letter.
[[nodiscard]] bool valid_type_name(std::string_view type);
[[nodiscard]] std::string package_of(std::string_view type);

/// Without white space at both ends.
[[nodiscard]] std::string_view strip(std::string_view text);
/// The first line of `rest`, which loses it with its end: LF, CR LF or CR alone.
[[nodiscard]] std::string_view take_line(std::string_view& rest);
/// Divides at lines that begin with three dashes.
[[nodiscard]] std::vector<TextPart> split_at_dashes(std::string_view text);

/// `type` gives short names their package. Errors name the type and the line.
[[nodiscard]] Result<RawDefinition> parse_lines(const std::string& type, const TextPart& part,
                                                const SchemaLimits& limits);
/// Puts the embedded schemas in; null from `find` is an error that names the type and the line.
[[nodiscard]] Result<SchemaPtr> resolve(const std::string& type, RawDefinition raw, const FindSchema& find,
                                        const SchemaLimits& limits);
/// The text whose MD5 names the definition; of a service the MD5 is of both halves' texts.
[[nodiscard]] std::string md5_text(const MessageSchema& schema);

}  // namespace extperfc::translate
