#include "translate/plan/numbers.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

namespace extperfc::translate {

namespace {

#if !defined(__BYTE_ORDER__) || __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "ROS messages are little-endian; plans copy numbers as they are, so this needs a little-endian machine"
#endif

/// By Primitive.
using Types = std::tuple<bool, std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t,
                         std::uint32_t, std::int64_t, std::uint64_t, float, double>;
constexpr std::size_t kTypes = std::tuple_size_v<Types>;

template <typename T>
T load(const std::uint8_t* bytes) {
  if constexpr (std::is_same_v<T, bool>) {
    return *bytes != 0;
  } else {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }
}

template <typename T>
void store(std::uint8_t* bytes, T value) {
  if constexpr (std::is_same_v<T, bool>) {
    *bytes = value ? 1 : 0;
  } else {
    std::memcpy(bytes, &value, sizeof value);
  }
}

template <typename To>
struct Fitted {
  To value{};
  bool fits{true};  ///< else `value` is the nearest
};

template <typename To, typename From>
Fitted<To> to_floating(From value) {
  if constexpr (std::is_same_v<From, double> && std::is_same_v<To, float>) {
    constexpr double kMax = std::numeric_limits<float>::max();
    if (std::isfinite(value) && std::abs(value) > kMax)
      return {static_cast<float>(std::copysign(kMax, value)), false};
  }
  return {static_cast<To>(value)};
}

template <typename To, typename From>
Fitted<To> round_to_integer(From value) {
  using Limits = std::numeric_limits<To>;
  const From rounded = std::nearbyint(value);
  constexpr From kLow = static_cast<From>(Limits::min());
  // The first power of two beyond: exact in both floating point types.
  constexpr From kBeyond = static_cast<From>(std::uint64_t{1} << (Limits::digits - 1)) * 2;
  if (rounded < kLow) return {Limits::min(), false};
  if (rounded >= kBeyond) return {Limits::max(), false};
  return {static_cast<To>(rounded)};
}

template <typename To, typename From>
Fitted<To> between_integers(From value) {
  using Limits = std::numeric_limits<To>;
  if constexpr (std::is_signed_v<From>) {
    if (value < 0) {
      if (static_cast<std::int64_t>(value) < static_cast<std::int64_t>(Limits::min()) ||
          !std::is_signed_v<To>)
        return {Limits::min(), false};
      return {static_cast<To>(value)};
    }
  }
  if (static_cast<std::uint64_t>(value) > static_cast<std::uint64_t>(Limits::max()))
    return {Limits::max(), false};
  return {static_cast<To>(value)};
}

template <typename To, typename From>
Fitted<To> fit(From value) {
  if constexpr (std::is_floating_point_v<To>) {
    return to_floating<To>(value);
  } else if constexpr (std::is_floating_point_v<From>) {
    return round_to_integer<To>(value);
  } else {
    return between_integers<To>(value);
  }
}

/// NaN has no nearest integer.
template <typename To, typename From>
bool has_place(From value) {
  if constexpr (std::is_floating_point_v<From> && !std::is_floating_point_v<To>) return !std::isnan(value);
  return true;
}

template <typename From, typename To>
std::size_t convert_all(bool saturate, const std::uint8_t* source, std::uint8_t* target, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = load<From>(source + i * sizeof(From));
    if (!has_place<To>(value)) return i;
    const auto fitted = fit<To>(value);
    if (!fitted.fits && !saturate) return i;
    store<To>(target + i * sizeof(To), fitted.value);
  }
  return count;
}

using Convert = std::size_t (*)(bool, const std::uint8_t*, std::uint8_t*, std::size_t);

template <std::size_t... Pairs>
constexpr std::array<Convert, sizeof...(Pairs)> make_table(std::index_sequence<Pairs...> /*pairs*/) {
  return {&convert_all<std::tuple_element_t<Pairs / kTypes, Types>,
                       std::tuple_element_t<Pairs % kTypes, Types>>...};
}

constexpr auto kTable = make_table(std::make_index_sequence<kTypes * kTypes>{});

Convert converter(Primitive from, Primitive to) {
  return kTable[static_cast<std::size_t>(from) * kTypes + static_cast<std::size_t>(to)];
}

}  // namespace

std::size_t convert_numbers(Primitive from, Primitive to, bool saturate, const std::uint8_t* source,
                            std::uint8_t* target, std::size_t count) {
  return converter(from, to)(saturate, source, target, count);
}

std::size_t scale_numbers(Primitive from, Primitive to, bool saturate, const Scale& scale,
                          const std::uint8_t* source, std::uint8_t* target, std::size_t count) {
  const auto read = converter(from, Primitive::kFloat64);
  const auto write = converter(Primitive::kFloat64, to);
  const auto from_size = *size_of(from);
  const auto to_size = *size_of(to);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<std::uint8_t, sizeof(double)> bytes{};
    if (read(false, source + i * from_size, bytes.data(), 1) == 0) return i;
    store(bytes.data(), load<double>(bytes.data()) * scale.factor + scale.offset);
    if (write(saturate, bytes.data(), target + i * to_size, 1) == 0) return i;
  }
  return count;
}

std::string number_text(Primitive primitive, const std::uint8_t* bytes) {
  if (primitive == Primitive::kUint64) return std::to_string(load<std::uint64_t>(bytes));
  if (primitive == Primitive::kFloat32 || primitive == Primitive::kFloat64) {
    const double value = primitive == Primitive::kFloat64 ? load<double>(bytes) : load<float>(bytes);
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.9g", value);
    return text.data();
  }
  std::array<std::uint8_t, sizeof(std::int64_t)> wide{};
  (void)convert_numbers(primitive, Primitive::kInt64, true, bytes, wide.data(), 1);
  return std::to_string(load<std::int64_t>(wide.data()));
}

}  // namespace extperfc::translate
