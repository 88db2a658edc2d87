#include "extperfc/mapping/param_names.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>

#include "extperfc/base/text.hpp"

namespace extperfc::mapping {

namespace {

/// Parses the whole text as a number of this type, independent of the locale.
template <typename Number>
Result<Number> parse(std::string_view name, const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  Number value{};
  // Streams read "-1" into unsigned numbers, too.
  const bool has_sign = !std::numeric_limits<Number>::is_signed && text.find('-') != std::string::npos;
  if (!has_sign && (in >> value) && in.peek() == std::char_traits<char>::eof()) return value;
  return fail(ErrorCode::kInvalidArgument, std::string(name) + " must be " +
                                               (std::numeric_limits<Number>::is_integer ? "a whole " : "a ") +
                                               "number, not '" + text + "'");
}

template <typename Number>
Result<void> assign(MapperParams& params, Number MapperParams::*field, std::string_view name,
                    const std::string& text) {
  const auto value = parse<Number>(name, text);
  if (!value) return tl::unexpected(value.error());
  params.*field = *value;
  return {};
}

tl::unexpected<Error> unknown(std::string_view name) {
  std::vector<std::string> known;
  for (const ParamName& param : param_names()) known.emplace_back(param.name);
  return fail(ErrorCode::kInvalidArgument, "unknown mapper parameter '" + std::string(name) + "'" +
                                               hint_or_names(std::string(name), known));
}

}  // namespace

const std::vector<ParamName>& param_names() {
  using P = MapperParams;
  static const std::vector<ParamName> kNames = {
      {"particles", &P::particles, "", "hypotheses of the path, 1 to 1000"},
      {"delta", &P::resolution_m, "m", "side of a cell of the map, 0.01 to 1"},
      {"maxRange", &P::max_range_m, "m", "rays without return are free up to here; 0: they are not used"},
      {"maxUrange", &P::max_usable_range_m, "m", "returns beyond do not count; 0: the scan's range_max"},
      {"linearUpdate", &P::linear_update_m, "m", "a key frame after this translation, 0.05 to 5 ..."},
      {"angularUpdate", &P::angular_update_rad, "rad", "... or this rotation, 0.02 to 3.2 ..."},
      {"temporalUpdate", &P::temporal_update_s, "s", "... or this time; negative: never by time"},
      {"resampleThreshold", &P::resample_threshold, "",
       "resample below this fraction of effective particles, 0 to 1"},
      {"minimumScore", &P::minimum_score, "", "fraction of a scan that must fit the map for a match, 0 to 1"},
      {"srr", &P::srr, "m/m", "odometry's error in translation, by translation"},
      {"srt", &P::srt, "rad/m", "odometry's error in rotation, by translation"},
      {"str", &P::str, "m/rad", "odometry's error in translation, by rotation"},
      {"stt", &P::stt, "rad/rad", "odometry's error in rotation, by rotation"},
      {"occ_thresh", &P::occupied_threshold, "", "fraction of hits from which a cell is occupied, 0 to 1"},
      {"keptPasses", &P::kept_passes, "",
       "passes of a place seen often, old and new, whose scans stay, 0 to 100; 0: all"},
      {"seed", &P::seed, "", "of every random draw"},
  };
  return kNames;
}

std::string param_text(const MapperParams& params, const ParamName& name) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  std::visit([&](auto field) { out << params.*field; }, name.field);
  return out.str();
}

Result<void> set_param(MapperParams& params, std::string_view name, const std::string& text) {
  const auto& names = param_names();
  const auto found =
      std::find_if(names.begin(), names.end(), [&](const auto& known) { return known.name == name; });
  if (found == names.end()) return unknown(name);
  return std::visit([&](auto field) { return assign(params, field, found->name, text); }, found->field);
}

}  // namespace extperfc::mapping
