#include "test/unit/translate/plan/random_schema.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::translate {

Primitive RandomSchema::random_number() {
  return static_cast<Primitive>(rng_.integer(0, 10));
}

std::string RandomSchema::new_name() {
  return "f" + std::to_string(names_++);
}

SchemaPtr RandomSchema::build(std::vector<Field> fields) {
  return std::make_shared<const MessageSchema>("test_msgs/M" + std::to_string(names_++), std::move(fields),
                                               std::vector<Constant>());
}

Field RandomSchema::random_field(int depth) {
  Field field;
  field.name = new_name();
  const int kind = rng_.integer(0, depth < 3 ? 13 : 10);
  if (kind <= 5) field.primitive = random_number();
  if (kind == 6 || kind == 7) field.primitive = Primitive::kString;
  if (kind == 8) field.primitive = Primitive::kTime;
  if (kind == 9) field.primitive = Primitive::kDuration;
  if (kind == 10) {
    field.primitive = Primitive::kString;
    field.name = rng_.chance(0.5) ? "frame_id" : "child_frame_id";
  }
  field.arity = kind == 10 ? Arity::kSingle : static_cast<Arity>(std::max(0, rng_.integer(-2, 2)));
  if (kind > 10) {
    field.primitive = Primitive::kMessage;
    field.message = make(depth + 1);
  }
  if (field.arity == Arity::kFixed) field.fixed_count = static_cast<std::uint32_t>(rng_.integer(0, 3));
  field.written_type = field.message ? field.message->type() : to_string(field.primitive);
  return field;
}

SchemaPtr RandomSchema::make(int depth) {
  std::vector<Field> fields;
  const int count = rng_.integer(0, 7);
  for (int i = 0; i < count; ++i) {
    auto field = random_field(depth);
    const auto same = [&](const Field& other) { return other.name == field.name; };
    if (std::none_of(fields.begin(), fields.end(), same)) fields.push_back(std::move(field));
  }
  return build(std::move(fields));
}

Field RandomSchema::evolve(Field field, int depth) {
  if (field.message) field.message = rng_.chance(0.5) ? evolve(*field.message, depth + 1) : field.message;
  const bool number = field.primitive <= Primitive::kFloat64;
  if (number && rng_.chance(0.2)) field.primitive = random_number();
  if (field.arity == Arity::kFixed && rng_.chance(0.2)) {
    field.arity = Arity::kVariable;
    field.fixed_count = 0;
  } else if (field.arity == Arity::kVariable && rng_.chance(0.1)) {
    field.arity = Arity::kFixed;
    field.fixed_count = static_cast<std::uint32_t>(rng_.integer(0, 3));
  }
  if (field.primitive == Primitive::kString && field.arity == Arity::kSingle && rng_.chance(0.1)) {
    field.primitive = Primitive::kUint8;
    field.arity = Arity::kVariable;
  }
  field.written_type = field.message ? field.message->type() : to_string(field.primitive);
  return field;
}

SchemaPtr RandomSchema::evolve(const MessageSchema& schema, int depth) {
  std::vector<Field> fields;
  for (const auto& field : schema.fields())
    if (!rng_.chance(0.1)) fields.push_back(evolve(field, depth));
  const auto place = [&](int max_index) { return rng_.integer(0, max_index); };
  if (rng_.chance(0.4)) {
    auto added = random_field(3);
    added.name = new_name();
    fields.insert(fields.begin() + place(static_cast<int>(fields.size())), added);
  }
  if (fields.size() > 1 && rng_.chance(0.3)) {
    const auto last = static_cast<int>(fields.size()) - 1;
    std::swap(fields[static_cast<std::size_t>(place(last))], fields[static_cast<std::size_t>(place(last))]);
  }
  return build(std::move(fields));
}

}  // namespace extperfc::translate
