#include "translate/bridge/name_filter.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::translate {

namespace {

constexpr std::size_t kMaxRemembered = 20'000;

Result<std::vector<std::regex>> make_all(const std::vector<std::string>& texts, const std::string& what) {
  std::vector<std::regex> expressions;
  for (const auto& text : texts) {
    auto expression = make_expression(text, what);
    if (!expression) return tl::unexpected(expression.error());
    expressions.push_back(std::move(*expression));
  }
  return expressions;
}

bool any_matches(const std::vector<std::regex>& expressions, const std::string& name) {
  return std::any_of(expressions.begin(), expressions.end(),
                     [&](const auto& expression) { return std::regex_match(name, expression); });
}

}  // namespace

Result<std::regex> make_expression(const std::string& text, const std::string& what) {
  try {
    return std::regex(text, std::regex::ECMAScript | std::regex::optimize);
  } catch (const std::regex_error& error) {
    return fail(ErrorCode::kInvalidArgument,
                what + ": '" + text + "' is not a regular expression (" + error.what() + ")");
  }
}

Result<NameMatcher> NameMatcher::make(const NameFilter& filter, const std::string& what) {
  auto allow = make_all(filter.allow, what + "/allow");
  if (!allow) return tl::unexpected(allow.error());
  auto deny = make_all(filter.deny, what + "/deny");
  if (!deny) return tl::unexpected(deny.error());
  NameMatcher matcher;
  matcher.allow_ = std::move(*allow);
  matcher.deny_ = std::move(*deny);
  return matcher;
}

bool NameMatcher::matches(const std::string& name) {
  if (const auto found = known_.find(name); found != known_.end()) return found->second;
  if (known_.size() >= kMaxRemembered) known_.clear();
  return known_[name] = any_matches(allow_, name) && !any_matches(deny_, name);
}

Result<Profiles> Profiles::make(const std::vector<TopicProfile>& profiles) {
  Profiles made;
  for (const auto& profile : profiles) {
    auto expression = make_expression(profile.pattern, "profiles");
    if (!expression) return tl::unexpected(expression.error());
    if (profile.max_rate_hz < 0 || profile.max_age_s < 0)
      return fail(ErrorCode::kInvalidArgument,
                  "profiles: '" + profile.pattern + "' has a negative max_rate_hz or max_age_s");
    made.profiles_.emplace_back(std::move(*expression), profile);
  }
  return made;
}

const TopicProfile& Profiles::of(const std::string& topic) const {
  for (const auto& [expression, profile] : profiles_)
    if (std::regex_match(topic, expression)) return profile;
  return default_;
}

}  // namespace extperfc::translate
