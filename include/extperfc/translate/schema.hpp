#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "extperfc/base/error.hpp"

/// Message, service and action definitions of ROS 1 as data, read at run time.
/// Source: http://wiki.ros.org/msg, /srv, the MD5 rule of genmsg (constants first, in order; then fields,
/// where an embedded message's type is replaced by its own MD5 and its arrayness is lost).
namespace extperfc::translate {

/// What one element of a field is on the wire. `byte` is kInt8 and `char` is kUint8.
enum class Primitive : std::uint8_t {
  kBool,
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64,
  kString,    ///< uint32 length, then opaque bytes
  kTime,      ///< uint32 seconds, uint32 nanoseconds
  kDuration,  ///< int32 seconds, int32 nanoseconds
  kMessage,
};

enum class Arity : std::uint8_t {
  kSingle,
  kVariable,  ///< uint32 count, then the elements
  kFixed,     ///< the elements alone
};

class MessageSchema;
using SchemaPtr = std::shared_ptr<const MessageSchema>;

struct Field {
  std::string name;
  std::string written_type;  ///< as in the text without brackets: "byte", "Header", "geometry_msgs/Point"
  Primitive primitive{Primitive::kUint8};
  Arity arity{Arity::kSingle};
  std::uint32_t fixed_count{0};  ///< of kFixed
  SchemaPtr message;             ///< of kMessage; never null then
};

struct Constant {
  std::string written_type;
  std::string name;
  std::string value;  ///< as it counts for the MD5: stripped; of a string everything after '='
};

/// One definition with everything it embeds. Immutable.
class MessageSchema {
 public:
  MessageSchema(std::string type, std::vector<Field> fields, std::vector<Constant> constants);

  [[nodiscard]] const std::string& type() const { return type_; }  ///< "package/Name"
  [[nodiscard]] const std::string& md5() const {
    return md5_;
  }  ///< 32 hexadecimal digits, as genmsg computes it
  [[nodiscard]] const std::vector<Field>& fields() const { return fields_; }
  [[nodiscard]] const std::vector<Constant>& constants() const { return constants_; }
  [[nodiscard]] const Field* find(std::string_view field_name) const;  ///< null if it does not exist
  /// Bytes on the wire when every instance has the same number, e.g. 24 of geometry_msgs/Point.
  [[nodiscard]] std::optional<std::size_t> fixed_size() const { return fixed_size_; }
  /// Minimum size of an instance [bytes].
  [[nodiscard]] std::size_t min_size() const { return min_size_; }
  /// True when a `time` is in it, at any depth.
  [[nodiscard]] bool has_time() const { return has_time_; }
  /// Definitions that embed one another below this one: 0 when it embeds none.
  [[nodiscard]] std::size_t depth() const { return depth_; }
  /// Fields with those of every embedded definition, each time it is used (arrays count once): the cost of
  /// visiting all of them.
  [[nodiscard]] std::size_t expanded_fields() const { return expanded_fields_; }

  /// The text of this definition alone (no comments; constants first).
  [[nodiscard]] std::string text() const;
  /// The text with every embedded definition, as connection headers and bags carry it ("====", "MSG: type").
  [[nodiscard]] std::string full_text() const;

 private:
  std::string type_;
  std::vector<Field> fields_;
  std::vector<Constant> constants_;
  std::string md5_;
  std::optional<std::size_t> fixed_size_;
  std::size_t min_size_{0};
  std::size_t depth_{0};
  std::size_t expanded_fields_{0};
  bool has_time_{false};
};

struct ServiceSchema {
  std::string type;
  std::string md5;
  SchemaPtr request;   ///< type "package/NameRequest"
  SchemaPtr response;  ///< type "package/NameResponse"
};
using ServicePtr = std::shared_ptr<const ServiceSchema>;

/// An action and the messages that genaction derives from it.
struct ActionSchema {
  std::string type;  ///< "package/Name"
  SchemaPtr goal, result, feedback;
  SchemaPtr action_goal, action_result, action_feedback, action;
};
using ActionPtr = std::shared_ptr<const ActionSchema>;

/// Limits of a definition: connection headers come from untrusted nodes.
struct SchemaLimits {
  std::size_t text_bytes{1U << 20U};
  std::size_t fields{2000};      ///< of one definition, constants included
  std::size_t depth{32};         ///< of embedding
  std::size_t definitions{500};  ///< in one full text
  std::size_t expanded_fields{50'000};
  std::uint32_t fixed_count{1U << 24U};
};

/// Looks an embedded type ("package/Name") up; null when it is not known.
using FindSchema = std::function<SchemaPtr(const std::string& type)>;

/// A definition's own text; what it embeds comes from `find`. Errors name the type, the line and the remedy.
[[nodiscard]] Result<SchemaPtr> parse_message(const std::string& type, std::string_view text,
                                              const FindSchema& find, const SchemaLimits& limits = {});
/// A text with its embedded definitions, as connection headers carry it.
[[nodiscard]] Result<SchemaPtr> parse_full_text(const std::string& type, std::string_view full_text,
                                                const SchemaLimits& limits = {});
/// Request and response, divided by a line of three dashes.
[[nodiscard]] Result<ServicePtr> parse_service(const std::string& type, std::string_view text,
                                               const FindSchema& find, const SchemaLimits& limits = {});
/// Goal, result and feedback; `find` must know actionlib_msgs/GoalID, GoalStatus and std_msgs/Header.
[[nodiscard]] Result<ActionPtr> parse_action(const std::string& type, std::string_view text,
                                             const FindSchema& find, const SchemaLimits& limits = {});

/// The types ("package/Name") that a text embeds, in order of their first use. For loaders that order files.
[[nodiscard]] Result<std::vector<std::string>> embedded_types(const std::string& type, std::string_view text);

/// True when both have the same fields in name, order, primitive and arity, at every depth: equal bytes mean
/// the same. Equal MD5s do not imply it (`Point p` and `Point[] p` share one), nor does it imply equal MD5s
/// (constants).
[[nodiscard]] bool same_layout(const MessageSchema& a, const MessageSchema& b);

/// "float64", "string", "message".
[[nodiscard]] const char* to_string(Primitive primitive);
/// As in a definition: "geometry_msgs/Point[3] corners".
[[nodiscard]] std::string to_string(const Field& field);
/// Bytes of one element; std::nullopt for strings and messages.
[[nodiscard]] std::optional<std::size_t> size_of(Primitive primitive);

}  // namespace extperfc::translate
