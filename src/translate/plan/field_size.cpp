#include "translate/plan/field_size.hpp"

#include <limits>

namespace extperfc::translate {

Field element_of(const Field& field) {
  Field element = field;
  element.arity = Arity::kSingle;
  element.fixed_count = 0;
  return element;
}

std::size_t min_element_size(const Field& field) {
  if (field.primitive == Primitive::kMessage) return field.message->min_size();
  return size_of(field.primitive).value_or(kCountSize);
}

std::size_t min_size(const Field& field) {
  if (field.arity == Arity::kVariable) return kCountSize;
  const auto size = min_element_size(field);
  if (field.arity == Arity::kSingle || size == 0) return size;
  constexpr std::size_t kMax = std::numeric_limits<std::size_t>::max();
  return field.fixed_count > kMax / size ? kMax : size * field.fixed_count;
}

}  // namespace extperfc::translate
