#include "translate/rules/literal.hpp"

#include <algorithm>
#include <cctype>

#include "extperfc/base/text.hpp"
#include "extperfc/translate/plan.hpp"
#include "extperfc/world/yaml_map.hpp"

#include "translate/plan/field_size.hpp"
#include "translate/rules/path.hpp"

namespace extperfc::translate {

namespace {

bool is_float(Primitive primitive) {
  return primitive == Primitive::kFloat32 || primitive == Primitive::kFloat64;
}

bool is_constant_name(const std::string& text) {
  const auto allowed = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; };
  return !text.empty() && text.front() >= 'A' && text.front() <= 'Z' &&
         std::all_of(text.begin(), text.end(), allowed);
}

/// YAML's spelling of what is no finite number; any other text as it is.
std::string plain_float(const std::string& text) {
  std::string lower = text;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (lower == ".nan") return "nan";
  if (lower == ".inf" || lower == "+.inf") return "inf";
  return lower == "-.inf" ? "-inf" : text;
}

Result<std::string> constant_value(const std::string& name, const MessageSchema& owner) {
  std::vector<std::string> names;
  for (const Constant& constant : owner.constants()) {
    if (constant.name == name) return constant.value;
    names.push_back(constant.name);
  }
  return fail(ErrorCode::kNotFound,
              owner.type() + " has no constant " + in_quotes(name) + hint_for(name, names));
}

Result<void> resolve_names(Literal& literal, const Field& field, const MessageSchema& owner) {
  if (literal.kind == Literal::Kind::kScalar) {
    if (is_float(field.primitive)) literal.scalar = plain_float(literal.scalar);
    if (!is_arithmetic(field.primitive) || !is_constant_name(literal.scalar)) return {};
    auto value = constant_value(literal.scalar, owner);
    if (!value) return tl::unexpected<Error>(value.error());
    literal.scalar = *value;
  }
  const Field element = element_of(field);
  for (Literal& item : literal.list)
    if (auto done = resolve_names(item, element, owner); !done) return done;
  if (field.primitive != Primitive::kMessage) return {};
  for (auto& [name, value] : literal.fields) {
    const Field* inner = field.message->find(name);
    if (inner == nullptr)
      return fail(ErrorCode::kNotFound, field.message->type() + " has no field " + in_quotes(name) +
                                            hint_for(name, field_names(*field.message)));
    if (auto done = resolve_names(value, *inner, *field.message); !done) return done;
  }
  return {};
}

}  // namespace

bool Budget::take(Problems& problems, int line) {
  if (++used_ == kMaxNodes + 1)
    problems.add(line, "", "the file has more than " + std::to_string(kMaxNodes) + " values: divide it");
  return used_ <= kMaxNodes;
}

Literal read_literal(const YAML::Node& node, const std::string& where, Problems& problems, Budget& budget,
                     int depth) {
  Literal literal;
  const int line = line_of(node);
  if (!budget.take(problems, line)) return literal;
  if (depth > kDeepest) {
    problems.add(line, where, "is nested too deeply");
  } else if (node.IsScalar()) {
    literal.scalar = node.Scalar();
  } else if (node.IsSequence()) {
    literal.kind = Literal::Kind::kList;
    for (const auto& item : node)
      literal.list.push_back(read_literal(item, where, problems, budget, depth + 1));
  } else if (node.IsMap()) {
    literal.kind = Literal::Kind::kFields;
    const YamlMap map(node, where, problems);
    for (const auto& item : map.items())
      literal.fields.emplace_back(item.key, read_literal(item.value, where, problems, budget, depth + 1));
  } else {
    problems.add(line, where, "has no value: write one, '' for an empty text");
  }
  return literal;
}

Result<Literal> fit(Literal literal, const Field& field, const MessageSchema& owner) {
  if (auto named = resolve_names(literal, field, owner); !named) return tl::unexpected<Error>(named.error());
  ByteBuffer bytes;
  if (auto done = serialize(literal, field, bytes); !done) return tl::unexpected<Error>(done.error());
  return literal;
}

}  // namespace extperfc::translate
