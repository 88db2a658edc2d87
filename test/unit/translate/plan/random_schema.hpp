#pragma once

#include <string>

#include "extperfc/base/rng.hpp"
#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {

/// Random definitions, and random later versions of them that convert without a rule.
class RandomSchema {
 public:
  explicit RandomSchema(Rng& rng) : rng_(rng) {}

  [[nodiscard]] SchemaPtr make(int depth = 0);
  /// Fields dropped, added, moved, widened, narrowed; arrays fixed or variable.
  [[nodiscard]] SchemaPtr evolve(const MessageSchema& schema, int depth = 0);

 private:
  [[nodiscard]] Field random_field(int depth);
  [[nodiscard]] Field evolve(Field field, int depth);
  [[nodiscard]] std::string new_name();
  [[nodiscard]] SchemaPtr build(std::vector<Field> fields);
  [[nodiscard]] Primitive random_number();

  Rng& rng_;
  int names_{0};
};

}  // namespace extperfc::translate
