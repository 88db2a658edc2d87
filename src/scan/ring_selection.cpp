#include "extperfc/scan/ring_selection.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <sstream>

namespace extperfc::scan {

namespace {

std::optional<std::size_t> ring_number(const std::string& text) {
  std::size_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || value >= RingSet().size()) return std::nullopt;
  return value;
}

/// "4" or "4-11".
bool add(const std::string& part, RingSet& rings) {
  const auto dash = part.find('-');
  const auto first = ring_number(part.substr(0, dash));
  const auto last = dash == std::string::npos ? first : ring_number(part.substr(dash + 1));
  if (!first || !last || *first > *last) return false;
  for (std::size_t ring = *first; ring <= *last; ++ring) rings.set(ring);
  return true;
}

}  // namespace

Result<RingSet> parse_rings(const std::string& text) {
  std::string packed = text;
  packed.erase(std::remove_if(packed.begin(), packed.end(), [](unsigned char c) { return std::isspace(c); }),
               packed.end());
  if (!packed.empty() && packed.back() == ',') packed += '?';  // a comma wants a number behind it
  RingSet rings;
  std::istringstream parts(packed);
  for (std::string part; std::getline(parts, part, ',');)
    if (!add(part, rings))
      return fail(
          ErrorCode::kInvalidArgument,
          "rings: '" + text + "' is not a list of ring numbers from 0 to 255, e.g. 7 or 4-11 or 1,3,8-15");
  return rings;
}

}  // namespace extperfc::scan
