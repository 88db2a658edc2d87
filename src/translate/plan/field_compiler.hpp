#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "translate/plan/compiler.hpp"

namespace extperfc::translate {

/// Writes the code that takes a field of the source to one of the target, or passes it.
class FieldCompiler {
 public:
  /// How a value gets to its field, beyond its type.
  struct How {
    const Source* rule{nullptr};
    std::optional<std::uint32_t> parent_slot{};  ///< of the pose of relative_to
    bool past_map{false};                        ///< `map` was looked at already
  };

  explicit FieldCompiler(Compiler& compiler) : compiler_(compiler) {}

  Result<void> compile(const Field& from, const Field& to, const How& how, const std::string& path);
  Result<void> skip(const Field& field, const std::string& path);
  Result<void> skip_element(const Field& field, const std::string& path);

 private:
  Result<void> array(const Field& from, const Field& to, const How& how, const std::string& path);
  Result<void> repeat(const Field& from, const Field& to, std::uint32_t count, const How& how,
                      const std::string& path);
  Result<void> element(const Field& from, const Field& to, const How& how, const std::string& path);
  Result<void> mapped(const Field& from, const Field& to, const How& how, const std::string& path);
  /// Adds one instruction for `count` elements, or for a whole array without a count. False when no such
  /// instruction exists: then elements are converted one by one.
  Result<bool> bulk(const Field& from, const Field& to, std::optional<std::uint32_t> count, const How& how,
                    const std::string& path);
  Op numbers(const Field& from, const Field& to, const How& how);
  [[nodiscard]] static tl::unexpected<Error> mismatch(const Field& from, const Field& to,
                                                      const std::string& path, const std::string& remedy);

  Compiler& compiler_;
  CodeWriter& out_{compiler_.out()};
};

}  // namespace extperfc::translate
