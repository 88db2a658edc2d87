#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/mapping/mapper.hpp"

namespace extperfc::mapping {

/// A parameter under its public name: GMapping's names where the meaning is the same.
struct ParamName {
  /// Which member it sets.
  using Field = std::variant<int MapperParams::*, double MapperParams::*, std::uint64_t MapperParams::*>;

  std::string_view name;  ///< e.g. "linearUpdate"
  Field field;
  std::string_view unit;  ///< e.g. "m"; empty for a fraction or a count
  std::string_view help;  ///< one line
};

/// All of them, in the order of MapperParams.
[[nodiscard]] const std::vector<ParamName>& param_names();

/// The value as text.
[[nodiscard]] std::string param_text(const MapperParams& params, const ParamName& name);

/// Sets one parameter from text. Errors: an unknown name (with the nearest known one), not a number. Ranges
/// are validate(MapperParams)'s.
[[nodiscard]] Result<void> set_param(MapperParams& params, std::string_view name, const std::string& text);

}  // namespace extperfc::mapping
