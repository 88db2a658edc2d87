#include "extperfc/detect/inference.hpp"

#include <array>
#include <functional>
#include <numeric>
#include <utility>

namespace extperfc::detect {

namespace {

constexpr std::array<std::pair<Precision, const char*>, 3> kPrecisions{
    {{Precision::kF32, "f32"}, {Precision::kF16, "f16"}, {Precision::kBf16, "bf16"}}};
constexpr std::array<std::pair<Mode, const char*>, 2> kModes{
    {{Mode::kLatency, "latency"}, {Mode::kThroughput, "throughput"}}};

template <typename Table>
auto from_name(const Table& table, const std::string& what, const std::string& name)
    -> Result<decltype(table[0].first)> {
  std::string all;
  for (const auto& [value, known_name] : table) {
    if (name == known_name) return value;
    all += (all.empty() ? "" : ", ") + std::string(known_name);
  }
  return fail(ErrorCode::kInvalidArgument, "unknown " + what + " \"" + name + "\": use one of " + all);
}

template <typename Table, typename Value>
const char* name_of(const Table& table, Value value) {
  for (const auto& [candidate, known_name] : table)
    if (candidate == value) return known_name;
  return "unknown";
}

}  // namespace

Result<Precision> precision_from_name(const std::string& name) {
  return from_name(kPrecisions, "precision", name);
}
Result<Mode> mode_from_name(const std::string& name) {
  return from_name(kModes, "mode", name);
}
const char* to_string(Precision precision) {
  return name_of(kPrecisions, precision);
}
const char* to_string(Mode mode) {
  return name_of(kModes, mode);
}

std::size_t TensorView::size() const {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1},
                         [](std::size_t product, int n) { return product * static_cast<std::size_t>(n); });
}

}  // namespace extperfc::detect
