#include "translate/plan/field_compiler.hpp"

#include <limits>

#include "translate/plan/field_size.hpp"
#include "translate/plan/numbers.hpp"
#include "translate/plan/pose.hpp"

namespace extperfc::translate {

namespace {

bool is_text(const Field& field) {
  return field.primitive == Primitive::kString && field.arity == Arity::kSingle;
}

/// The same bytes on the wire as a string.
Field as_bytes(const Field& text) {
  Field bytes = text;
  bytes.primitive = Primitive::kUint8;
  bytes.arity = Arity::kVariable;
  return bytes;
}

bool is_byte_array(const Field& field) {
  return field.primitive == Primitive::kUint8 && field.arity != Arity::kSingle;
}

bool names_frame(const Field& field) {
  return is_text(field) && (field.name == "frame_id" || field.name == "child_frame_id");
}

bool is_scaled(const Source* rule) {
  return rule != nullptr && (rule->scale != 1.0 || rule->offset != 0.0);
}

bool has_map(const Source* rule) {
  return rule != nullptr && !rule->map.empty();
}

bool is_stamp(Primitive primitive) {
  return primitive == Primitive::kTime || primitive == Primitive::kDuration;
}

/// Larger sizes never pass: a message has less than 4 GiB.
std::uint32_t narrow(std::size_t size) {
  constexpr std::size_t kMax = std::numeric_limits<std::uint32_t>::max();
  return static_cast<std::uint32_t>(size < kMax ? size : kMax);
}

std::string arity_text(const Field& field) {
  auto text = to_string(field);
  text.resize(text.size() - field.name.size() - 1);
  return text;
}

}  // namespace

tl::unexpected<Error> FieldCompiler::mismatch(const Field& from, const Field& to, const std::string& path,
                                              const std::string& remedy) {
  return fail(ErrorCode::kInvalidArgument, "field " + path + ": " + arity_text(from) + " does not become " +
                                               arity_text(to) + " by itself; " + remedy);
}

Result<void> FieldCompiler::compile(const Field& from, const Field& to, const How& how,
                                    const std::string& path) {
  const bool both_single = from.arity == Arity::kSingle && to.arity == Arity::kSingle;
  if (both_single && (has_map(how.rule) || is_text(from) == is_text(to))) return element(from, to, how, path);
  if (is_text(from) && is_byte_array(to)) {
    out_.code().reinterprets = true;
    return array(as_bytes(from), to, how, path);
  }
  if (is_byte_array(from) && is_text(to)) {
    out_.code().reinterprets = true;
    return array(from, as_bytes(to), how, path);
  }
  if (from.arity != Arity::kSingle && to.arity != Arity::kSingle) return array(from, to, how, path);
  if (both_single) return mismatch(from, to, path, "write a rule with a `map` or a `value`");
  return mismatch(
      from, to, path,
      to.arity == Arity::kSingle
          ? "write a rule that takes one element, e.g. from: " + from.name + "[0] with an `otherwise`"
          : "write a rule with a `list`");
}

Result<void> FieldCompiler::array(const Field& from, const Field& to, const How& how,
                                  const std::string& path) {
  const bool from_fixed = from.arity == Arity::kFixed;
  const bool to_fixed = to.arity == Arity::kFixed;
  if (from_fixed && to_fixed && from.fixed_count != to.fixed_count)
    return mismatch(from, to, path, "write a rule with a `list`");
  if (from_fixed && !to_fixed) {
    const auto count = from.fixed_count;
    out_.emit({reinterpret_cast<const std::uint8_t*>(&count), kCountSize}, path);
  }
  if (!from_fixed && to_fixed) {
    Op op{OpCode::kExpectCount};
    op.size = to.fixed_count;
    out_.append(op, path);
  }
  if (from_fixed || to_fixed)
    return repeat(from, to, from_fixed ? from.fixed_count : to.fixed_count, how, path);
  const auto whole = bulk(from, to, std::nullopt, how, path);
  if (!whole) return tl::unexpected(whole.error());
  if (*whole) return {};
  Op op{OpCode::kLoop};
  op.size = narrow(min_element_size(from));
  const auto min_target = min_element_size(to);
  if (op.size == 0 || min_target > op.size) op.extra = narrow(min_target);
  const auto at = out_.begin(op, path);
  if (auto done = element(element_of(from), element_of(to), how, path + "[]"); !done) return done;
  out_.end_loop(at);
  return {};
}

Result<void> FieldCompiler::repeat(const Field& from, const Field& to, std::uint32_t count, const How& how,
                                   const std::string& path) {
  const auto whole = bulk(from, to, count, how, path);
  if (!whole) return tl::unexpected(whole.error());
  if (*whole) return {};
  Op op{OpCode::kRepeat};
  op.size = count;
  const auto at = out_.begin(op, path);
  if (auto done = element(element_of(from), element_of(to), how, path + "[]"); !done) return done;
  out_.end_repeat(at);
  return {};
}

Op FieldCompiler::numbers(const Field& from, const Field& to, const How& how) {
  Op op{OpCode::kNumbers, from.primitive, to.primitive};
  if (how.rule != nullptr && how.rule->overflow == Overflow::kSaturate) op.flags |= kSaturate;
  if (is_scaled(how.rule)) {
    op.flags |= kScaled;
    op.extra = static_cast<std::uint32_t>(out_.code().scales.size());
    out_.code().scales.push_back({how.rule->scale, how.rule->offset});
  }
  return op;
}

Result<bool> FieldCompiler::bulk(const Field& from, const Field& to, std::optional<std::uint32_t> count,
                                 const How& how, const std::string& path) {
  if (has_map(how.rule) && !how.past_map) return false;
  Op op;
  const auto size = size_of(from.primitive);
  if (how.parent_slot) {
    if (!from.message || !to.message || !is_pose(*from.message) || !is_pose(*to.message))
      return mismatch(from, to, path, "`relative_to` needs fields of type geometry_msgs/Pose");
    op = Op{count ? OpCode::kPoses : OpCode::kPosesArray};
    op.extra = *how.parent_slot;
  } else if (is_number(from.primitive) && is_number(to.primitive) &&
             (from.primitive != to.primitive || is_scaled(how.rule))) {
    op = numbers(from, to, how);
    if (!count) op.code = OpCode::kNumbersArray;
  } else if (from.primitive == Primitive::kTime && to.primitive == Primitive::kTime &&
             compiler_.options().shift_times) {
    op = Op{count ? OpCode::kShift : OpCode::kShiftArray, from.primitive, to.primitive};
  } else if (size && from.primitive == to.primitive && !is_scaled(how.rule)) {
    if (count) out_.skip(std::uint64_t{*count} * *size, path);
    if (!count) out_.skip_array(static_cast<std::uint32_t>(*size), path);
    return true;
  } else {
    return false;
  }
  op.flags |= kListed;
  op.size = count.value_or(0);
  if (!count || *count != 0) out_.append(op, path + "[]");
  return true;
}

Result<void> FieldCompiler::element(const Field& from, const Field& to, const How& how,
                                    const std::string& path) {
  if (auto done = compiler_.spend(); !done) return done;
  if (has_map(how.rule) && !how.past_map) return mapped(from, to, how, path);
  if (is_scaled(how.rule) && !(is_number(from.primitive) && is_number(to.primitive)))
    return mismatch(from, to, path, "`scale` and `offset` need numbers");
  const auto one = bulk(from, to, 1, how, path);
  if (!one) return tl::unexpected(one.error());
  if (*one) {
    auto& last = out_.code();
    last.ops.back().flags = static_cast<std::uint8_t>(last.ops.back().flags & ~kListed);
    if (last.remarks.back().first == path + "[]") last.remarks.back().first = path;
    return {};
  }
  if (from.primitive != to.primitive) {
    if (how.rule == nullptr || !is_stamp(from.primitive) || !is_stamp(to.primitive))
      return mismatch(from, to, path, "write a rule with a `map` that has an `otherwise`, or a `value`");
    Op op{OpCode::kSignedTime, from.primitive, to.primitive};
    if (how.rule->overflow == Overflow::kSaturate) op.flags |= kSaturate;
    out_.append(op, path);
    return {};
  }
  if (from.primitive == Primitive::kMessage) return compiler_.embedded(from.message, to.message, path);
  if (compiler_.options().frame_slash == PlanOptions::Slash::kKeep || !names_frame(to)) {
    out_.skip_array(1, path);
    return {};
  }
  Op op{OpCode::kSlash};
  if (compiler_.options().frame_slash == PlanOptions::Slash::kAdd) op.flags |= kAddSlash;
  out_.append(op, path);
  return {};
}

Result<void> FieldCompiler::mapped(const Field& from, const Field& to, const How& how,
                                   const std::string& path) {
  if (from.primitive == Primitive::kMessage) return mismatch(from, to, path, "a `map` takes no messages");
  const Field key_field = element_of(from);
  const Field value_field = element_of(to);
  ConstantMap map;
  for (const auto& [key, value] : how.rule->map) {
    ByteBuffer key_bytes;
    ByteBuffer value_bytes;
    auto done = serialize(key, key_field, key_bytes);
    if (done) done = serialize(value, value_field, value_bytes);
    if (!done)
      return tl::unexpected(Error{done.error().code, "field " + path + ": map: " + done.error().message});
    const auto text = [](const ByteBuffer& bytes) {
      return std::string(bytes.data(), bytes.data() + bytes.size());
    };
    map.entries.emplace_back(text(key_bytes), text(value_bytes));
  }
  Op op{OpCode::kMap, from.primitive, to.primitive};
  op.extra = static_cast<std::uint32_t>(out_.code().maps.size());
  out_.code().maps.push_back(std::move(map));
  const auto at = out_.begin(op, path);
  Result<void> done;
  if (how.rule->otherwise) {
    out_.append(Op{OpCode::kFlush}, path);
    done = skip_element(from, path);
    out_.anchor(path);
    if (done) done = compiler_.constant(*how.rule->otherwise, value_field, path);
  } else {
    How rest = how;
    rest.past_map = true;
    done = element(from, to, rest, path);
  }
  out_.end_body(at);
  return done;
}

Result<void> FieldCompiler::skip(const Field& field, const std::string& path) {
  if (field.arity == Arity::kSingle) return skip_element(field, path);
  const auto size = size_of(field.primitive);
  const bool fixed = field.arity == Arity::kFixed;
  if (size) {
    if (fixed) out_.skip(std::uint64_t{*size} * field.fixed_count, path);
    if (!fixed) out_.skip_array(static_cast<std::uint32_t>(*size), path);
    return {};
  }
  Op op{fixed ? OpCode::kRepeat : OpCode::kLoop};
  op.size = fixed ? field.fixed_count : narrow(min_element_size(field));
  const auto at = out_.begin(op, path);
  auto done = skip_element(field, path + "[]");
  if (fixed) {
    out_.end_repeat(at);
  } else {
    out_.end_loop(at);
  }
  return done;
}

Result<void> FieldCompiler::skip_element(const Field& field, const std::string& path) {
  if (auto done = compiler_.spend(); !done) return done;
  if (field.primitive == Primitive::kString) out_.skip_array(1, path);
  if (const auto size = size_of(field.primitive)) out_.skip(*size, path);
  if (field.primitive != Primitive::kMessage) return {};
  for (const auto& inner : field.message->fields())
    if (auto done = skip(inner, path + "." + inner.name); !done) return done;
  return {};
}

}  // namespace extperfc::translate
