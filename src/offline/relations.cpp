#include "extperfc/offline/relations.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <locale>
#include <sstream>
#include <string>

#include "extperfc/base/math.hpp"
#include "extperfc/base/number_reader.hpp"

namespace extperfc::offline {

namespace {

constexpr double kMaxScans = 1e8;

Result<Relation> parse_relation(const std::string& line) {
  TokenReader in(line);
  constexpr std::size_t kColumns = 8;
  std::array<double, kColumns> value{};
  for (auto& number : value) {
    const auto read = in.number();
    if (!read)
      return fail(ErrorCode::kCorrupt,
                  "expected 'i j x y z roll pitch yaw', found '" + line.substr(0, 80) + "'");
    number = *read;
  }
  const auto is_scan = [](double number) {
    return number >= 0 && number < kMaxScans && number == std::floor(number);
  };
  if (!is_scan(value[0]) || !is_scan(value[1]))
    return fail(ErrorCode::kCorrupt,
                "the scans of '" + line.substr(0, 80) + "' are no whole numbers from 0 on");
  return Relation{static_cast<std::size_t>(value[0]),
                  static_cast<std::size_t>(value[1]),
                  {value[2], value[3], wrap_angle(value[7])}};
}

std::size_t span(const Relation& relation) {
  return relation.to > relation.from ? relation.to - relation.from : relation.from - relation.to;
}

void mean_and_deviation(const std::vector<double>& values, double& mean, double& deviation) {
  mean = deviation = 0;
  if (values.empty()) return;
  const auto n = static_cast<double>(values.size());
  for (const double value : values) mean += value / n;
  for (const double value : values) deviation += (value - mean) * (value - mean) / n;
  deviation = std::sqrt(deviation);
}

ErrorStatistics statistics_of(std::vector<double> errors) {
  ErrorStatistics statistics;
  mean_and_deviation(errors, statistics.mean, statistics.deviation);
  if (!errors.empty()) statistics.worst = *std::max_element(errors.begin(), errors.end());
  for (auto& error : errors) error *= error;
  mean_and_deviation(errors, statistics.squared_mean, statistics.squared_deviation);
  return statistics;
}

GroupScore group_of(const RelationsScore& score, const std::function<bool(std::size_t)>& belongs) {
  std::vector<double> translations;
  std::vector<double> rotations;
  for (const auto& error : score.errors) {
    if (!belongs(error.relation)) continue;
    translations.push_back(error.translation_m);
    rotations.push_back(error.rotation_deg);
  }
  return {translations.size(), statistics_of(translations), statistics_of(rotations)};
}

}  // namespace

Result<std::vector<Relation>> read_relations(const std::filesystem::path& file) {
  std::error_code error;
  std::ifstream in(file);
  if (!in || std::filesystem::is_directory(file, error))
    return fail(ErrorCode::kNotFound, "cannot read the relations " + file.string());
  std::vector<Relation> relations;
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const auto first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const auto relation = parse_relation(line);
    if (!relation)
      return fail(relation.error().code,
                  file.string() + " line " + std::to_string(number) + ": " + relation.error().message);
    relations.push_back(*relation);
  }
  if (relations.empty()) return fail(ErrorCode::kCorrupt, file.string() + " holds no relations");
  return relations;
}

RelationsScore score_relations(const std::vector<Relation>& relations,
                               const std::vector<std::optional<Pose2>>& poses, const ScoreOptions& options) {
  const auto scanner_at = [&](std::size_t scan) { return compose(*poses[scan], options.base_T_scanner); };
  RelationsScore score;
  for (std::size_t i = 0; i < relations.size(); ++i) {
    const auto& relation = relations[i];
    const bool known = relation.from < poses.size() && relation.to < poses.size() && poses[relation.from] &&
                       poses[relation.to];
    if (!known) {
      ++score.unmatched;
      continue;
    }
    const Pose2 estimated = between(scanner_at(relation.from), scanner_at(relation.to));
    const Pose2 error = between(relation.from_T_to, estimated);
    score.errors.push_back({i, std::hypot(error.x, error.y), std::abs(error.yaw) / kDegree});
  }
  const auto is_loop = [&](std::size_t i) { return span(relations[i]) > options.loop_span; };
  score.all = group_of(score, [](std::size_t) { return true; });
  score.neighbours = group_of(score, [&](std::size_t i) { return !is_loop(i); });
  score.loops = group_of(score, is_loop);
  return score;
}

std::vector<RelationError> worst_relations(const RelationsScore& score, std::size_t count) {
  std::vector<RelationError> worst(std::min(count, score.errors.size()));
  std::partial_sort_copy(
      score.errors.begin(), score.errors.end(), worst.begin(), worst.end(),
      [](const RelationError& a, const RelationError& b) { return a.translation_m > b.translation_m; });
  return worst;
}

}  // namespace extperfc::offline
