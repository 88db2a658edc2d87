#pragma once

#include <ostream>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "extperfc/offline/relations.hpp"

namespace extperfc::offline {

/// Table of the groups, and the `worst` relations with the largest errors.
void print_score(std::ostream& out, const std::vector<Relation>& relations, const RelationsScore& score,
                 std::size_t worst);

/// The same for programs.
[[nodiscard]] nlohmann::json score_json(const std::vector<Relation>& relations, const RelationsScore& score,
                                        std::size_t worst);

}  // namespace extperfc::offline
