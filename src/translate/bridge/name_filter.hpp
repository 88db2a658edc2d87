#pragma once

#include <map>
#include <regex>
#include <string>
#include <vector>

#include "extperfc/translate/bridge.hpp"

namespace extperfc::translate {

/// A compiled NameFilter. Caches its answers, since every poll of the graph asks for the same names.
class NameMatcher {
 public:
  [[nodiscard]] static Result<NameMatcher> make(const NameFilter& filter, const std::string& what);
  [[nodiscard]] bool matches(const std::string& name);

 private:
  std::vector<std::regex> allow_, deny_;
  std::map<std::string, bool> known_;
};

/// The compiled profiles.
class Profiles {
 public:
  [[nodiscard]] static Result<Profiles> make(const std::vector<TopicProfile>& profiles);
  /// The first matching profile, or the defaults.
  [[nodiscard]] const TopicProfile& of(const std::string& topic) const;

 private:
  std::vector<std::pair<std::regex, TopicProfile>> profiles_;
  TopicProfile default_;
};

/// Compiles an expression; the error shows it and where it was given.
[[nodiscard]] Result<std::regex> make_expression(const std::string& text, const std::string& what);

}  // namespace extperfc::translate
