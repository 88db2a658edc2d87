#include "translate/plan/source_compiler.hpp"

#include <array>
#include <cstdio>

#include "translate/plan/field_size.hpp"
#include "translate/plan/pose.hpp"

namespace extperfc::translate {

namespace {

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

std::string literal_text(const Literal& value) {
  if (value.kind == Literal::Kind::kScalar) return value.scalar.empty() ? "''" : value.scalar;
  std::string text;
  for (const auto& item : value.list) text += (text.empty() ? "" : ", ") + literal_text(item);
  for (const auto& [name, inner] : value.fields)
    text += (text.empty() ? "" : ", ") + name + ": " + literal_text(inner);
  return value.kind == Literal::Kind::kList ? "[" + text + "]" : "{" + text + "}";
}

tl::unexpected<Error> no_field(const std::string& where, const MessageSchema& schema,
                               const std::string& name) {
  return fail(ErrorCode::kNotFound, where + ": " + schema.type() + " has no field " + name);
}

std::string field_text(const Source& source) {
  auto text = "from " + to_string(source.path);
  if (source.scale != 1.0) text += ", times " + number(source.scale);
  if (source.offset != 0.0) text += ", plus " + number(source.offset);
  std::string pairs;
  for (const auto& [key, value] : source.map)
    pairs += (pairs.empty() ? "" : ", ") + literal_text(key) + " to " + literal_text(value);
  if (!pairs.empty()) text += ", " + pairs;
  if (source.otherwise) text += ", otherwise " + literal_text(*source.otherwise);
  if (source.overflow == Overflow::kSaturate) text += ", the nearest that fits";
  if (!source.relative_to.empty()) text += ", in the parent of " + to_string(source.relative_to);
  return text;
}

}  // namespace

std::string to_string(const Source& source) {
  if (source.kind == Source::Kind::kField) return field_text(source);
  if (source.kind == Source::Kind::kValue) return "always " + literal_text(source.value);
  std::string text;
  for (const auto& item : source.list) text += (text.empty() ? "" : "; ") + to_string(item);
  for (const auto& [name, inner] : source.fields)
    text += (text.empty() ? "" : "; ") + name + " " + to_string(inner);
  return source.kind == Source::Kind::kList ? "list of " + text : "built: " + text;
}

bool is_whole_field(const Source& source) {
  return source.kind == Source::Kind::kField && source.path.size() == 1 && !source.path.front().index &&
         source.relative_to.empty();
}

Result<void> SourceCompiler::compile(const Source& from, const Field& to, const std::string& path) {
  if (auto done = compiler_.spend(); !done) return done;
  switch (from.kind) {
    case Source::Kind::kField:
      return from_field(from, to, path);
    case Source::Kind::kValue:
      return compiler_.constant(from.value, to, path);
    case Source::Kind::kList:
      return from_list(from, to, path);
    case Source::Kind::kMessage:
      return from_fields(from, to, path);
  }
  return fail(ErrorCode::kInvalidArgument, "field " + path + ": a source of an unknown kind");
}

Result<void> SourceCompiler::from_list(const Source& from, const Field& to, const std::string& path) {
  if (to.arity == Arity::kSingle)
    return fail(ErrorCode::kInvalidArgument, "field " + path + " is not an array: it takes no `list`");
  const auto count = static_cast<std::uint32_t>(from.list.size());
  if (to.arity == Arity::kFixed && to.fixed_count != count)
    return fail(ErrorCode::kInvalidArgument, "field " + path + " has " + std::to_string(to.fixed_count) +
                                                 " elements, the list has " + std::to_string(count));
  if (to.arity == Arity::kVariable)
    out_.emit({reinterpret_cast<const std::uint8_t*>(&count), sizeof count}, path);
  const Field element = element_of(to);
  for (std::size_t i = 0; i < from.list.size(); ++i)
    if (auto done = compile(from.list[i], element, path + "[" + std::to_string(i) + "]"); !done) return done;
  return {};
}

Result<void> SourceCompiler::from_fields(const Source& from, const Field& to, const std::string& path) {
  if (to.primitive != Primitive::kMessage || to.arity != Arity::kSingle)
    return fail(ErrorCode::kInvalidArgument,
                "field " + path + " is not an embedded message: it takes no `fields`");
  for (const auto& [name, inner] : from.fields)
    if (to.message->find(name) == nullptr) return no_field("field " + path, *to.message, name);
  for (const auto& field : to.message->fields()) {
    const auto inner_path = path + "." + field.name;
    const Source* given = nullptr;
    for (const auto& [name, inner] : from.fields)
      if (name == field.name) given = &inner;
    if (given == nullptr) {
      out_.zero(min_size(field), inner_path);
    } else if (auto done = compile(*given, field, inner_path); !done) {
      return done;
    }
  }
  return {};
}

Result<void> SourceCompiler::from_field(const Source& from, const Field& to, const std::string& path) {
  FieldCompiler::How how{&from};
  if (!from.relative_to.empty()) {
    auto slot = parent_pose(from.relative_to);
    if (!slot) return tl::unexpected(slot.error());
    how.parent_slot = *slot;
  }
  Field leaf;
  std::vector<std::size_t> jumps;
  if (auto done = navigate(from.path, leaf, jumps); !done) return done;
  out_.anchor(path);
  if (auto done = fields_.compile(leaf, to, how, path); !done) return done;
  if (jumps.empty() || !from.otherwise) return {};
  out_.append(Op{OpCode::kFlush}, path);
  const auto over = out_.append(Op{OpCode::kJump}, path);
  for (const auto at : jumps) out_.code().ops[at].extra = out_.here();
  out_.anchor(path);
  if (auto done = compiler_.constant(*from.otherwise, to, path); !done) return done;
  out_.code().ops[over].extra = out_.here();
  return {};
}

Result<std::uint32_t> SourceCompiler::parent_pose(const Path& path) {
  Field leaf;
  std::vector<std::size_t> jumps;
  if (auto done = navigate(path, leaf, jumps); !done) return tl::unexpected(done.error());
  if (!leaf.message || leaf.arity != Arity::kSingle || !is_pose(*leaf.message))
    return fail(ErrorCode::kInvalidArgument,
                "`relative_to` names " + to_string(path) + ", which is not a geometry_msgs/Pose");
  const auto slot = out_.new_slot();
  out_.mark(slot, to_string(path));
  out_.skip(kPoseSize, to_string(path));
  out_.anchor(to_string(path));
  return slot;
}

Result<void> SourceCompiler::navigate(const Path& path, Field& leaf, std::vector<std::size_t>& jumps) {
  const MessageSchema* inside = &pair_.from;
  for (std::size_t step = 0; step < path.size(); ++step) {
    const auto where = pair_.path + to_string(path);
    const auto* next = inside->find(path[step].field);
    if (next == nullptr) return no_field("path " + where, *inside, path[step].field);
    const auto index = static_cast<std::size_t>(next - inside->fields().data());
    if (step == 0) {
      out_.seek(pair_.slots[index], where);
    } else {
      for (std::size_t i = 0; i < index; ++i)
        if (auto done = fields_.skip(inside->fields()[i], where); !done) return done;
    }
    leaf = *next;
    if (path[step].index) {
      if (auto done = enter_element(leaf, *path[step].index, where, jumps); !done) return done;
    }
    if (step + 1 == path.size()) break;
    if (!leaf.message || leaf.arity != Arity::kSingle)
      return fail(ErrorCode::kInvalidArgument,
                  "path " + where + ": " + leaf.name +
                      " is not a single message: give an index, or end the path there");
    inside = leaf.message.get();
  }
  if (path.empty()) return fail(ErrorCode::kInvalidArgument, "a path is empty");
  return {};
}

Result<void> SourceCompiler::enter_element(Field& leaf, std::size_t index, const std::string& path,
                                           std::vector<std::size_t>& jumps) {
  constexpr std::size_t kMaxIndex = 0xFFFFFFFF;
  if (leaf.arity == Arity::kSingle || index > kMaxIndex ||
      (leaf.arity == Arity::kFixed && index >= leaf.fixed_count))
    return fail(ErrorCode::kInvalidArgument,
                "path " + path + ": " + leaf.name + " has no element " + std::to_string(index));
  const bool fixed = leaf.arity == Arity::kFixed;
  leaf = element_of(leaf);
  Op op{fixed ? OpCode::kRepeat : OpCode::kIndex};
  op.size = static_cast<std::uint32_t>(index);
  const auto at = out_.begin(op, path);
  if (auto done = fields_.skip_element(leaf, path); !done) return done;
  if (fixed) {
    out_.end_repeat(at);
  } else {
    out_.end_body(at);
    jumps.push_back(at);
  }
  return {};
}

}  // namespace extperfc::translate
